# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A package's settings files, controllers too, to the neutral form by the role of each file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
import re

from armsim_ros.config.controllers.controller_settings import BROADCASTER, TRAJECTORY
from armsim_ros.config.draft import ConfigDraft
from armsim_ros.config.layout import LayoutReader
from armsim_ros.config.package_files import PackageFiles, pipeline_of, Role
from armsim_ros.config.pipeline_defaults import default_pipeline, OMPL, planner_configs
from armsim_ros.config.yaml_node import is_ros2_file, node_of, YamlNode
from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.errors import ConfigError, ignored, Location, Problem, ResourceError, Severity
from armsim_ros.packages import Packages
from armsim_ros.resources import expand_find

GRIPPER = 'position_controllers/GripperActionController'
_BROADCASTER_NAME = 'joint_state_broadcaster'
#: Managers of MoveIt's that ask the controller manager what there is.
_ASKING = 'moveit_ros_control_interface/'
_TRAJECTORY_CLASS = 'JointTrajectoryController'


def complete_controllers(draft: ConfigDraft, folder: Path) -> None:
    """
    Add the controllers that must run and that no file describes.

    Each controller in move_group's list that no file describes becomes a controller of
    its name and joints. A robot always has a joint state broadcaster.

    :param folder: named in the message about what was added.
    """
    described = draft.section('controllers').entries
    _tell_move_group(draft)
    added: list[str] = []
    for name, node in draft.section('moveit_controllers').entries.items():
        namespace, _, own = name.strip('/').rpartition('/')
        block = _controller(node)
        if own not in described and block is not None:
            draft.see_namespace(namespace, node.place)
            draft.add_entry('controllers', own, node_of(block, node.place))
            added.append(own)
    kinds = [node.get('type') for node in described.values()]
    if not any(kind is not None and str(kind.value).endswith('JointStateBroadcaster')
               for kind in kinds) and _BROADCASTER_NAME not in described:
        where = Location(str(folder))
        draft.add_entry('controllers', _BROADCASTER_NAME, node_of({'type': BROADCASTER}, where))
        added.append(_BROADCASTER_NAME)
    if added:
        draft.problems.append(Problem(
            f"no file describes the controllers {', '.join(added)}; they run with the usual "
            'parameters', Location(str(folder)), severity=Severity.INFO))


def _tell_move_group(draft: ConfigDraft) -> None:
    """List all trajectory controllers for move_group where its manager would query them."""
    manager = draft.section('trajectory_execution').get('moveit_controller_manager')
    if manager is None or not str(manager.value).startswith(_ASKING):
        return
    if draft.section('moveit_controllers').entries:
        return
    for name, node in draft.section('controllers').entries.items():
        kind, joints = node.get('type'), node.get('joints')
        if kind is None or joints is None or not str(kind.value).endswith(_TRAJECTORY_CLASS):
            continue
        block = {'name': name, 'type': 'FollowJointTrajectory', 'default': True,
                 'action_ns': 'follow_joint_trajectory',
                 'joints': [item.text for item in joints.items]}
        draft.add_entry('moveit_controllers', name, node_of(block, node.place))


def _controller(node: YamlNode) -> dict[str, object] | None:
    """Return the parameters of the controller that serves an entry of move_group's."""
    kind, joints = node.get('type'), node.get('joints')
    names = [item.text for item in joints.items] if joints is not None else []
    if not names:
        return None
    if kind is not None and kind.value == 'GripperCommand':
        leader = node.get('command_joint')
        return {'type': GRIPPER, 'joint': leader.text if leader is not None else names[0]}
    return {'type': TRAJECTORY, 'joints': names, 'command_interfaces': ['position'],
            'state_interfaces': ['position', 'velocity']}


#: Read apart.
_APART = (Role.SENSORS,)
_NOT_READ = (Role.MOVEIT_CPP,)


@dataclass(frozen=True)
class PackageRoles:
    """
    What is read of a package.

    :param roles: file -> what it is to the stack, in reading order.
    :param remarks: a line for each file that is not read.
    """

    roles: Mapping[Path, Role]
    remarks: tuple[Problem, ...] = ()

    @property
    def files(self) -> tuple[Path, ...]:
        """All files that are read."""
        return tuple(self.roles)

    @property
    def ros2_controllers(self) -> tuple[Path, ...]:
        """The files with ros2_control's controllers."""
        return tuple(file for file, role in self.roles.items() if role is Role.ROS2_CONTROLLERS)

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
        apart = [file for file, role in roles.items() if role in _APART]
        for file in (*left_out, *apart):
            del roles[file]
        roles.update(dict.fromkeys(package.pipelines().values(), Role.PIPELINE))
        moveit = package.moveit_controllers()
        if moveit is not None:
            roles[moveit] = Role.MOVEIT_CONTROLLERS
        own = package.ros2_controllers()
        for file in controllers or ((own,) if own is not None else ()):
            roles[file] = Role.ROS2_CONTROLLERS
        remarks = [_left_out(file, f'is of {what}') for file, what in left_out.items()]
        remarks += [_left_out(file, 'is none of those that the stack reads by their name')
                    for file in package.settings_files()
                    if file not in roles and file not in left_out and file not in apart]
        return cls(roles, tuple(remarks))


def _left_out(file: Path, what: str) -> Problem:
    return Problem(f'the file {what} and is not read', Location(str(file)),
                   severity=Severity.INFO)


_VAR = re.compile(r'\$\(var\s+([^)\s]+)\s*\)')
#: Files in which a launch file may have values filled in.
_FILLED_IN = (Role.MOVEIT_CONTROLLERS, Role.ROS2_CONTROLLERS, Role.JOINT_LIMITS)

#: The block of the draft with the joints' start; the URDF overrides it.
_START = 'start'


def start_positions(draft: ConfigDraft) -> dict[str, float]:
    """Return where a package lets the joints start, by joint [rad or m]."""
    found = draft.section(_START).entries
    return {joint: float(node.value) for joint, node in found.items()
            if isinstance(node.value, (int, float)) and not isinstance(node.value, bool)}


class PackageReader:
    """
    Reads the files of a package into a draft.

    :param draft: takes what is found.
    :param packages: finds what ``$(find-pkg-share p)`` names.
    :param variables: the values of ``$(var x)``.
    """

    def __init__(self, draft: ConfigDraft, packages: Packages, variables: Mapping[str, str]
                 ) -> None:
        self._draft, self._packages, self._variables = draft, packages, variables
        self._layout = LayoutReader(draft)

    def read(self, roles: PackageRoles) -> None:
        """Read all files of a package."""
        for file, role in roles.roles.items():
            try:
                root = self._read_file(file, role)
                self._take(root, file, role)
            except ConfigError as error:
                self._draft.problems.extend(error.problems)
        self._add_ompl_defaults()

    def _add_ompl_defaults(self) -> None:
        """Add what MoveItConfigsBuilder takes where the package has no settings of OMPL."""
        found = self._draft.section('pipelines').get(OMPL)
        where = self._draft.section('pipelines').where if found is None else found.where
        if found is None:
            self._layout.take_pipeline(node_of(default_pipeline(OMPL), where), OMPL)
        if found is None or found.get('planner_configs') is None:
            configs = node_of({'planner_configs': planner_configs()}, where)
            self._layout.take_pipeline(configs, OMPL)

    def _read_file(self, file: Path, role: Role) -> YamlNode:
        def substitute(text: str) -> str:
            return self._filled_in(text, file)

        return read_yaml_file(file, self._draft.problems,
                              substitute=substitute if role in _FILLED_IN else None)

    def _filled_in(self, text: str, file: Path) -> str:
        """Return a text with the values of a launch file's ``$(var x)`` filled in."""
        missing: dict[str, int] = {}

        def value(match: re.Match[str]) -> str:
            name = match[1]
            if name not in self._variables:
                missing.setdefault(name, text.count('\n', 0, match.start()) + 1)
            return self._variables.get(name, '')

        filled = _VAR.sub(value, text)
        for name, line in missing.items():
            self._draft.problems.append(Problem(
                f"'$(var {name})' has no value; nothing is put in its place",
                Location(str(file), line), '', f'give {name}:=VALUE', Severity.WARNING))
        try:
            return expand_find(filled, self._packages)
        except ResourceError as error:
            self._draft.problems.append(ignored(Problem(str(error), Location(str(file)))))
            return filled

    def _take(self, root: YamlNode, file: Path, role: Role) -> None:
        if role is Role.PIPELINE:
            self._layout.take_pipeline(root, pipeline_of(file))
        elif is_ros2_file(root) or role in (
                Role.MOVEIT_CONTROLLERS, Role.TRAJECTORY_EXECUTION, Role.ROS2_CONTROLLERS,
                Role.SIMULATION):
            self._layout.read(root, file.stem)
        elif role is Role.KINEMATICS:
            self._take_kinematics(root)
        elif role is Role.JOINT_LIMITS:
            self._layout.read(root.get('robot_description_planning') or root, 'joint_limits')
        elif role is Role.CARTESIAN_LIMITS:
            self._layout.read(root, file.stem)
        elif role is Role.INITIAL_POSITIONS:
            positions = root.get('initial_positions') or root
            if positions.is_mapping:
                self._draft.add(_START, positions)

    def _take_kinematics(self, root: YamlNode) -> None:
        inner = root.get('robot_description_kinematics') or root
        for group, solver in inner.entries.items():
            if solver.is_mapping:
                self._draft.add_entry('kinematics', group, solver)
            else:
                self._draft.problems.append(ignored(Problem(
                    f"'{group}' is {solver.kind} and no planning group's solver", solver.place)))
