# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Controllers that a package leaves to others: made from move_group's list."""

from __future__ import annotations

from pathlib import Path

from armsim_ros.config.controllers.controller_settings import BROADCASTER, TRAJECTORY
from armsim_ros.config.draft import ConfigDraft
from armsim_ros.config.yaml.node import node_of, YamlNode
from armsim_ros.errors import Location, Problem, Severity

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
