# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""URDF text to a checked tree of links and joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from armsim_ros.errors import Location, nearest, Problem
from armsim_ros.model.description.ros2_control import read_hardware
from armsim_ros.model.description.urdf_elements import (
    Color,
    MeshReader,
    read_color,
    read_inertial,
    read_joint,
    read_shapes,
    read_transmissions,
    Scale,
    Transmission,
)
from armsim_ros.model.description.xml_tree import parse_xml, TextReport, unknown, XmlElement
from armsim_ros.model.geometry import Mesh
from armsim_ros.model.inertia import (
    implausible,
    inertial_of,
    LEAST_MASS,
    MOST_MASS,
    POINT_MASS,
    too_dense,
    with_plausible_inertia,
)
from armsim_ros.model.robot_model import HardwareSystem, Joint, JointType, Link
from armsim_ros.model.tree import tree_order

_KNOWN_TAGS = ('link', 'joint', 'material', 'transmission', 'gazebo', 'ros2_control', 'mujoco')


@dataclass(frozen=True, eq=False)
class UrdfContent:
    """
    What a URDF holds.

    :param links: by name, in tree order.
    :param joints: by name, in tree order; children of a link in the order of their names.
    :param transmissions: noted, they choose hardware interfaces.
    :param places: 'link x' or 'joint x' -> where it is written.
    :param plugin_namespaces: robotNamespace of Gazebo's plugins, without slashes -> its place.
    :param problems: warnings and remarks; errors were raised.
    :param hardware: what ``<ros2_control>`` declares.
    """

    name: str
    root_link: str
    links: dict[str, Link]
    joints: dict[str, Joint]
    transmissions: tuple[Transmission, ...]
    places: dict[str, Location]
    problems: tuple[Problem, ...]
    plugin_namespaces: dict[str, Location] = field(default_factory=dict)
    hardware: tuple[HardwareSystem, ...] = ()


def parse_urdf(text: str, file: str, *, read_mesh: MeshReader,
               read_visual_mesh: MeshReader | None = None, with_hardware: bool = True
               ) -> UrdfContent:
    """
    Parse a URDF.

    :param text: the text after xacro.
    :param file: the name that messages give.
    :param read_mesh: reads collision meshes.
    :param read_visual_mesh: reads visual meshes; None leaves them out.
    :param with_hardware: whether ``<ros2_control>`` and ``<transmission>`` are read.
    :raises ModelError: with every error.
    """
    root = parse_xml(text, file)
    report = TextReport()
    if root.tag != 'robot':
        report.error(f'the root element is <{root.tag}>', root.where, '<robot>')
        report.raise_errors()
    places: dict[str, Location] = {}
    materials = _materials(root, report)
    elements = _named(root, 'link', places, report)
    links = {name: Link(
        name, read_inertial(element, report),
        read_shapes(element, 'collision', materials, read_mesh, report),
        read_shapes(element, 'visual', materials, read_visual_mesh or _no_mesh, report),
    ) for name, element in elements.items()}
    report.join_equal("link '{}' has no collision geometry: ",
                      'the links {} have no collision geometry: ')
    joints: dict[str, Joint] = {}
    for name, element in _named(root, 'joint', places, report).items():
        joint = read_joint(element, report)
        if joint is not None:
            joints[name] = joint
    report.join_equal("joint '{}': limit 0 of ", 'joints {}: limit 0 of ')
    root_link = _check_tree(root, links, joints, places, report)
    _drop_mimics(joints, places, report)
    hardware = read_hardware(root, links, joints, report) if with_hardware else ()
    for driven in (driven for system in hardware for driven in system.joints):
        if driven.free or driven.follows is not None:
            joints[driven.name] = replace(joints[driven.name], mimic=driven.follows)
    _drop_mimics(joints, places, report)
    transmissions = read_transmissions(root, report) if with_hardware else ()
    _check_transmissions(transmissions, joints, root.where, report)
    _remark_others(root, report)
    report.raise_errors()
    link_order, joint_order = tree_order(root_link, joints)
    repaired = {name: _repair(links[name], joints, places[f'link {name}'], report)
                for name in link_order}
    return UrdfContent(
        root.get('name') or 'robot', root_link, repaired,
        {name: joints[name] for name in joint_order},
        transmissions, places, tuple(report.problems), _plugin_namespaces(root), hardware)


def _no_mesh(uri: str, scale: Scale) -> Mesh | None:
    return None


def _materials(root: XmlElement, report: TextReport) -> dict[str, Color]:
    found = {}
    for element in root.all('material'):
        color = read_color(element, report)
        if color is not None:
            found[element.get('name')] = color
    return found


def _named(root: XmlElement, tag: str, places: dict[str, Location],
           report: TextReport) -> dict[str, XmlElement]:
    found: dict[str, XmlElement] = {}
    for element in root.all(tag):
        name = element.get('name')
        if not name:
            report.error(f'<{tag}> has no name', element.where)
        elif name in found:
            report.error(f"{tag} '{name}' is defined twice, first in line "
                         f'{found[name].where.line}', element.where,
                         remedy='rename or remove one of them')
        else:
            found[name] = element
            places[f'{tag} {name}'] = element.where
    return found


def _check_tree(root: XmlElement, links: dict[str, Link], joints: dict[str, Joint],
                places: dict[str, Location], report: TextReport) -> str:
    """Return the root link; report what keeps the links from being one tree."""
    if not links:
        report.error('the robot has no links', root.where)
        return ''
    parents: dict[str, str] = {}
    for name, joint in joints.items():
        where = places[f'joint {name}']
        for end, link in (('parent', joint.parent), ('child', joint.child)):
            if link not in links:
                what, hint = unknown('link', link, tuple(links))
                report.error(f"{end} of joint '{name}': {what}", where, remedy=hint)
        if joint.child in parents:
            report.error(f"link '{joint.child}' is the child of two joints, "
                         f"'{parents[joint.child]}' and '{name}'", where,
                         'a tree: each link has a single parent')
        parents[joint.child] = name
    roots = [name for name in links if name not in parents]
    if not roots:
        report.error('the links form a loop, none is without a parent', root.where)
    elif len(roots) > 1:
        report.error(f"{len(roots)} links have no parent: {', '.join(roots)}",
                     places[f'link {roots[1]}'], 'a single root link',
                     f"join '{roots[1]}' to the others by a joint")
    elif not report.errors:
        loose = [name for name in links if name not in tree_order(roots[0], joints)[0]]
        if loose:
            report.error(f"the links {', '.join(loose)} form a loop",
                         places[f'link {loose[0]}'])
    return roots[0] if roots else ''


def _drop_mimics(joints: dict[str, Joint], places: dict[str, Location],
                 report: TextReport) -> None:
    """Let joints that cannot follow another one be free, as in robot_model.cpp (buildMimic)."""
    for name, joint in joints.items():
        if joint.mimic is None:
            continue
        leader = joints.get(joint.mimic.joint)
        if leader is not None and joint.movable and leader.movable:
            continue
        what, hint = unknown('joint', joint.mimic.joint, tuple(joints))
        if leader is not None:
            still = joint if not joint.movable else leader
            what, hint = f"joint '{still.name}' is {still.type.value}", ''
        report.ignored(f"<mimic> of joint '{name}' is left out: {what}", places[f'joint {name}'],
                       hint)
        joints[name] = replace(joint, mimic=None)
    circle = next(filter(None, (_circle(name, joints) for name in joints)), None)
    if circle is not None:
        report.ignored(f"joints mimic each other ({' -> '.join(circle)}); all <mimic> of the "
                       'robot are left out', places[f'joint {circle[0]}'])
        joints.update({name: replace(joint, mimic=None) for name, joint in joints.items()})


def _circle(name: str, joints: Mapping[str, Joint]) -> list[str] | None:
    """Return the way from a joint to itself along what the joints follow, None without one."""
    way = [name]
    while (mimic := joints[way[-1]].mimic) is not None:
        if mimic.joint in way:
            return [*way[way.index(mimic.joint):], mimic.joint]
        way.append(mimic.joint)
    return None


def _plugin_namespaces(root: XmlElement) -> dict[str, Location]:
    return {name.content.strip('/'): name.where for gazebo in root.all('gazebo')
            for plugin in gazebo.all('plugin') for name in plugin.all('robotNamespace')}


def _check_transmissions(transmissions: tuple[Transmission, ...], joints: dict[str, Joint],
                         where: Location, report: TextReport) -> None:
    for transmission in transmissions:
        if transmission.joint not in joints:
            report.warning(f"transmission '{transmission.name}': joint '{transmission.joint}' "
                           'is not in the URDF; it has no effect',
                           where, nearest(transmission.joint, tuple(joints)))


def _remark_others(root: XmlElement, report: TextReport) -> None:
    """List what Gazebo or others read and this program does not."""
    for element in root.children:
        if element.tag == 'gazebo':
            target = element.get('reference')
            tags = ', '.join(dict.fromkeys(child.tag for child in element.children)) or 'nothing'
            report.info('<gazebo' + (f" reference='{target}'" if target else '')
                        + f'> is not used here ({tags})', element.where)
        elif element.tag not in _KNOWN_TAGS:
            hint = nearest(element.tag, _KNOWN_TAGS)
            report.warning(f'<{element.tag}> is not known and has no effect', element.where, hint)


def _repair(link: Link, joints: dict[str, Joint], where: Location, report: TextReport) -> Link:
    """Return the link with mass properties that a simulation can work with."""
    shapes = link.collisions or link.visuals
    inertial, kept = link.inertial, False
    if inertial is None:
        moved = any(joint.child == link.name and joint.type is not JointType.FIXED
                    for joint in joints.values())
        if not moved and not link.collisions:
            return link
        reason = 'it has no <inertial>'
        made = inertial_of(shapes)
    else:
        mass = inertial.mass
        heavy = too_dense(mass, link.collisions, link.visuals)
        reason = implausible(inertial, shapes)
        if not reason and not heavy:
            return link
        if 0.0 <= inertial.mass < LEAST_MASS and not link.collisions and not link.visuals:
            return replace(link, inertial=None)  # zeros: it is only a frame
        if heavy:
            reason = f'the mass {mass:g} kg is too large for its shape'
            mass *= 1e-3
            heavy = too_dense(mass, link.collisions, link.visuals)
            if not heavy:
                reason += ', and taken as grams'
                made = replace(inertial, mass=mass, inertia=1e-3 * inertial.inertia)
                kept = not implausible(made, shapes)
        if not kept:
            if LEAST_MASS <= mass <= MOST_MASS and not heavy:
                made = with_plausible_inertia(replace(inertial, mass=mass), shapes)
            else:
                made = inertial_of(shapes, POINT_MASS if 0.0 < mass < LEAST_MASS else None)
    values = ', '.join(f'{value:.3g}' for value in made.inertia.diagonal())
    report.warning(
        f"link '{link.name}': {reason}; taken instead: mass {made.mass:.3g} kg, inertia "
        f'{values} kg*m^2' + (' from its shape' if shapes and not kept else ''), where,
        'give it an <inertial>' if inertial is None else 'correct its <inertial>')
    return replace(link, inertial=made)
