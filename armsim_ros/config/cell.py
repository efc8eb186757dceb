# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""cell.yaml: several robots, and their settings as those of one."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
import re
from typing import Any, TypeVar

from pydantic import field_validator, model_validator
from typing_extensions import Self

from armsim_ros.config.base import parameter, read_settings, Settings
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.config.kinematics import JointLimitOverrides
from armsim_ros.config.ompl_planning import (
    OmplGroup,
    PipelineSettings,
    PlannerConfig,
    RENAMED_PIPELINE_KEYS,
)
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.simulation import (
    finite_triple,
    JointServoSettings,
    SimulationSettings,
    Triple,
    VacuumGripperSettings,
)
from armsim_ros.config.yaml_node import YamlNode
from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.errors import ConfigError, Problem, Severity
from armsim_ros.resources import ROBOTS_FILE

_WORD = re.compile(r'[A-Za-z][A-Za-z0-9_]*')


class CellRobot(Settings):
    """A robot of a cell; what is not given follows from its name or its own files."""

    robot: str = parameter(
        ..., "the robot's folder, from the cell's folder; or a name under config/", min_length=1)
    xyz: Triple | None = parameter(
        None, 'position of its root link [m]; by default from its simulation.yaml')
    rpy: Triple | None = parameter(
        None, 'roll, pitch, yaw of its root link [rad]; by default from its simulation.yaml')
    prefix: str | None = parameter(
        None, "precedes its links, joints and planning groups; not given: its name and '_'")
    namespace: str | None = parameter(
        None, "of its controllers and joint states, '' is the root; not given: its name")

    @field_validator('xyz', 'rpy')
    @classmethod
    def _finite(cls, value: Triple | None) -> Triple | None:
        return None if value is None else finite_triple(value)

    @field_validator('prefix')
    @classmethod
    def _word(cls, value: str | None) -> str | None:
        if value and not _WORD.fullmatch(value):
            raise ValueError(f"'{value}' cannot begin a name; allowed: letters, digits and _")
        return value

    @field_validator('namespace')
    @classmethod
    def _ros_name(cls, value: str | None) -> str | None:
        name = (value or '').strip('/')
        if name and not all(_WORD.fullmatch(part) for part in name.split('/')):
            raise ValueError(
                f"'{value}' is not a ROS name; allowed: letters, digits and _ that begin with a "
                'letter, separated by /')
        return None if value is None else name


class CellSettings(Settings):
    """The robots of a cell."""

    robots: dict[str, CellRobot] = parameter(
        ..., 'name -> a robot, its place, prefix and namespace')

    @model_validator(mode='after')
    def _told_apart(self) -> Self:
        if not self.robots:
            raise ValueError("'robots' is empty; allowed: at least one robot")
        seen: dict[str, str] = {}
        for name in self.robots:
            if not _WORD.fullmatch(name):
                raise ValueError(
                    f"robots: '{name}' is not a name for a robot; allowed: letters, digits and _ "
                    'that begin with a letter')
            namespace = self.namespace(name)
            if namespace in seen:
                raise ValueError(
                    f"robots: '{name}' and '{seen[namespace]}' are both in namespace "
                    f"'/{namespace}'; allowed: a namespace per robot, 'namespace: ...' chooses it")
            seen[namespace] = name
        return self

    def prefix(self, name: str) -> str:
        """Return what precedes the names of a robot's links, joints and planning groups."""
        given = self.robots[name].prefix
        return f'{name}_' if given is None else given

    def namespace(self, name: str) -> str:
        """Return the namespace of a robot without slashes at its ends."""
        given = self.robots[name].namespace
        return name if given is None else given


def robots_file(folder: Path) -> Path | None:
    """Return the file that makes a folder a cell, None where it is a robot's folder."""
    places = (folder / ROBOTS_FILE, folder / 'config' / ROBOTS_FILE)
    return next((file for file in places if file.is_file()), None)


def read_cell(file: Path) -> tuple[CellSettings, YamlNode]:
    """
    Read the robots of a cell.

    :returns: the settings, and the file's nodes, which know the places.
    :raises ConfigError: with every error.
    """
    problems: list[Problem] = []
    node = read_yaml_file(file)
    cell = read_settings(CellSettings, node, problems, title='cell', tolerant=False)
    if cell is None:
        raise ConfigError(problems)
    return cell, node


AnySettings = TypeVar('AnySettings', bound=Settings)
Robots = Mapping[str, RobotSettings]


def merged_settings(own: RobotSettings, robots: Robots, problems: list[Problem]) -> RobotSettings:
    """
    Return what holds for a whole cell.

    What names joints, planning groups or controllers is merged. Of all else there is one
    value: the cell's own, else the first that a robot's files give, else the default.

    :param own: the files in the cell's folder; they win over those of the robots.
    :param robots: name -> settings with the names that it has in the cell.
    :param problems: what is not taken over is added here.
    """
    merge = _Merge(own, robots, problems)
    merge.refuse_controllers()
    simulation = merge.simulation()
    return own.model_copy(update={
        'files': tuple(dict.fromkeys(
            [*own.files, *(file for settings in robots.values() for file in settings.files)])),
        'controllers': tuple(
            controller.model_copy(update={
                'name': f'{settings.namespace}/{controller.name}'.strip('/')})
            for settings in robots.values() for controller in settings.controllers),
        'spawn': tuple(f'{settings.namespace}/{name}'.strip('/')
                       for settings in robots.values() for name in settings.spawn),
        'controller_manager': own.controller_manager.model_copy(
            update={'update_rate': merge.update_rate(simulation)}),
        'simulation': simulation,
        'joint_limits': merge.block(
            'joint_limits', own.joint_limits, joint_limits=merge.joint_limits()),
        'kinematics': {group: solver for settings in merge.all
                       for group, solver in settings.kinematics.items()},
        'pipelines': merge.pipelines(),
        'moveit_controllers': tuple({controller.name: controller for settings in merge.all
                                     for controller in settings.moveit_controllers}.values()),
        'trajectory_execution': merge.block(
            'trajectory_execution', own.trajectory_execution, allowed_start_tolerance_joints={
                joint: tolerance for settings in merge.all for joint, tolerance
                in settings.trajectory_execution.allowed_start_tolerance_joints.items()}),
        'planning_parameters': merge.block(
            'planning_parameters', own.planning_parameters,
            joint_state_topics=merge.joint_state_topics(),
            planning_pipelines=merge.planning_pipelines()),
    })


class _Merge:
    """The parts of a cell, and the problems found."""

    def __init__(self, own: RobotSettings, robots: Robots, problems: list[Problem]) -> None:
        self._own, self._robots, self._problems = own, robots, problems
        #: Later ones win.
        self.all = (*robots.values(), own)

    def refuse_controllers(self) -> None:
        for controller in self._own.controllers:
            self._problems.append(Problem(
                f"controller '{controller.name}' is in the folder of a cell",
                self._own.locate('controllers', controller.name),
                remedy='move it into the folder of the robot that it moves'))

    def block(self, section: str, own: AnySettings, *, inside: str = '',
              **apart: Any) -> AnySettings:
        """
        Return a block with a value per key.

        :param section: field of RobotSettings.
        :param inside: where the block is not the section itself, its parent key.
        :param apart: key -> value of those that are laid together.
        """
        path = (section, inside) if inside else (section,)
        values: dict[str, Any] = {
            key: getattr(own, key) for key in _given(self._own, path, own, apart)}
        owners = dict.fromkeys(values, 'the cell')
        for name, settings in self._robots.items():
            block = getattr(settings, section)
            if inside:
                block = block.get(inside) if isinstance(block, dict) else getattr(block, inside)
            if block is None:
                continue
            for key in _given(settings, path, block, apart):
                value = getattr(block, key)
                if owners.setdefault(key, f"robot '{name}'") == f"robot '{name}'":
                    values[key] = value
                elif values[key] != value:
                    self._changed(settings, (*path, key), f"{value} of robot '{name}' is "
                                  f'overridden by {values[key]} of {owners[key]}')
        return own.model_copy(update={**values, **apart})

    def joint_limits(self) -> dict[str, JointLimitOverrides]:
        """Return the limits of all joints, each value for itself as parameters of a node are."""
        found: dict[str, JointLimitOverrides] = {}
        for settings in self.all:
            for joint, limits in settings.joint_limits.joint_limits.items():
                given = {key: getattr(limits, key) for key in limits.model_fields_set}
                found[joint] = found.get(joint, limits).model_copy(update=given)
        return found

    def simulation(self) -> SimulationSettings:
        """Return the physics with the joints of all robots in it."""
        servo: JointServoSettings = self.block(
            'simulation', self._own.simulation.servo, inside='servo',
            gains=self._gains(), default_gains=self._own.simulation.servo.default_gains)
        own = self._own.simulation
        for name, settings in self._robots.items():
            if settings.simulation.world:
                self._problems.append(Problem(
                    f"the world '{settings.simulation.world}' of robot '{name}' is not used here: "
                    'the world of a cell is set in its own simulation.yaml',
                    settings.locate('simulation', 'world'), severity=Severity.INFO))
        cameras = {name: camera for settings in self.all
                   for name, camera in settings.simulation.cameras.items()}
        return self.block(
            'simulation', own, servo=servo, world=own.world, placement=own.placement,
            initial_state=own.initial_state, initial_positions=own.initial_positions,
            cameras=cameras, vacuum_grippers=self._vacuum_grippers(),
            sensors={sensor: entry for settings in self.all
                     for sensor, entry in settings.simulation.sensors.items()})

    def _vacuum_grippers(self) -> dict[str, VacuumGripperSettings]:
        """Return all suction cups by the names that their services have."""
        cups = dict(self._own.simulation.vacuum_grippers)
        for robot, settings in self._robots.items():
            for name, cup in settings.simulation.vacuum_grippers.items():
                full = f'{settings.namespace}/{name}'.strip('/')
                if full in cups:
                    self._problems.append(Problem(
                        f"two suction cups are called '{full}'; the other belongs to '{robot}'",
                        settings.locate('simulation', 'vacuum_grippers', name),
                        remedy=f"give '{robot}' a namespace of its own"))
                cups[full] = cup
        return cups

    def update_rate(self, simulation: SimulationSettings) -> int:
        """Return the rate of all controllers: the cell's own, else the highest that is given."""
        path = ('controller_manager', 'update_rate')
        fastest = round(1.0 / simulation.timestep)
        asked = {name: settings.controller_manager.update_rate
                 for name, settings in self._robots.items()
                 if settings.locate(*path) is not None}
        rate = max(asked.values(), default=fastest)
        if self._own.locate(*path) is not None:
            rate = self._own.controller_manager.update_rate
        if abs(fastest / rate - round(fastest / rate)) > 1e-6:
            rate = fastest
        for name, given in asked.items():
            if given != rate:
                self._changed(self._robots[name], path, f"{given} Hz of robot '{name}' is "
                              f'overridden by {rate} Hz, the rate of all controllers')
        return rate

    def pipelines(self) -> dict[str, PipelineSettings]:
        """Return the planning pipelines of all robots."""
        names = dict.fromkeys(name for settings in self.all for name in settings.pipelines)
        return {name: self._pipeline(name) for name in names}

    def _pipeline(self, pipeline: str) -> PipelineSettings:
        """Return a pipeline; planners of a name that differ get the name of their robot."""
        first = next(settings.pipelines[pipeline] for settings in (
            self._own, *self._robots.values()) if pipeline in settings.pipelines)
        own = self._own.pipelines.get(
            pipeline, PipelineSettings(planning_plugins=first.planning_plugins))
        configs: dict[str, PlannerConfig] = dict(own.planner_configs)
        groups: dict[str, OmplGroup] = {}
        for name, settings in self._robots.items():
            each = settings.pipelines.get(pipeline, PipelineSettings())
            renamed = {}
            for key, config in each.planner_configs.items():
                renamed[key] = key if configs.get(key, config) == config else f'{name}_{key}'
                configs[renamed[key]] = config
            for group, block in each.groups.items():
                default = block.default_planner_config
                groups[group] = block.model_copy(update={
                    'default_planner_config': renamed.get(default, default),
                    'planner_configs': tuple(
                        renamed.get(key, key) for key in block.planner_configs)})
        return self.block('pipelines', own, inside=pipeline, planner_configs=configs,
                          groups={**groups, **own.groups})

    def planning_pipelines(self) -> tuple[str, ...]:
        """Return which pipelines are offered: as the cell's files list them, else all."""
        own = self._own.planning_parameters.planning_pipelines
        if self._own.locate('planning_parameters', 'planning_pipelines') is not None:
            return own
        described = [name for name in own if self._own.locate('pipelines', name) is not None]
        return tuple(dict.fromkeys((
            *(name for settings in self._robots.values()
              for name in settings.planning_parameters.planning_pipelines), *described)))

    def joint_state_topics(self) -> tuple[str, ...]:
        """Return where all robots' joint states come from."""
        topics = [topic for settings in self._robots.values()
                  for topic in settings.planning_parameters.joint_state_topics
                  or (settings.joint_states_topic,)]
        own = self._own.planning_parameters.joint_state_topics
        return own or tuple(dict.fromkeys(topics))

    def _gains(self) -> dict[str, PidGains]:
        """Return the gains of the drives, where a robot's simulation.yaml gives any."""
        gains: dict[str, PidGains] = {}
        for settings in self._robots.values():
            servo = settings.simulation.servo
            if 'default_gains' in servo.model_fields_set:
                gains.update(dict.fromkeys(_ungained(settings), servo.default_gains))
            gains.update(servo.gains)
        return {**gains, **self._own.simulation.servo.gains}

    def _changed(self, settings: RobotSettings, path: tuple[str, ...], text: str) -> None:
        self._problems.append(Problem(f"{'.'.join(path)}: {text}", settings.locate(*path),
                                      severity=Severity.CHANGED))


def _given(settings: RobotSettings, path: tuple[str, ...], block: Settings,
           apart: Collection[str]) -> list[str]:
    """
    Return the keys of a block that a file gives, in the order of their declaration.

    :param path: where the block is in the settings.
    :param apart: keys that are left out.
    """
    assumed = {'planning_plugins'} if not _names_its_plugin(settings, path) else set()
    return [key for key in type(block).model_fields
            if key in block.model_fields_set and key not in apart and key not in assumed]


def _names_its_plugin(settings: RobotSettings, path: tuple[str, ...]) -> bool:
    """Return whether a file gives a pipeline's plugin; else it follows from the name."""
    keys = ('planning_plugins', *RENAMED_PIPELINE_KEYS)
    return any(settings.locate(*path, key) is not None for key in keys)


def _ungained(settings: RobotSettings) -> list[str]:
    """Return the joints of controllers that give no gains for them."""
    return [joint for controller in settings.controllers for joint in controller.joints
            if not any(getattr(controller.parameters, 'gains', {}).get(
                joint, PidGains()).model_dump(include={'p', 'i', 'd'}).values())]
