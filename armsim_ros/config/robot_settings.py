# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All settings from a user's files for a robot, checked."""

from __future__ import annotations

from pathlib import Path

from pydantic import PrivateAttr

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.config.controllers.controller_settings import ControllerSettings
from armsim_ros.config.kinematics import JointLimitsSettings, KinematicsSettings
from armsim_ros.config.ompl_planning import PipelineSettings, PlanningParameters
from armsim_ros.config.sensors_3d import OctomapSettings
from armsim_ros.config.servo import ServoNodeSettings
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.config.trajectory_execution import (
    MoveItControllerSettings,
    TrajectoryExecutionSettings,
)
from armsim_ros.config.world import WorldSettings
from armsim_ros.config.yaml_node import YamlNode
from armsim_ros.errors import Location, Problem
from armsim_ros.packages import Packages


class RobotSettings(Settings):
    """
    A robot's files as values.

    :param name: the robot's name: that of its folder.
    :param namespace: '' or such as '/sunday': where controller_manager, the controllers and
        joint_states live.
    :param folder: the folder with the YAML files.
    :param files: every file that was read.
    :param arguments: arguments of the URDF's and the SRDF's xacro.
    :param spawn: the controllers that are activated at the start, in this order.
    :param spawn_only: whether the other controllers stay unloaded until a spawner asks for them.
    :param start: a package's start of the joints for which its URDF gives none [rad or m].
    :param remarks: findings beside errors: warnings, and what is not used here.
    """

    name: str
    namespace: str = ''
    folder: Path
    urdf_file: Path
    srdf_file: Path | None = None
    world_file: Path | None = None
    files: tuple[Path, ...] = ()
    arguments: dict[str, str] = parameter({}, 'arguments of xacro')
    controller_manager: ControllerManagerParameters = ControllerManagerParameters()
    controllers: tuple[ControllerSettings, ...] = ()
    spawn: tuple[str, ...] = ()
    spawn_only: bool = False
    start: dict[str, float] = parameter({}, 'joint -> position at the start [rad or m]')
    joint_limits: JointLimitsSettings = JointLimitsSettings()
    kinematics: dict[str, KinematicsSettings] = parameter({}, 'planning group -> its solver')
    pipelines: dict[str, PipelineSettings] = parameter({}, 'planning pipeline -> its settings')
    moveit_controllers: tuple[MoveItControllerSettings, ...] = ()
    trajectory_execution: TrajectoryExecutionSettings = TrajectoryExecutionSettings()
    planning_parameters: PlanningParameters = PlanningParameters()
    octomap: OctomapSettings = OctomapSettings()
    simulation: SimulationSettings = SimulationSettings()
    servo: ServoNodeSettings = ServoNodeSettings()
    world: WorldSettings = WorldSettings()
    remarks: tuple[Problem, ...] = ()

    _source: YamlNode | None = PrivateAttr(default=None)
    _packages: Packages = PrivateAttr(default_factory=Packages)

    @property
    def packages(self) -> Packages:
        """The search path of packages."""
        return self._packages

    def locate(self, *path: str | int) -> Location | None:
        """
        Return where a value was written, None where it was not.

        :param path: names of fields and keys, and indices, such as
            ``('controllers', 'arm', 'joints', 0)``,
            ``('joint_limits', 'joint_limits', 'joint_1', 'max_velocity')``,
            ``('kinematics', 'manipulator')``, ``('moveit_controllers', 'ns/arm', 'joints', 2)``,
            ``('trajectory_execution', 'allowed_start_tolerance')``.
        """
        return self._source.locate(path) if self._source else None

    def with_source(self, source: YamlNode, packages: Packages) -> RobotSettings:
        """Return the same settings, knowing their places and those of packages."""
        copy = self.model_copy()
        copy._source = source
        copy._packages = packages
        return copy

    def controller(self, name: str) -> ControllerSettings | None:
        """Return a controller by its name, None where there is none."""
        return next((controller for controller in self.controllers
                     if controller.name == name), None)

    @property
    def joint_states_topic(self) -> str:
        """Absolute name of the topic with the joint states."""
        return f'{self.namespace}/joint_states'
