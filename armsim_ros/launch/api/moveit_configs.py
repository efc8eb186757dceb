# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters from a package's files: launch_param_builder and MoveItConfigsBuilder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
import re
from typing import Any

from typing_extensions import Self
import yaml

from armsim_ros.errors import ConfigError
from armsim_ros.install_rules.xacro_run import XacroCommand
from armsim_ros.launch.api.actions import get_logger
from armsim_ros.launch.api.launches import Xacro
from armsim_ros.launch.api.programs import missing_in, run_xacro
from armsim_ros.launch.api.ros_parameters import ParameterValue
from armsim_ros.launch.failures import LaunchError, MissingPackageError
from armsim_ros.launch.lookup import current_lookup
from armsim_ros.model.description.moveit_parameters import MoveItParameters


class ParameterBuilderFileNotFoundError(KeyError):
    """A file of parameters does not exist."""


def load_file(file_path: Any) -> str:
    """
    Return the text of a file.

    :raises ParameterBuilderFileNotFoundError: where it does not exist.
    """
    try:
        return Path(file_path).read_text(encoding='utf-8')
    except OSError:
        raise ParameterBuilderFileNotFoundError(f"file '{file_path}' does not exist") from None


def load_yaml(file_path: Any) -> Any:
    """
    Return the content of a YAML file.

    :raises ParameterBuilderFileNotFoundError: where it does not exist.
    :raises LaunchError: where it is not YAML.
    """
    text = load_file(file_path)
    try:
        return yaml.load(text, _Loader)
    except yaml.YAMLError as error:
        raise LaunchError(f"file '{file_path}' is not YAML: {error}") from None


def load_xacro(file_path: Any, mappings: Mapping[str, Any] | None = None) -> str:
    """Return the output of xacro for a file."""
    if not Path(file_path).is_file():
        raise ParameterBuilderFileNotFoundError(f"file '{file_path}' does not exist")
    words = {name: str(value) for name, value in (mappings or {}).items()}
    return run_xacro(XacroCommand(str(file_path), words), None)


def get_path(file_path: Any) -> Path:
    """Return a value as a path."""
    return Path(file_path)


def get_pattern_matches(folder: Path, pattern: re.Pattern[str]) -> list[Any]:
    """Return the files of a folder that match: the first group of each, or its path."""
    found = [(child, pattern.search(child.name)) for child in folder.iterdir()
             if child.is_file()] if folder.exists() else []
    return [match.groups()[0] if match.groups() else child
            for child, match in found if match is not None]


class ParameterBuilder:
    """
    Parameters of a node, collected.

    :param package_name: whose files are read.
    """

    def __init__(self, package_name: str) -> None:
        self._package_path = current_lookup().share(package_name)
        self._parameters: dict[str, Any] = {}

    def yaml(self, file_path: Any, parameter_namespace: str | None = None) -> Self:
        """Add a YAML file, without the node names around its parameters."""
        content = load_yaml(self._package_path / file_path) or {}
        for block in _blocks_of_nodes(content):
            content = {**{key: value for key, value in content.items()
                          if not isinstance(value, dict) or 'ros__parameters' not in value},
                       **block}
        self._add(content, parameter_namespace)
        return self

    def file_parameter(self, parameter_name: str, file_path: Any) -> Self:
        """Add the text of a file as a parameter."""
        self._parameters[parameter_name] = load_file(self._package_path / file_path)
        return self

    def xacro_parameter(self, parameter_name: str, file_path: Any,
                        mappings: Mapping[str, Any] | None = None) -> Self:
        """Add the output of xacro for a file as a parameter."""
        self._parameters[parameter_name] = load_xacro(self._package_path / file_path, mappings)
        return self

    def parameter(self, parameter_name: str, parameter_value: Any) -> Self:
        """Add a parameter."""
        self._parameters[parameter_name] = parameter_value
        return self

    def to_dict(self) -> dict[str, Any]:
        """Return them."""
        return self._parameters

    def _add(self, content: Mapping[str, Any], namespace: str | None) -> None:
        if namespace is None:
            self._parameters.update(content)
        else:
            self._parameters.setdefault(namespace, {}).update(content)


class _Loader(yaml.SafeLoader):
    """Reads angles with a unit, as MoveIt's files write them."""


def _angle(factor: float) -> Any:
    def read(loader: Any, node: Any) -> float:
        text = str(loader.construct_scalar(node))
        return float(text) * factor
    return read


_Loader.add_constructor('!degrees', _angle(0.017453292519943295))
_Loader.add_constructor('!radians', _angle(1.0))


def _blocks_of_nodes(content: Any) -> list[dict[str, Any]]:
    if not isinstance(content, dict):
        return []
    return [value['ros__parameters'] for value in content.values()
            if isinstance(value, dict) and isinstance(value.get('ros__parameters'), dict)]


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
        publish_robot_description: bool = False, publish_robot_description_semantic: bool = False,
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
