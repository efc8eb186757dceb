# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The parameters that a MoveIt configuration package gives to move_group and to its clients.

The files are those that :class:`PackageFiles` finds, unless a file is named; the dictionaries
have the keys of ROS parameters, nested.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from armsim_ros.config.package_files import PackageFiles
from armsim_ros.config.pipeline_defaults import (
    default_pipeline,
    DEFAULT_PIPELINES,
    planner_configs,
)
from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.errors import ConfigError, Location, Problem, ResourceError
from armsim_ros.model.description.xacro_text import read_description
from armsim_ros.packages import Packages

Parameters = dict[str, Any]


class MoveItParameters:
    """
    The parameters of a package; each method reads one kind, from its usual or a named file.

    A path that is named is taken from the package's folder, unless it is absolute.

    :param package: the folder of the package.
    :param name: the robot's name; where it is empty, taken from the package.
    :param packages: where other packages are searched.
    :param description: name of the parameter with the URDF; the others begin with it.
    """

    def __init__(self, package: Path, name: str = '', packages: Packages | None = None,
                 description: str = 'robot_description') -> None:
        self.files = PackageFiles(package, (packages or Packages()).beside(package), name)
        self.description = description

    @property
    def problems(self) -> list[Problem]:
        """What was odd in choosing and reading the files."""
        return self.files.problems

    def urdf_file(self, file_path: str | Path | None = None) -> Path:
        """
        Return the URDF or xacro file.

        :raises ConfigError: where there is none.
        """
        found = self._named(file_path) if file_path else self.files.urdf()
        return self._existing(found, 'URDF', 'robot_description')

    def srdf_file(self, file_path: str | Path | None = None) -> Path:
        """
        Return the SRDF or xacro file.

        :raises ConfigError: where there is none.
        """
        found = self._named(file_path) if file_path else self.files.srdf()
        return self._existing(found, 'SRDF', 'robot_description_semantic')

    def _existing(self, found: Path | None, kind: str, method: str) -> Path:
        """Return a file that is there; ConfigError with the method that names it otherwise."""
        if found is None or not found.is_file():
            folder = self.files.folder
            raise ConfigError(Problem(
                f"the {kind} '{found}' does not exist" if found else
                f"package '{folder.name}' has no {kind}",
                Location(str(folder)), remedy=f'name it with {method}(file_path=)'))
        return found

    def robot_description(self, file_path: str | Path | None = None,
                          mappings: Mapping[str, str] | None = None) -> Parameters:
        """
        Return the URDF after xacro.

        :param mappings: arguments of the xacro, unless empty in place of the setup assistant's.
        :raises ConfigError: where it cannot be read.
        """
        file = self.urdf_file(file_path)
        return {self.description: self._described(
            file, mappings or self.files.assistant.xacro_args)}

    def robot_description_semantic(self, file_path: str | Path | None = None,
                                   mappings: Mapping[str, str] | None = None) -> Parameters:
        """
        Return the SRDF after xacro.

        :raises ConfigError: where it cannot be read.
        """
        file = self.srdf_file(file_path)
        return {f'{self.description}_semantic': self._described(file, mappings or {})}

    def robot_description_kinematics(self, file_path: str | Path | None = None) -> Parameters:
        """Return the solvers of the planning groups; ConfigError where a named file is wrong."""
        return {f'{self.description}_kinematics': self._read('kinematics.yaml', file_path)}

    def joint_limits(self, file_path: str | Path | None = None) -> Parameters:
        """Return the limits over those of the URDF; ConfigError where a named file is wrong."""
        return {f'{self.description}_planning': self._read('joint_limits.yaml', file_path)}

    def pilz_cartesian_limits(self, file_path: str | Path | None = None) -> Parameters:
        """Return the limits of the tool; ConfigError where a named file is wrong."""
        found = self._named(file_path) if file_path else self.files.cartesian_limits()
        return {f'{self.description}_planning': self._load(found)}

    def moveit_cpp(self, file_path: str | Path | None = None) -> Parameters:
        """Return the parameters of MoveItCpp; ConfigError where a named file is wrong."""
        return self._read('moveit_cpp.yaml', file_path)

    def sensors_3d(self, file_path: str | Path | None = None) -> Parameters:
        """Return the sensors of an octomap; none where file, list or its first entry is absent."""
        if file_path and not self._named(file_path).is_file():
            return {}
        found = self._read('sensors_3d.yaml', file_path)
        listed = found.get('sensors')
        return found if isinstance(listed, list) and listed and listed[0] else {}

    def trajectory_execution(self, file_path: str | Path | None = None,
                             moveit_manage_controllers: bool = True) -> Parameters:
        """Return move_group's controllers; ConfigError where a named file is wrong."""
        found = self._named(file_path) if file_path else self.files.moveit_controllers()
        return {'moveit_manage_controllers': moveit_manage_controllers, **self._load(found)}

    def planning_pipelines(self, default_planning_pipeline: str | None = None,
                           pipelines: Sequence[str] | None = None,
                           load_all: bool = True) -> Parameters:
        """
        Return the planning pipelines.

        :param pipelines: their names; where None those of the package.
        :param load_all: with them, where no names are given, those that need no file.
        :raises ConfigError: where the default is none of them.
        """
        own = self.files.pipelines()
        names = list(pipelines) if pipelines is not None else list(own)
        if pipelines is None and load_all:
            names += [name for name in DEFAULT_PIPELINES if name not in names]
        default = default_planning_pipeline or ('ompl' if 'ompl' in names else
                                                next(iter(names), ''))
        if default not in names:
            raise ConfigError(Problem(
                f"the default planning pipeline '{default}' is none of those loaded",
                Location(str(self.files.folder)), ', '.join(names)))
        blocks = {name: self._load(own[name]) if name in own else default_pipeline(name)
                  for name in names}
        if 'ompl' in blocks and 'planner_configs' not in blocks['ompl']:
            blocks['ompl']['planner_configs'] = planner_configs()
        return {'planning_pipelines': names, 'default_planning_pipeline': default, **blocks}

    def _described(self, file: Path, mappings: Mapping[str, str]) -> str:
        try:
            return read_description(file, mappings=mappings,
                                    packages=self.files.packages.beside(file))
        except ResourceError as error:
            raise ConfigError(Problem(str(error), Location(str(file)))) from None

    def _named(self, file_path: str | Path) -> Path:
        return self.files.folder / file_path

    def _read(self, name: str, file_path: str | Path | None) -> Parameters:
        """Return a named file, or the file of an exact name; empty where there is none."""
        return self._load(self._named(file_path) if file_path else self.files.settings_file(name))

    def _load(self, file: Path | None) -> Parameters:
        if file is None:
            return {}
        plain: Parameters = read_yaml_file(file, self.files.problems).plain()
        return plain
