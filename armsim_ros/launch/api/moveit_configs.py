# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""MoveItConfigsBuilder: the parameters of a MoveIt configuration package, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from typing_extensions import Self

from armsim_ros.errors import ConfigError
from armsim_ros.launch.api.actions.logs import get_logger
from armsim_ros.launch.api.launches import Xacro
from armsim_ros.launch.api.param_builder import ParameterBuilder
from armsim_ros.launch.api.ros_parameters import ParameterValue
from armsim_ros.launch.api.substitutions.programs import missing_in
from armsim_ros.launch.failures import MissingPackageError
from armsim_ros.launch.lookup import current_lookup
from armsim_ros.model.description.moveit_parameters import MoveItParameters

Parameters = dict[str, Any]


@dataclass
class MoveItConfigs:
    """The parameters of a package, a dictionary per kind."""

    package_path: Any = None
    robot_description: Parameters = field(default_factory=dict)
    robot_description_semantic: Parameters = field(default_factory=dict)
    robot_description_kinematics: Parameters = field(default_factory=dict)
    planning_pipelines: Parameters = field(default_factory=dict)
    trajectory_execution: Parameters = field(default_factory=dict)
    planning_scene_monitor: Parameters = field(default_factory=dict)
    sensors_3d: Parameters = field(default_factory=dict)
    move_group_capabilities: Parameters = field(
        default_factory=lambda: {'capabilities': '', 'disable_capabilities': ''})
    joint_limits: Parameters = field(default_factory=dict)
    moveit_cpp: Parameters = field(default_factory=dict)
    pilz_cartesian_limits: Parameters = field(default_factory=dict)

    def to_dict(self) -> Parameters:
        """Return all of them in a single dictionary."""
        found: Parameters = {}
        for part in (self.robot_description, self.robot_description_semantic,
                     self.robot_description_kinematics, self.planning_pipelines,
                     self.trajectory_execution, self.planning_scene_monitor, self.sensors_3d,
                     self.joint_limits, self.moveit_cpp):
            found.update(part)
        for name, limits in self.pilz_cartesian_limits.items():
            found[name] = {**found.get(name, {}), **limits}
        return found


class MoveItConfigsBuilder(ParameterBuilder):
    """
    Collects a package's parameters, from the usual files unless others are named.

    :param robot_name: of the robot.
    :param robot_description: name of the parameter with the URDF; the others begin with it.
    :param package_name: ``ROBOT_moveit_config`` where None.
    """

    def __init__(self, robot_name: str, robot_description: str = 'robot_description',
                 package_name: str | None = None) -> None:
        super().__init__(package_name or f'{robot_name}_moveit_config')
        lookup = current_lookup()
        self._reported = lookup.reported
        self._files = MoveItParameters(
            self._package_path, robot_name, lookup.packages, robot_description)
        self._configs = MoveItConfigs(package_path=self._package_path)

    def robot_description(self, file_path: Any = None,
                          mappings: Mapping[Any, Any] | None = None) -> Self:
        """Read the URDF."""
        if _are_texts(mappings):
            try:
                self._configs.robot_description = self._read(
                    self._files.robot_description, file_path, mappings)
            except ConfigError as error:
                if 'does not exist' not in str(error) and 'has no URDF' not in str(error):
                    raise
                get_logger('moveit_configs_utils').warning(
                    '%s; it is expected on the topic /robot_description', error)
        else:
            self._configs.robot_description = {
                self._files_description: _later(self._files.urdf_file(file_path), mappings)}
        return self

    def robot_description_semantic(self, file_path: Any = None,
                                   mappings: Mapping[Any, Any] | None = None) -> Self:
        """Read the SRDF."""
        if _are_texts(mappings):
            self._configs.robot_description_semantic = self._read(
                self._files.robot_description_semantic, file_path, mappings)
        else:
            self._configs.robot_description_semantic = {
                f'{self._files_description}_semantic': _later(
                    self._files.srdf_file(file_path), mappings)}
        return self

    def robot_description_kinematics(self, file_path: Any = None) -> Self:
        """Read the settings of inverse kinematics."""
        self._configs.robot_description_kinematics = self._files.robot_description_kinematics(
            file_path)
        return self

    def joint_limits(self, file_path: Any = None) -> Self:
        """Read the joint limits."""
        self._configs.joint_limits = self._files.joint_limits(file_path)
        return self

    def moveit_cpp(self, file_path: Any = None) -> Self:
        """Read the parameters of MoveItCpp."""
        self._configs.moveit_cpp = self._files.moveit_cpp(file_path)
        return self

    def trajectory_execution(self, file_path: Any = None,
                             moveit_manage_controllers: bool = True) -> Self:
        """Read the controllers of move_group."""
        self._configs.trajectory_execution = self._files.trajectory_execution(
            file_path, moveit_manage_controllers)
        return self

    def planning_scene_monitor(
        self, publish_planning_scene: bool = True, publish_geometry_updates: bool = True,
        publish_state_updates: bool = True, publish_transforms_updates: bool = True,
        publish_robot_description: bool = False,
        publish_robot_description_semantic: bool = False,
    ) -> Self:
        """Set which parts of the planning scene are published."""
        self._configs.planning_scene_monitor = {
            'publish_planning_scene': publish_planning_scene,
            'publish_geometry_updates': publish_geometry_updates,
            'publish_state_updates': publish_state_updates,
            'publish_transforms_updates': publish_transforms_updates,
            'publish_robot_description': publish_robot_description,
            'publish_robot_description_semantic': publish_robot_description_semantic,
        }
        return self

    def sensors_3d(self, file_path: Any = None) -> Self:
        """Read the sensors."""
        self._configs.sensors_3d = self._files.sensors_3d(file_path)
        return self

    def planning_pipelines(self, default_planning_pipeline: str | None = None,
                           pipelines: list[str] | None = None, load_all: bool = True) -> Self:
        """Read the planning pipelines."""
        self._configs.planning_pipelines = self._files.planning_pipelines(
            default_planning_pipeline, pipelines, load_all)
        return self

    def pilz_cartesian_limits(self, file_path: Any = None) -> Self:
        """Read the limits of the tool."""
        self._configs.pilz_cartesian_limits = self._files.pilz_cartesian_limits(file_path)
        return self

    def to_moveit_configs(self) -> MoveItConfigs:
        """Return the parameters, reading the usual files of those that were not set."""
        made = self._configs
        for name in ('robot_description', 'robot_description_semantic',
                     'robot_description_kinematics', 'planning_pipelines',
                     'trajectory_execution', 'planning_scene_monitor', 'sensors_3d',
                     'joint_limits'):
            if not getattr(made, name):
                getattr(self, name)()
        if 'pilz_industrial_motion_planner' in made.planning_pipelines and \
                not made.pilz_cartesian_limits:
            self.pilz_cartesian_limits()
        for text in map(str, self._files.problems):
            if text not in self._reported:  # a demo makes a builder in each file it includes
                self._reported.add(text)
                get_logger('moveit_configs_utils').warning('%s', text)
        self._files.problems.clear()
        return made

    def to_dict(self, include_moveit_configs: bool = True) -> Parameters:
        """Return the parameters in a single dictionary."""
        if include_moveit_configs:
            self._parameters.update(self.to_moveit_configs().to_dict())
        return self._parameters

    @property
    def _files_description(self) -> str:
        return self._files.description

    def _read(self, read: Any, file_path: Any, mappings: Any) -> Parameters:
        try:
            found: Parameters = read(file_path, mappings)
        except ConfigError as error:
            package = missing_in(str(error))
            if package:
                raise MissingPackageError(package, str(error)) from None
            raise
        return found


def _are_texts(mappings: Mapping[Any, Any] | None) -> bool:
    return mappings is None or all(isinstance(key, str) and isinstance(value, str)
                                   for key, value in mappings.items())


def _later(file: Path, mappings: Mapping[Any, Any] | None) -> ParameterValue:
    return ParameterValue(Xacro(str(file), mappings=mappings), value_type=str)
