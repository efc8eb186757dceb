# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The joint states that joint_state_publisher publishes, of joints in URDF, SDF or COLLADA."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
import math
from typing import TypeAlias

from armsim_ros.errors import ModelError, Problem
from armsim_ros.model.description.xml_tree import parse_xml, XmlElement

#: Types of joints that are not published.
_NOT_IN_URDF = ('fixed', 'floating', 'planar')
_NOT_IN_SDF = ('gearbox', 'revolute2', 'ball', 'screw', 'universal', 'fixed')
_OLDEST_COLLADA = (1, 5, 0)


@dataclass(frozen=True, slots=True)
class DescribedJoint:
    """
    A joint that moves.

    :param lower: [rad or m].
    :param upper: [rad or m].
    :param soft: bounds of ``<safety_controller>`` [rad or m].
    :param mimic: joint, multiplier, offset.
    """

    name: str
    lower: float
    upper: float
    continuous: bool = False
    soft: tuple[float, float] = (-math.inf, math.inf)
    mimic: tuple[str, float, float] | None = None


def described_joints(text: str) -> list[DescribedJoint]:
    """
    Return the joints that move, in their order.

    :raises ModelError: the text is none of the three, or a joint has no limits.
    """
    root = parse_xml(text, 'robot_description')
    if root.tag == 'sdf':
        model = _inside(root, 'model')
        return [_joint_of_sdf(joint) for joint in model.all('joint')
                if joint.get('type') not in _NOT_IN_SDF]
    if root.tag == 'COLLADA':
        return list(_joints_of_collada(root))
    robot = root if root.tag == 'robot' else _inside(root, 'robot')
    return [_joint_of_urdf(joint) for joint in robot.all('joint')
            if joint.get('type') not in _NOT_IN_URDF]


def _joint_of_urdf(element: XmlElement) -> DescribedJoint:
    name, continuous = element.get('name'), element.get('type') == 'continuous'
    lower, upper = -math.pi, math.pi
    if not continuous:
        limit = _inside(element, 'limit')
        lower, upper = (_attribute(limit, key, name) for key in ('lower', 'upper'))
    soft, mimic = (-math.inf, math.inf), None
    safety = element.first('safety_controller')
    if safety is not None:
        soft = (_attribute(safety, 'soft_lower_limit', name, -math.inf),
                _attribute(safety, 'soft_upper_limit', name, math.inf))
    following = element.first('mimic')
    if following is not None:
        mimic = (following.get('joint'), _attribute(following, 'multiplier', name, 1.0),
                 _attribute(following, 'offset', name, 0.0))
    return DescribedJoint(name, lower, upper, continuous, soft, mimic)


def _joint_of_sdf(element: XmlElement) -> DescribedJoint:
    name = element.get('name')
    if element.get('type') == 'continuous':
        return DescribedJoint(name, -math.pi, math.pi, continuous=True)
    limit = _inside(element, 'limit')
    return DescribedJoint(name, _content(limit, 'lower', name), _content(limit, 'upper', name))


def _joints_of_collada(root: XmlElement) -> Iterator[DescribedJoint]:
    version = root.get('version')
    numbers = version.split('.')
    if not all(map(str.isdigit, numbers)) or tuple(map(int, numbers)) < _OLDEST_COLLADA:
        raise ModelError(Problem(f"COLLADA has the version '{version}'", root.where,
                                 '1.5.0 and later'))
    for element in _inside(_inside(root, 'kinematics_model'), 'technique_common').all('joint'):
        name = element.get('name')
        revolute = next(_all_inside(element, 'revolute'), None)
        if revolute is None:
            continue
        limits = _inside(revolute, 'limits')
        lower, upper = (_content(limits, key, name) for key in ('min', 'max'))
        if lower != upper:
            yield DescribedJoint(name, math.radians(lower), math.radians(upper))


def _all_inside(element: XmlElement, tag: str) -> Iterator[XmlElement]:
    for child in element.children:
        if child.tag == tag:
            yield child
        yield from _all_inside(child, tag)


def _inside(element: XmlElement, tag: str) -> XmlElement:
    found = next(_all_inside(element, tag), None)
    if found is None:
        name = element.get('name')
        raise ModelError(Problem(
            f"<{element.tag}{' name=' * bool(name)}{name}> has no <{tag}>", element.where))
    return found


def _attribute(element: XmlElement, key: str, joint: str, default: float | None = None) -> float:
    if key not in element.attributes and default is not None:
        return default
    return _number(element.get(key), key, joint, element)


def _content(element: XmlElement, key: str, joint: str) -> float:
    return _number(_inside(element, key).content, key, joint, element)


def _number(text: str, key: str, joint: str, element: XmlElement) -> float:
    try:
        return float(text)
    except ValueError:
        raise ModelError(Problem(f"'{key}' of joint '{joint}' is '{text}'", element.where,
                                 'a number')) from None


#: Fields of a joint state, in the order of JointState.
FIELDS = ('position', 'velocity', 'effort')

Values: TypeAlias = dict[str, list[float]]


class DependentJointError(ModelError):
    """A dependent joint follows itself in the end, or no joint that is published."""


@dataclass(frozen=True, slots=True)
class JointStateOptions:
    """
    Parameters of joint_state_publisher that bear on its joints.

    :param use_mimic_tags: whether ``<mimic>`` makes a joint dependent.
    :param use_smallest_joint_limits: whether ``<safety_controller>`` narrows the range.
    :param zeros: joint -> first position [rad or m].
    :param defaults: those of ``FIELDS`` that free joints have without a source.
    """

    use_mimic_tags: bool = True
    use_smallest_joint_limits: bool = True
    zeros: Mapping[str, float] = field(default_factory=dict)
    defaults: Sequence[str] = ('position',)


@dataclass(slots=True)
class _FreeJoint:
    lower: float
    upper: float
    continuous: bool
    values: dict[str, float]
    forward: bool = True


class JointStates:
    """
    The joints of a description and where they are.

    :param text: the description.
    :raises ModelError: the text is not a description, or a joint has no limits.
    """

    def __init__(self, text: str, options: JointStateOptions) -> None:
        #: All joints, in the description's order.
        self.names: list[str] = []
        self._free: dict[str, _FreeJoint] = {}
        self._dependent: dict[str, tuple[str, float, float]] = {}
        for joint in described_joints(text):
            self._add(joint, options)

    def take(self, names: Sequence[str], **values: Sequence[float]) -> None:
        """
        Take over a source's values for the free joints.

        :param values: position [rad or m], velocity, effort; empty where it has none.
        """
        for i, name in enumerate(names):
            joint = self._free.get(name)
            if joint is not None:
                joint.values.update((kind, given[i]) for kind, given in values.items()
                                    if i < len(given))

    def step(self, delta: float) -> None:
        """Move each free joint on between its limits by ``delta`` [rad or m]."""
        for joint in self._free.values():
            position = joint.values.get('position', 0.0) + (delta if joint.forward else -delta)
            if joint.forward and position > joint.upper:
                joint.forward = joint.continuous
                position = joint.lower if joint.continuous else joint.upper
            elif not joint.forward and position < joint.lower:
                joint.forward, position = True, joint.lower
            joint.values['position'] = position

    def state(self) -> Values:
        """
        Return position, velocity and effort of all joints; empty where no joint has any.

        :raises DependentJointError: a dependent joint follows no free joint.
        """
        found: Values = {}
        leaders = [self._leader(name) for name in self.names]
        for kind in FIELDS:
            given = any(kind in joint.values for joint in self._free.values())
            if not given and not (kind == 'position' and self._dependent):
                found[kind] = []
                continue
            scales = [(joint.values.get(kind), factor, offset)
                      for joint, factor, offset in leaders]
            found[kind] = [0.0 if value is None else self._following(kind, value, factor, offset)
                           for value, factor, offset in scales]
        return found

    @staticmethod
    def _following(kind: str, value: float, factor: float, offset: float) -> float:
        if kind == 'effort':
            return value
        return value * factor + (offset if kind == 'position' else 0.0)

    def _leader(self, name: str) -> tuple[_FreeJoint, float, float]:
        """Return the free joint that a joint follows, with factor and offset."""
        factor, offset = 1.0, 0.0
        passed = [name]
        while name not in self._free:
            name, own_factor, own_offset = self._dependent[name]
            if name not in self.names:
                raise DependentJointError(Problem(
                    f"dependent joint '{passed[-1]}' follows '{name}', which does not move"))
            if name in passed:
                raise DependentJointError(Problem(
                    f"dependent joints follow each other: {' -> '.join((*passed, name))}"))
            passed.append(name)
            offset += factor * own_offset
            factor *= own_factor
        return self._free[name], factor, offset

    def _add(self, joint: DescribedJoint, options: JointStateOptions) -> None:
        self.names.append(joint.name)
        if options.use_mimic_tags and joint.mimic is not None:
            self._dependent[joint.name] = joint.mimic
            return
        lower, upper = joint.lower, joint.upper
        if options.use_smallest_joint_limits:
            lower, upper = max(lower, joint.soft[0]), min(upper, joint.soft[1])
        first = options.zeros.get(joint.name)
        if first is None:
            first = 0.0 if lower <= 0.0 <= upper else 0.5 * (lower + upper)
        values = {kind: first if kind == 'position' else 0.0 for kind in options.defaults}
        self._free[joint.name] = _FreeJoint(lower, upper, joint.continuous, values)
