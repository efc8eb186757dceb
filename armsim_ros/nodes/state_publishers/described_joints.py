# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The joints of a description as joint_state_publisher reads them: URDF, SDF or COLLADA."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
import math

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
