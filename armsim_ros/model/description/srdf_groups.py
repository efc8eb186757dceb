# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Planning groups of an SRDF: chains, joints, links and other groups to a list of joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

from armsim_ros.errors import nearest
from armsim_ros.model.description.xml_tree import TextReport, unknown, XmlElement
from armsim_ros.model.robot_model import Joint, JointType
from armsim_ros.model.semantic_model import PlanningGroup


class GroupBuilder:
    """
    Builds the groups of an SRDF.

    :param joints: the robot's joints, in tree order.
    :param report: takes what is skipped.
    """

    def __init__(self, joints: Mapping[str, Joint], report: TextReport) -> None:
        self._joints, self._report = joints, report
        self._above = {joint.child: name for name, joint in joints.items()}
        self._links = {*self._above, *(joint.parent for joint in joints.values())}

    def build(self, elements: Mapping[str, XmlElement]) -> dict[str, PlanningGroup]:
        """
        Return the groups that have joints, in the order of the SRDF.

        :param elements: name -> ``<group>``.
        """
        members: dict[str, set[str] | None] = {}
        for name in elements:
            self._collect(name, elements, members, ())
        groups: dict[str, PlanningGroup] = {}
        for name, element in elements.items():
            found = members.get(name)
            if found:
                groups[name] = self._group(name, element, found)
            elif found is not None:
                self._report.warning(f"planning group '{name}' has no joints and is left out",
                                     element.where)
        return {name: replace(group, subgroups=_subgroups(group, groups))
                for name, group in groups.items()}

    def _collect(self, name: str, elements: Mapping[str, XmlElement],
                 members: dict[str, set[str] | None], stack: tuple[str, ...]) -> None:
        """Fill ``members[name]``; None for a group that contains itself."""
        if name in members:
            return
        if name in stack:
            way = ' -> '.join([*stack[stack.index(name):], name])
            self._report.warning(f'planning groups contain each other ({way}); they are left '
                                 'out', elements[name].where)
            for member in stack[stack.index(name):]:
                members[member] = None
            return
        found: set[str] = set()
        for part in elements[name].children:
            if part.tag == 'chain':
                found |= self._chain(name, part)
            elif part.tag == 'joint':
                found |= self._joint(name, part)
            elif part.tag == 'link':
                found |= self._link(name, part)
            elif part.tag == 'group':
                found |= self._subgroup(name, part, elements, members, stack)
        members.setdefault(name, found)

    def _chain(self, group: str, element: XmlElement) -> set[str]:
        base, tip = element.get('base_link'), element.get('tip_link')
        for link in (base, tip):
            if link not in self._links:
                what, hint = unknown('link', link, tuple(self._links))
                self._report.warning(f"chain of planning group '{group}' is left out: {what}",
                                     element.where, hint)
                return set()
        up_from_tip, up_from_base = self._way_up(tip), self._way_up(base)
        # What both ways share lies above their common link and is not part of the chain, but for
        # its first joint where the base is not above the tip: robot_model.cpp, addJointModelGroup.
        shared = [joint for joint in up_from_base if joint in up_from_tip]
        straight = len(shared) == len(up_from_base)
        return (set(up_from_tip) ^ set(up_from_base)).union([] if straight else shared[:1])

    def _way_up(self, link: str) -> list[str]:
        way = []
        while link in self._above:
            way.append(self._above[link])
            link = self._joints[way[-1]].parent
        return way

    def _joint(self, group: str, element: XmlElement) -> set[str]:
        name = element.get('name')
        if name in self._joints:
            return {name}
        what, hint = unknown('joint', name, tuple(self._joints))
        self._report.warning(f"planning group '{group}': {what}; it is left out", element.where,
                             hint)
        return set()

    def _link(self, group: str, element: XmlElement) -> set[str]:
        name = element.get('name')
        if name in self._above:
            return {self._above[name]}
        if name not in self._links:
            what, hint = unknown('link', name, tuple(self._links))
            self._report.warning(f"planning group '{group}': {what}; it is left out",
                                 element.where, hint)
        return set()

    def _subgroup(self, group: str, element: XmlElement, elements: Mapping[str, XmlElement],
                  members: dict[str, set[str] | None], stack: tuple[str, ...]) -> set[str]:
        name = element.get('name')
        if name not in elements:
            self._report.warning(
                f"planning group '{group}' contains '{name}', which is not in the SRDF",
                element.where, nearest(name, tuple(elements)))
            return set()
        self._collect(name, elements, members, (*stack, group))
        return members.get(name) or set()

    def _group(self, name: str, element: XmlElement, found: set[str]) -> PlanningGroup:
        joints = tuple(joint for joint in self._joints if joint in found)
        active = tuple(joint for joint in joints if self._joints[joint].active)
        links = tuple(self._joints[joint].child for joint in joints)
        chain = self._as_chain(element, joints)
        tips = (chain[1],) if chain else self._ends(joints)
        return PlanningGroup(name, joints, active, links, chain, tips)

    def _as_chain(self, element: XmlElement, joints: tuple[str, ...]) -> tuple[str, str] | None:
        """Return base and tip link where every joint follows on its predecessor."""
        parts = [part for part in element.children
                 if part.tag in ('chain', 'joint', 'link', 'group')]
        follows = all(self._precedes(before, after) for before, after in pairwise(joints))
        if not follows:
            return None
        if len(parts) == 1 and parts[0].tag == 'chain':
            return parts[0].get('base_link'), parts[0].get('tip_link')
        return self._joints[joints[0]].parent, self._joints[joints[-1]].child

    def _precedes(self, before: str, after: str) -> bool:
        """Whether only fixed joints lie between two joints."""
        name = self._above.get(self._joints[after].parent)
        while name is not None and name != before:
            if self._joints[name].type is not JointType.FIXED:
                return False
            name = self._above.get(self._joints[name].parent)
        return name == before

    def _ends(self, joints: tuple[str, ...]) -> tuple[str, ...]:
        """Return the child links below which the group has no further joint."""
        above: set[str] = set()
        for joint in joints:
            above.update(self._way_up(self._joints[joint].parent))
        return tuple(self._joints[joint].child for joint in joints if joint not in above)


def _subgroups(group: PlanningGroup, groups: Mapping[str, PlanningGroup]) -> tuple[str, ...]:
    """Return the groups whose joints are all in a group, by name (buildGroupsInfoSubgroups)."""
    joints = set(group.joints)
    return tuple(name for name in sorted(groups)
                 if name != group.name and joints.issuperset(groups[name].joints))
