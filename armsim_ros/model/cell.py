# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot or several: checked files and models, and the models of several as one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.simulation import PlacementSettings
from armsim_ros.errors import ConfigError, Location, Problem, Severity
from armsim_ros.model.description.srdf import read_srdf
from armsim_ros.model.description.xml_tree import parse_xml, xml_text, XmlElement
from armsim_ros.model.robot_model import HardwareSystem, Joint, JointType, Link, RobotModel
from armsim_ros.model.semantic_model import SemanticModel
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.tree import adjacent_pairs, tree_order


@dataclass(frozen=True, eq=False)
class Robot:
    """
    A robot of a cell.

    :param name: its name in the cell.
    :param settings: with the names that links, joints and groups have in the cell.
    :param model: the same; its root is its own root link.
    """

    name: str
    settings: RobotSettings
    model: RobotModel


@dataclass(frozen=True, eq=False)
class Cell:
    """
    All robots of a world; a single robot is a cell by itself.

    :param settings: of the whole; controllers have their namespace in their name. Of a single
        robot, its own.
    :param model: all robots as a single tree. Of a single robot, its own.
    :param robots: the robots, in the order of their file.
    """

    settings: RobotSettings
    model: RobotModel
    robots: tuple[Robot, ...]


@dataclass(frozen=True, eq=False)
class CellSurvey:
    """
    What was found in the files.

    :param problems: errors, warnings and remarks.
    :param settings: those of the only robot, or of the files in the cell's folder.
    :param robots: settings of the robots of a cell as in their files, each folder once; none
        for a single robot.
    :param model: of the only robot, even if there are errors; else of the cell.
    :param cell: None where there are errors.
    :param declared: arguments of the xacro of URDF and SRDF, with their values.
    """

    problems: tuple[Problem, ...]
    settings: RobotSettings
    robots: tuple[RobotSettings, ...] = ()
    model: RobotModel | None = None
    cell: Cell | None = None
    declared: Mapping[str, str] = field(default_factory=dict)

    def checked(self) -> Cell:
        """
        Return the cell.

        :raises ConfigError: with every error.
        """
        errors = errors_of(self.problems)
        if errors or self.cell is None:
            raise ConfigError(errors)
        return self.cell


def errors_of(problems: Iterable[Problem]) -> list[Problem]:
    """Return the problems that stop a program."""
    return [problem for problem in problems if problem.severity is Severity.ERROR]


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
    sensors = tuple(replace(sensor, name=prefix + sensor.name, frame=prefix + sensor.frame,
                            reference=sensor.reference and prefix + sensor.reference)
                    for sensor in system.sensors)
    states = {prefix + name: value for name, value in system.other_states.items()}
    commands = tuple(prefix + name for name in system.other_commands)
    return replace(system, name=prefix + system.name, joints=joints, sensors=sensors,
                   other_states=states, other_commands=commands)


def _joint(joint: Joint, prefix: str) -> Joint:
    mimic = joint.mimic and replace(joint.mimic, joint=prefix + joint.mimic.joint)
    return replace(joint, name=prefix + joint.name, parent=prefix + joint.parent,
                   child=prefix + joint.child, mimic=mimic)


#: The link that all robots are mounted on.
WORLD = 'world'

_HERE = Location('the cell')


@dataclass(frozen=True, slots=True, eq=False)
class PlacedRobot:
    """A robot with the names that it has in the cell, and the pose of its root link."""

    model: RobotModel
    placement: PlacementSettings

    @property
    def mount(self) -> str:
        """Name of the joint between the world and the robot."""
        return f'{WORLD}_to_{self.model.root_link}'


def clashes(robots: Mapping[str, PlacedRobot]) -> Iterator[tuple[str, str]]:
    """Yield a robot's name and a sentence for each pair of robots that share a name."""
    for name, robot in robots.items():
        if WORLD in robot.model.links:
            yield name, (f"link '{WORLD}' of robot '{name}' has the name of the link that all "
                         'robots are mounted on')
    for (first, first_robot), (second, other) in combinations(robots.items(), 2):
        for kind, names, others in (
            ('link', first_robot.model.links, other.model.links),
            ('joint', first_robot.model.joints, other.model.joints),
            ('planning group', first_robot.model.semantic.groups, other.model.semantic.groups),
            ('end effector', first_robot.model.semantic.end_effectors,
             other.model.semantic.end_effectors),
        ):
            shared = [each for each in names if each in others]
            if shared:
                yield second, (f"{kind} '{shared[0]}' is in robot '{first}' and in robot "
                               f"'{second}'")
                break


def merged_model(name: str, robots: Mapping[str, PlacedRobot],
                 srdf: tuple[str, str] | None = None) -> tuple[RobotModel, list[Problem],
                                                               dict[str, Location]]:
    """
    Return all robots as a single one.

    :param name: the cell's name.
    :param robots: without :func:`clashes`.
    :param srdf: text and file name of an SRDF for the whole: groups over several robots, pairs
        of links of two robots that need no check.
    :returns: the model, what is wrong in that SRDF, and where it has what.
    :raises ModelError: none of the groups fits.
    """
    links: dict[str, Link] = {WORLD: Link(WORLD)}
    joints: dict[str, Joint] = {}
    for robot in robots.values():
        links.update(robot.model.links)
        joints[robot.mount] = _mount(robot)
        joints.update(robot.model.joints)
    link_order, joint_order = tree_order(WORLD, joints)
    links = {link: links[link] for link in link_order}
    joints = {joint: joints[joint] for joint in joint_order}
    root = _merged_srdf(name, robots, srdf)
    semantic, text = SemanticModel(), ''
    problems: list[Problem] = []
    places: dict[str, Location] = {}
    if root.children:
        content = read_srdf(root, robot_name=name, root_link=WORLD, links=links, joints=joints)
        semantic, text = content.semantic, xml_text(root)
        # What is wrong with a robot's own SRDF is reported where that is read.
        problems = [problem for problem in content.problems
                    if srdf and problem.where is not None and problem.where.file == srdf[1]]
        places = content.places
    urdf = xml_text(_merged_urdf(name, robots))
    hardware = tuple(system for robot in robots.values() for system in robot.model.hardware)
    model = RobotModel(name, links, joints, WORLD, semantic, hardware, urdf, text)
    return model, problems, places


def _mount(robot: PlacedRobot) -> Joint:
    placement = robot.placement
    return Joint(robot.mount, JointType.FIXED, WORLD, robot.model.root_link,
                 pose_matrix(placement.xyz, placement.rpy), np.array([1.0, 0.0, 0.0]))


def _merged_urdf(name: str, robots: Mapping[str, PlacedRobot]) -> XmlElement:
    root = XmlElement('robot', {'name': name}, _HERE, [_element('link', name=WORLD)])
    attributes = dict(root.attributes)
    for robot in robots.values():
        own = parse_xml(robot.model.urdf, robot.model.name)
        attributes.update({key: value for key, value in own.attributes.items()
                           if key.startswith('xmlns')})
        xyz, rpy = (' '.join(map(repr, triple))
                    for triple in (robot.placement.xyz, robot.placement.rpy))
        mount = _element('joint', name=robot.mount, type='fixed')
        mount.children.extend([
            _element('parent', link=WORLD), _element('child', link=robot.model.root_link),
            _element('origin', xyz=xyz, rpy=rpy)])
        root.children.extend([mount, *own.children])
    return XmlElement(root.tag, attributes, _HERE, root.children)


def _merged_srdf(name: str, robots: Mapping[str, PlacedRobot], srdf: tuple[str, str] | None
                 ) -> XmlElement:
    root = XmlElement('robot', {'name': name}, _HERE)
    for robot in robots.values():
        model = robot.model
        if model.srdf:
            # A virtual joint ties a robot to the world, which the cell has itself.
            root.children.extend(child for child in parse_xml(model.srdf, model.name).children
                                 if child.tag != 'virtual_joint')
        if not model.semantic.disabled_collisions:
            root.children.extend(
                _element('disable_collisions', link1=first, link2=two, reason='Adjacent')
                for first, two in adjacent_pairs(model))
        for quiet in sorted(model.semantic.default_disabled):
            root.children.extend(
                _element('enable_collisions', link1=quiet, link2=link)
                for other in robots.values() if other is not robot
                for link in other.model.links)
    if srdf is not None:
        root.children.extend(parse_xml(*srdf).children)
    return root


def _element(tag: str, **attributes: str) -> XmlElement:
    return XmlElement(tag, attributes, _HERE)
