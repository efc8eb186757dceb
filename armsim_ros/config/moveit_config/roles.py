# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The settings files of a package with what each is to the stack; the others get a line each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from armsim_ros.config.moveit_config.files import PackageFiles, Role
from armsim_ros.errors import Location, Problem, Severity

#: Pipelines that move_group offers here; the others of a package are named in a line.
OFFERED_PIPELINES = ('ompl', 'pilz_industrial_motion_planner')
_NOT_READ = (Role.SENSORS, Role.MOVEIT_CPP)


@dataclass(frozen=True)
class PackageRoles:
    """
    What is read of a package.

    :param roles: file -> what it is to the stack, in reading order.
    :param pipelines: planning pipeline -> its file.
    :param remarks: a line for each file that is not read.
    """

    roles: Mapping[Path, Role]
    pipelines: Mapping[str, Path] = field(default_factory=dict)
    remarks: tuple[Problem, ...] = ()

    @property
    def files(self) -> tuple[Path, ...]:
        """All files that are read."""
        return tuple(self.roles)

    @property
    def ros2_controllers(self) -> tuple[Path, ...]:
        """The files with ros2_control's controllers."""
        return tuple(file for file, role in self.roles.items()
                     if role is Role.ROS2_CONTROLLERS)

    def with_controllers(self, files: Iterable[Path]) -> PackageRoles:
        """Return the same with other files for ros2_control's controllers."""
        roles: dict[Path, Role] = {file: role for file, role in self.roles.items()
                 if role is not Role.ROS2_CONTROLLERS}
        roles.update((file, Role.ROS2_CONTROLLERS) for file in files)
        remarks = tuple(remark for remark in self.remarks
                        if remark.where is None or Path(remark.where.file) not in roles)
        return replace(self, roles=roles, remarks=remarks)

    @classmethod
    def of(cls, package: PackageFiles, controllers: tuple[Path, ...] = ()) -> PackageRoles:
        """
        Return which of a package's files are read.

        :param controllers: files with ros2_control's controllers in place of the package's own.
        """
        roles = package.by_role()
        left_out = {file: role.value for file, role in roles.items() if role in _NOT_READ}
        for file in left_out:
            del roles[file]
        pipelines = package.pipelines()
        for name, file in pipelines.items():
            if name in OFFERED_PIPELINES:
                roles[file] = Role.PIPELINE
            else:
                left_out[file] = f"planning pipeline '{name}', which is not offered"
        moveit = package.moveit_controllers()
        if moveit is not None:
            roles[moveit] = Role.MOVEIT_CONTROLLERS
        own = package.ros2_controllers()
        for file in controllers or ((own,) if own is not None else ()):
            roles[file] = Role.ROS2_CONTROLLERS
        remarks = [_left_out(file, f'is of {what}') for file, what in left_out.items()]
        remarks += [_left_out(file, 'is none of those that the stack reads by their name')
                    for file in package.settings_files()
                    if file not in roles and file not in left_out]
        return cls(roles, pipelines, tuple(remarks))


def _left_out(file: Path, what: str) -> Problem:
    return Problem(f'the file {what} and is not read', Location(str(file)),
                   severity=Severity.INFO)
