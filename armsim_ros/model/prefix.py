# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot under other names: links, joints, planning groups, in the model and in its texts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from armsim_ros.model.description.srdf import read_srdf
from armsim_ros.model.description.xml_tree import parse_xml, xml_text, XmlElement
from armsim_ros.model.robot_model import HardwareSystem, Joint, RobotModel
from armsim_ros.model.semantic_model import SemanticModel

#: Element of a URDF -> its attributes that hold a name of this robot.
_URDF_NAMES: Mapping[str, tuple[str, ...]] = {
    'link': ('name',), 'joint': ('name',), 'parent': ('link',), 'child': ('link',),
    'mimic': ('joint',), 'material': ('name',), 'transmission': ('name',), 'actuator': ('name',),
    'ros2_control': ('name',), 'gazebo': ('reference',),
}
#: The same of an SRDF.
_SRDF_NAMES: Mapping[str, tuple[str, ...]] = {
    'group': ('name',), 'link': ('name',), 'joint': ('name',), 'chain': ('base_link', 'tip_link'),
    'group_state': ('group',),
    'end_effector': ('name', 'parent_link', 'group', 'component_group', 'parent_group'),
    'virtual_joint': ('child_link',), 'passive_joint': ('name',),
    'disable_collisions': ('link1', 'link2'), 'enable_collisions': ('link1', 'link2'),
    'disable_default_collisions': ('link',), 'joint_property': ('joint_name',),
    'link_sphere_approximation': ('link',),
}
#: What other programs read has names of its own inside.
_CLOSED = ('gazebo',)


def prefixed_model(model: RobotModel, prefix: str, *, urdf_file: str, srdf_file: str
                   ) -> RobotModel:
    """
    Return a robot whose links, joints, planning groups and end effectors have a prefix.

    Named states keep their names; they belong to their group.

    :param urdf_file: the name of the URDF in messages.
    :param srdf_file: the name of the SRDF in messages.
    """
    links = {prefix + name: replace(link, name=prefix + name)
             for name, link in model.links.items()}
    joints = {prefix + name: _joint(joint, prefix) for name, joint in model.joints.items()}
    root_link = prefix + model.root_link
    srdf, semantic = '', SemanticModel()
    if model.srdf:
        root = prefixed_srdf(model.srdf, srdf_file, prefix)
        srdf = xml_text(root)
        semantic = read_srdf(root, robot_name=model.name, root_link=root_link, links=links,
                             joints=joints).semantic
    hardware = tuple(_hardware(system, prefix) for system in model.hardware)
    return RobotModel(model.name, links, joints, root_link, semantic, hardware,
                      xml_text(prefixed_urdf(model.urdf, urdf_file, prefix)), srdf)


def prefixed_urdf(text: str, file: str, prefix: str) -> XmlElement:
    """Return a URDF with every name of the robot prefixed."""
    return _prefixed(parse_xml(text, file), _URDF_NAMES, prefix)


def prefixed_srdf(text: str, file: str, prefix: str) -> XmlElement:
    """Return an SRDF with every name of the robot prefixed."""
    return _prefixed(parse_xml(text, file), _SRDF_NAMES, prefix)


def _prefixed(element: XmlElement, names: Mapping[str, tuple[str, ...]], prefix: str
              ) -> XmlElement:
    attributes = {
        key: prefix + value.strip() if value and key in names.get(element.tag, ()) else value
        for key, value in element.attributes.items()}
    children = (element.children if element.tag in _CLOSED
                else [_prefixed(child, names, prefix) for child in element.children])
    return replace(element, attributes=attributes, children=children)


def _hardware(system: HardwareSystem, prefix: str) -> HardwareSystem:
    joints = tuple(replace(joint, name=prefix + joint.name) for joint in system.joints)
    sensors = tuple(replace(sensor, name=prefix + sensor.name, frame=prefix + sensor.frame)
                    for sensor in system.sensors)
    states = {prefix + name: value for name, value in system.other_states.items()}
    commands = tuple(prefix + name for name in system.other_commands)
    return replace(system, name=prefix + system.name, joints=joints, sensors=sensors,
                   other_states=states, other_commands=commands)


def _joint(joint: Joint, prefix: str) -> Joint:
    mimic = joint.mimic and replace(joint.mimic, joint=prefix + joint.mimic.joint)
    return replace(joint, name=prefix + joint.name, parent=prefix + joint.parent,
                   child=prefix + joint.child, mimic=mimic)
