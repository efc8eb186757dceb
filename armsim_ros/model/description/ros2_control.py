# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The hardware of a URDF: ``<ros2_control>``, and Gazebo's plugin for it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
import re

from armsim_ros.errors import Location, nearest, Problem, Severity
from armsim_ros.model.description.gazebo_sensors import gazebo_sensors, mounted
from armsim_ros.model.description.xml_tree import TextReport, XmlElement
from armsim_ros.model.robot_model import (
    HardwareJoint,
    HardwareSensor,
    HardwareSystem,
    Joint,
    Mimic,
)
from armsim_ros.vendors import find_vendor

_PARAMETERS = re.compile(r'<!--.*?-->|<parameters>\s*([^<]*?)\s*</parameters>', re.DOTALL)
_TRUE, _FALSE = ('true', '1'), ('false', '0')
_KINDS = ('system', 'actuator', 'sensor')
#: What a tag may hold.
_PARTS = ('hardware', 'joint', 'sensor', 'gpio', 'transmission', 'properties')
#: Interfaces of a joint's motion; others are like those of a gpio.
_QUANTITIES = ('position', 'velocity', 'acceleration', 'effort')
#: Interfaces of a pose.
_POSE = tuple(f'{what}.{axis}' for what, axes in (('position', 'xyz'), ('orientation', 'xyzw'))
              for axis in axes)
#: What a sensor here can measure; others of its interfaces keep their initial value.
_MEASURED = frozenset(_POSE).union(f'{what}.{axis}' for what in (
    'force', 'torque', 'angular_velocity', 'linear_acceleration') for axis in 'xyz')
#: Plugins whose own parameters act here, too.
_MOCKS = ('mock_components/GenericSystem', 'fake_components/GenericSystem')


def plugin_parameters(urdf: str) -> list[str]:
    """Return the files of controllers that Gazebo's plugin is given in a URDF."""
    return list(dict.fromkeys(filter(None, _PARAMETERS.findall(urdf))))


@dataclass
class _Interfaces:
    """What an element declares."""

    commands: list[str] = field(default_factory=list)
    states: list[str] = field(default_factory=list)
    initial: dict[str, float] = field(default_factory=dict)
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)


def read_hardware(root: XmlElement, links: Collection[str], joints: Mapping[str, Joint],
                  report: TextReport) -> tuple[HardwareSystem, ...]:
    """
    Return the hardware that a URDF declares, an entry per tag.

    :param links: of the URDF; sensors measure in the frames of these.
    :param joints: of the URDF; a tag that names others is an error.
    """
    gazebo = gazebo_sensors(root, links, joints)
    frames = {**{name: name for name in links},
              **{name: sensor.link for name, sensor in gazebo.items()}}
    found: list[tuple[HardwareSystem, Location]] = []
    for element in root.all('ros2_control'):
        system = _read_system(element, frames, joints, report)
        if any(other.name == system.name for other, _ in found):
            report.ignored(f"hardware '{system.name}' is defined twice; the second is left out",
                           element.where, 'give each <ros2_control> a name of its own')
            continue
        found.append((system, element.where))
    kept = {name: replace(_with_further(system), sensors=tuple(
        mounted(sensor, gazebo, report) for sensor in system.sensors))
        for name, system in _without_doubles(found, report).items()}
    for system, where in found:
        if system.name in kept:
            report.problems.append(Problem(
                f"hardware '{system.name}' ({system.plugin or 'without plugin'}) is simulated",
                where, severity=Severity.CHANGED))
    return tuple(kept[system.name] for system, _ in found if system.name in kept)


def _without_doubles(
    systems: Sequence[tuple[HardwareSystem, Location]], report: TextReport
) -> dict[str, HardwareSystem]:
    """
    Return name -> hardware; each command interface is in a single component.

    A description often brings a simulator's or a vendor's hardware, and the Setup Assistant's
    package adds mock components for the same joints: a simulator's plugin comes before a vendor's,
    and a vendor's before mock components; of two of a kind the first counts.
    """
    owners: dict[str, str] = {}
    kept: dict[str, HardwareSystem] = {}
    for system, where in sorted(systems, key=lambda pair: _rank(pair[0])):
        doubles = {joint.name: owners[interface] for joint in system.joints
                   for interface in _commands(joint) if interface in owners}
        if doubles:
            report.ignored(
                f"hardware '{system.name}' ({system.plugin or 'without plugin'}) is left out for "
                f"{', '.join(doubles)}, which hardware '{next(iter(doubles.values()))}' commands",
                where, 'choose one of them with an argument of the xacro')
        rest = tuple(joint for joint in system.joints if joint.name not in doubles)
        if rest or not doubles:
            kept[system.name] = replace(system, joints=rest)
            owners.update((interface, system.name) for joint in rest
                          for interface in _commands(joint))
    return kept


def _with_further(system: HardwareSystem) -> HardwareSystem:
    """Return hardware with the further interfaces of its joints; a simulator's has none."""
    joints = () if system.of_simulator else system.joints
    states = {f'{joint.name}/{kind}': value for joint in joints
              for kind, value in joint.others.items()}
    commands = (name for joint in joints for kind, name in zip(
        joint.commands, _commands(joint), strict=True) if kind not in _QUANTITIES)
    return replace(system, other_states={**system.other_states, **states},
                   other_commands=(*system.other_commands, *commands))


def _rank(system: HardwareSystem) -> int:
    return 0 if system.of_simulator else 2 if system.plugin in _MOCKS else 1


def _commands(joint: HardwareJoint) -> list[str]:
    """Return the joint's command interfaces with its name."""
    return [f'{joint.name}/{command}' for command in joint.commands]


def _read_system(element: XmlElement, frames: Mapping[str, str], joints: Mapping[str, Joint],
                 report: TextReport) -> HardwareSystem:
    name = element.get('name') or 'hardware'
    kind = element.get('type').lower() or 'system'
    if kind not in _KINDS:
        report.ignored(f"hardware '{name}' is of type '{kind}'", element.where,
                       'use one of ' + ', '.join(_KINDS))
    for part in element.children:
        if part.tag not in _PARTS:
            report.ignored(f"hardware '{name}' has a <{part.tag}>, which ros2_control refuses",
                           part.where, nearest(part.tag, _PARTS))
    hardware = element.first('hardware')
    holder = hardware.first('plugin') if hardware is not None else None
    plugin = holder.content if holder is not None else ''
    if not plugin:
        report.ignored(f"hardware '{name}' has no plugin, without which ros2_control refuses it",
                       element.where, 'add <hardware><plugin>...</plugin></hardware>')
    read = [_read_joint(part, joints, report) for part in element.all('joint')]
    parameters = {} if hardware is None else {
        part.get('name'): part.content for part in hardware.all('param')}
    mock = _Mock.of(plugin, parameters)
    states: dict[str, float] = {}
    commands: list[str] = []
    sensors = []
    end = _end_of_chain([joint.name for joint in read if joint is not None], joints)
    for part in (*element.all('sensor'), *element.all('gpio')):
        content, owner = _interfaces(part, report), part.get('name')
        if not owner:
            report.ignored(f"hardware '{name}': a <{part.tag}> has no name", part.where)
            continue
        states.update({f'{owner}/{state}': content.initial.get(state, 0.0)
                       for state in content.states})
        commanded = content.states if part.tag in mock.commanded else content.commands
        commands += [f'{owner}/{command}' for command in commanded]
        if part.tag == 'sensor' and _MEASURED.intersection(content.states):
            sensors.append(_read_sensor(part, content.states, frames, end, report))
    measuring = {sensor.name: sensor for sensor in sensors if sensor is not None}
    pose = _pose_of_tool(plugin, parameters.get('tf_prefix', ''), frames, end)
    if pose is not None:
        states.update(dict.fromkeys((f'{pose.name}/{state}' for state in pose.states), 0.0))
        measuring[pose.name] = pose
    return HardwareSystem(
        name, kind, plugin, tuple(joint for joint in read if joint is not None), states,
        tuple(commands), tuple(measuring.values()), parameters,
        deaf=mock.deaf, offset=mock.offset)


@dataclass(frozen=True)
class _Mock:
    """
    The parameters of upstream's mock hardware.

    :param commanded: tags whose states can be commanded, sensor or gpio.
    """

    commanded: tuple[str, ...] = ()
    deaf: bool = False
    offset: float = 0.0

    @classmethod
    def of(cls, plugin: str, parameters: Mapping[str, str]) -> _Mock:
        """Return a component's parameters; other plugins have other parameters."""
        if plugin not in _MOCKS:
            return cls()

        def is_on(*names: str) -> bool:
            return any(parameters.get(name, '').lower() in _TRUE for name in names)

        commanded = [tag for tag in ('sensor', 'gpio')
                     if is_on(f'mock_{tag}_commands', f'fake_{tag}_commands')]
        text = parameters.get('position_state_following_offset',
                              parameters.get('state_following_offset', '0'))
        try:
            offset = float(text)
        except ValueError:
            offset = 0.0
        if parameters.get('custom_interface_with_following_offset') or not math.isfinite(offset):
            offset = 0.0
        return cls(tuple(commanded), is_on('disable_commands'), offset)


def _end_of_chain(names: Sequence[str], joints: Mapping[str, Joint]) -> str:
    """Return the link at the end of the joints, '' where they are not a chain."""
    below = {joint.child: name for name, joint in joints.items()}
    for name in reversed(names):
        way, link = set(), joints[name].child
        while link in below and below[link] not in way:
            way.add(below[link])
            link = joints[below[link]].parent
        if way.issuperset(names):
            return joints[name].child
    return ''


def _read_sensor(element: XmlElement, states: Iterable[str], frames: Mapping[str, str],
                 end: str, report: TextReport) -> HardwareSensor | None:
    """
    Return where a sensor measures.

    That is its ``frame_id``, else where Gazebo has a frame of its name, else the end of the arm.
    """
    name = element.get('name')
    named = next((part.content for part in element.all('param')
                  if part.get('name') == 'frame_id'), name)
    frame = frames.get(named) or frames.get(name) or end
    if not frame:
        report.info(f"sensor '{name}' measures nothing: neither a <param name='frame_id'> nor a "
                    '<gazebo> element gives its link', element.where)
        return None
    return HardwareSensor(name, frame, tuple(state for state in states if state in _MEASURED))


def _pose_of_tool(plugin: str, prefix: str, frames: Mapping[str, str], end: str
                  ) -> HardwareSensor | None:
    """Return the sensor that a vendor's hardware has whatever the URDF declares."""
    vendor = find_vendor('', (plugin,))
    if vendor is None or vendor.pose is None:
        return None
    name, reference = (prefix + part for part in vendor.pose)
    frame = frames.get(prefix + vendor.tool) or end
    return HardwareSensor(name, frame, _POSE, frames.get(reference, '')) if frame else None


def _read_joint(element: XmlElement, joints: Mapping[str, Joint], report: TextReport
                ) -> HardwareJoint | None:
    name = element.get('name')
    joint = joints.get(name)
    if joint is None:
        report.error(f"<ros2_control> has a joint '{name}', which is not in the URDF",
                     element.where, remedy=nearest(name, tuple(joints)))
        return None
    if not joint.movable:
        report.error(f"<ros2_control> has the joint '{name}', which is {joint.type.value}",
                     element.where, remedy='remove it there')
        return None
    content = _interfaces(element, report)
    mimic = element.get('mimic').lower()
    if mimic in _TRUE and joint.mimic is None:
        report.ignored(f"joint '{name}' has mimic='true' and no <mimic> in the URDF",
                       element.where, 'add <mimic joint=.../> to the URDF')
    leader = _leader(element, joint, report)
    follows = leader is not None or (joint.mimic is not None and mimic not in _FALSE)
    commands = tuple(content.commands)
    if follows and commands:
        report.ignored(
            f"joint '{name}' follows another joint and has the command interface "
            f'{", ".join(commands)}, which no controller can claim', element.where,
            "remove it, or free the joint with mimic='false'")
        commands = ()
    limits = element.first('limits')
    enabled = limits is None or limits.get('enable', 'true').lower() not in _FALSE
    return HardwareJoint(
        name, commands, tuple(content.states), content.initial.get('position'),
        {kind: bounds for kind, bounds in content.bounds.items() if kind in _QUANTITIES},
        {kind: content.initial.get(kind, 0.0) for kind in content.states
         if kind not in _QUANTITIES},
        limited=enabled, free=joint.mimic is not None and not follows, follows=leader)


def _leader(element: XmlElement, joint: Joint, report: TextReport) -> Mimic | None:
    """Return what the parameters of the hardware make a joint follow."""
    given = {part.get('name'): part.content for part in element.all('param')}
    if joint.mimic is not None or not given.get('mimic'):
        return None
    try:
        return Mimic(given['mimic'], float(given.get('multiplier', '1')))
    except ValueError:
        report.error(f"the multiplier of joint '{joint.name}' is '{given['multiplier']}'",
                     element.where, 'a number')
        return None


def _interfaces(element: XmlElement, report: TextReport) -> _Interfaces:
    found = _Interfaces()
    for part in _named(element, 'command_interface', report):
        kind = part.get('name')
        found.commands.append(kind)
        lower, upper = _parameter(part, 'min', report), _parameter(part, 'max', report)
        limits = part.first('limits')
        switched_off = limits is not None and limits.get('enable').lower() in _FALSE
        if switched_off:
            found.bounds[kind] = (-math.inf, math.inf)
        elif lower is not None or upper is not None:
            found.bounds[kind] = (-math.inf if lower is None else lower,
                                  math.inf if upper is None else upper)
        initial = _parameter(part, 'initial_value', report)
        if initial is not None:
            found.initial.setdefault(kind, initial)
    for part in _named(element, 'state_interface', report):
        kind = part.get('name')
        found.states.append(kind)
        initial = _parameter(part, 'initial_value', report)
        if initial is not None:
            found.initial[kind] = initial
    return found


def _named(element: XmlElement, tag: str, report: TextReport) -> Iterator[XmlElement]:
    """Yield the children with a tag that have a name."""
    for part in element.all(tag):
        if part.get('name'):
            yield part
        else:
            report.ignored(f"a <{tag}> of {element.tag} '{element.get('name')}' has no name",
                           part.where)


def _parameter(element: XmlElement, name: str, report: TextReport) -> float | None:
    """Return a ``<param>`` as a number, None where it is absent or none."""
    holder = next((part for part in element.all('param') if part.get('name') == name), None)
    if holder is None or not holder.content:
        return None
    truth = holder.content.lower()
    if truth in ('true', 'false'):  # the initial value of an interface of the type bool
        return float(truth == 'true')
    try:
        value = float(holder.content)
    except ValueError:
        value = math.nan
    if math.isnan(value):
        report.ignored(f"<param name='{name}'> is '{holder.content}', which is not a number",
                       holder.where)
        return None
    return value


