# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""SRDF text to the semantic model that holds for a robot."""

from __future__ import annotations

from collections.abc import Mapping
import math

from armsim_ros.errors import Location, nearest, Problem
from armsim_ros.model.description.srdf_groups import GroupBuilder
from armsim_ros.model.description.xml_tree import parse_xml, TextReport, unknown, XmlElement
from armsim_ros.model.robot_model import Joint, Link
from armsim_ros.model.semantic_model import EndEffector, PlanningGroup, SemanticModel, VirtualJoint

_VIRTUAL_TYPES = ('fixed', 'planar', 'floating')
_KNOWN_TAGS = (
    'group', 'group_state', 'end_effector', 'virtual_joint', 'passive_joint',
    'disable_collisions', 'enable_collisions', 'disable_default_collisions', 'joint_property',
    'link_sphere_approximation')

Pair = tuple[str, str]


class SrdfContent:
    """
    What an SRDF holds.

    :param semantic: what fits the robot.
    :param places: 'group x', 'state g/x' ... -> where it is written.
    :param problems: warnings and remarks: every element that was left out, and why.
    """

    def __init__(self, semantic: SemanticModel, places: dict[str, Location],
                 problems: tuple[Problem, ...]) -> None:
        self.semantic, self.places, self.problems = semantic, places, problems


def parse_srdf(text: str, file: str, *, robot_name: str, root_link: str,
               links: Mapping[str, Link], joints: Mapping[str, Joint]) -> SrdfContent:
    """
    Parse an SRDF for a robot.

    Elements that name what the robot has not are left out, each with a warning.

    :param text: the text after xacro.
    :param file: the name that messages give.
    :param joints: in tree order; groups take their order from it.
    :raises ModelError: where the text is not an SRDF, or none of its groups fits the robot.
    """
    return read_srdf(parse_xml(text, file), robot_name=robot_name, root_link=root_link,
                     links=links, joints=joints)


def read_srdf(root: XmlElement, *, robot_name: str, root_link: str,
              links: Mapping[str, Link], joints: Mapping[str, Joint]) -> SrdfContent:
    """
    Read an SRDF that was parsed already.

    :param root: its root element.
    :raises ModelError: as :func:`parse_srdf`.
    """
    return _Reader(root, robot_name, root_link, links, joints).read()


class _Reader:
    """A pass over an SRDF."""

    def __init__(self, root: XmlElement, robot_name: str, root_link: str,
                 links: Mapping[str, Link], joints: Mapping[str, Joint]) -> None:
        self._root, self._robot_name, self._root_link = root, robot_name, root_link
        self._links, self._joints = links, joints
        self._report = TextReport()
        self._places: dict[str, Location] = {}

    def read(self) -> SrdfContent:
        if self._root.tag != 'robot':
            self._report.error(f'the root element is <{self._root.tag}>', self._root.where,
                               '<robot>')
            self._report.raise_errors()
        passive = self._passive_joints()
        groups = self._groups()
        enabled = self._pairs('enable_collisions')
        semantic = SemanticModel(
            name=self._root.get('name'), groups=groups, named_states=self._states(groups),
            end_effectors=self._end_effectors(groups), virtual_joint=self._virtual_joint(),
            passive_joints=passive, disabled_collisions=self._pairs('disable_collisions'),
            enabled_collisions=frozenset(enabled), default_disabled=self._default_disabled())
        self._check_owner(groups)
        for element in self._root.children:
            if element.tag not in _KNOWN_TAGS:
                self._report.warning(f'<{element.tag}> is not known and has no effect',
                                     element.where, nearest(element.tag, _KNOWN_TAGS))
        self._report.raise_errors()
        return SrdfContent(semantic, self._places, tuple(self._report.problems))

    def _check_owner(self, groups: Mapping[str, PlanningGroup]) -> None:
        """Report an SRDF that was written for another robot."""
        written = [element.get('name') for element in self._root.all('group')]
        name = self._root.get('name')
        if written and not groups:
            reasons = [problem.what for problem in self._report.problems]
            self._report.error(
                f"none of the planning groups {', '.join(written)} fits robot "
                f"'{self._robot_name}'" + (f'; first: {reasons[0]}' if reasons else ''),
                self._root.where, remedy=f"is this the SRDF of another robot, '{name}'?")
        elif name and name != self._robot_name:
            self._report.warning(
                f"the SRDF is for robot '{name}', the URDF for '{self._robot_name}'",
                self._root.where, 'give both the same name')

    def _passive_joints(self) -> tuple[str, ...]:
        names = []
        for element in self._root.all('passive_joint'):
            name = element.get('name')
            if name in self._joints:
                names.append(name)
            elif name != self._virtual_name():
                self._skip('passive joint', 'joint', name, element, tuple(self._joints))
        return tuple(dict.fromkeys(names))

    def _virtual_name(self) -> str:
        element = self._root.first('virtual_joint')
        return element.get('name') if element is not None else ''

    def _groups(self) -> dict[str, PlanningGroup]:
        elements: dict[str, XmlElement] = {}
        for element in self._root.all('group'):
            name = element.get('name')
            if not name:
                self._report.ignored("<group> has no 'name'; it is left out", element.where)
            elif name in elements:
                self._report.warning(
                    f"planning group '{name}' is defined twice; the first is used", element.where)
            else:
                elements[name] = element
                self._places[f'group {name}'] = element.where
        return GroupBuilder(self._joints, self._report).build(elements)

    def _states(self, groups: Mapping[str, PlanningGroup]
                ) -> dict[str, dict[str, dict[str, float]]]:
        states: dict[str, dict[str, dict[str, float]]] = {}
        for element in self._root.all('group_state'):
            name, group = element.get('name'), element.get('group')
            if group not in groups:
                self._report.warning(
                    f"named state '{name}' is left out: planning group '{group}' is not in the "
                    'SRDF', element.where, nearest(group, tuple(groups)))
                continue
            if name in states.get(group, {}):
                self._report.warning(
                    f"named state '{name}' of group '{group}' is defined twice; the last is used",
                    element.where)
            values = {}
            for part in element.all('joint'):
                value = self._state_value(name, groups[group], part)
                if value is not None:
                    values[part.get('name')] = value
            states.setdefault(group, {})[name] = values
            self._places[f'state {group}/{name}'] = element.where
        return states

    def _state_value(self, state: str, group: PlanningGroup, element: XmlElement) -> float | None:
        """Return the value of a joint in a named state, None where it is left out."""
        joint = element.get('name')
        title = f"named state '{state}'"
        if joint not in group.joints:
            known = group.joints if joint in self._joints else tuple(self._joints)
            what = (f"joint '{joint}' is not in group '{group.name}'" if joint in self._joints
                    else unknown('joint', joint, known)[0])
            self._report.warning(f'{title}: {what}; it is left out', element.where,
                                 nearest(joint, known))
            return None
        try:
            value = float(element.get('value'))
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            self._report.warning(
                f"{title}: value '{element.get('value')}' of joint '{joint}' is not a finite "
                'number; it is left out', element.where)
            return None
        limits = self._joints[joint].limits
        if not limits.lower - 1e-6 <= value <= limits.upper + 1e-6:
            self._report.warning(
                f"{title}: {value:g} of joint '{joint}' is outside its limits "
                f'{limits.lower:g} .. {limits.upper:g}', element.where,
                'a goal at this state ends at the limit')
        return value

    def _end_effectors(self, groups: Mapping[str, PlanningGroup]) -> dict[str, EndEffector]:
        found = {}
        for element in self._root.all('end_effector'):
            name, link = element.get('name'), element.get('parent_link')
            group = element.get('group') or element.get('component_group')
            if link not in self._links:
                self._skip(f"end effector '{name}'", 'link', link, element, tuple(self._links))
            elif group not in groups:
                self._report.warning(
                    f"end effector '{name}' is left out: planning group '{group}' is not in the "
                    'SRDF', element.where, nearest(group, tuple(groups)))
            else:
                found[name] = EndEffector(
                    name, group, link, self._parent_group(element, groups, group, link))
        return found

    def _parent_group(self, element: XmlElement, groups: Mapping[str, PlanningGroup],
                      group: str, link: str) -> str:
        """Return the group that carries an end effector: the named group, else the smallest."""
        fitting = [name for name in sorted(groups) if name != group and link in groups[name].links]
        named = element.get('parent_group')
        if named in fitting:
            return named
        if named:
            self._report.warning(
                f"end effector '{element.get('name')}': parent group '{named}' does not contain "
                f"'{link}', or is its own", element.where)
        return min(fitting, key=lambda name: len(groups[name].joints), default='')

    def _virtual_joint(self) -> VirtualJoint | None:
        for element in self._root.all('virtual_joint'):
            name, kind = element.get('name'), element.get('type').lower()
            child = element.get('child_link')
            if kind and kind not in _VIRTUAL_TYPES:
                self._report.warning(f"virtual joint '{name}' is taken as fixed: its type is "
                                     f"'{kind}'", element.where,
                                     'use one of ' + ', '.join(_VIRTUAL_TYPES))
                kind = 'fixed'
            if not kind:
                self._report.warning(f"virtual joint '{name}' is left out: it has no type",
                                     element.where, 'use one of ' + ', '.join(_VIRTUAL_TYPES))
            elif child != self._root_link:
                self._report.warning(
                    f"virtual joint '{name}' is left out: its child link '{child}' is not the "
                    f"root link '{self._root_link}'", element.where)
            elif not element.get('parent_frame'):
                self._report.warning(f"virtual joint '{name}' is left out: it has no "
                                     'parent_frame', element.where)
            else:
                return VirtualJoint(name, kind, element.get('parent_frame'), child)
        return None

    def _pairs(self, tag: str) -> dict[Pair, str]:
        pairs: dict[Pair, str] = {}
        for element in self._root.all(tag):
            first, second = element.get('link1'), element.get('link2')
            missing = [link for link in (first, second) if link not in self._links]
            if missing:
                self._skip(f'<{tag}>', 'link', missing[0], element, tuple(self._links))
                continue
            pairs[(min(first, second), max(first, second))] = element.get('reason')
        return pairs

    def _default_disabled(self) -> frozenset[str]:
        names = []
        for element in self._root.all('disable_default_collisions'):
            link = element.get('link')
            if link in self._links:
                names.append(link)
            else:
                self._skip(f'<{element.tag}>', 'link', link, element, tuple(self._links))
        return frozenset(names)

    def _skip(self, title: str, kind: str, name: str, element: XmlElement,
              known: tuple[str, ...]) -> None:
        what, hint = unknown(kind, name, known)
        self._report.warning(f'{title} is left out: {what}', element.where, hint)
