# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The command that a gripper's controller gets for its part of a trajectory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from armsim_ros.config.move_group.trajectory_execution import MoveItControllerSettings
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.trajectory import JointTrajectory

_SOURCE = 'trajectory execution'


@dataclass(frozen=True, slots=True)
class GripperTarget:
    """
    Where a gripper is to go.

    :param joint: the command joint; with ``parallel`` the first of the two.
    :param position: [rad or m]; with ``parallel`` the sum of both joints.
    :param effort: of the last point [N*m or N], None where that has none.
    :param assumed: whether the first joint of the part replaces the command joint.
    """

    joint: str
    position: float
    effort: float | None = None
    assumed: bool = False


def gripper_target(part: JointTrajectory, controller: MoveItControllerSettings) -> GripperTarget:
    """
    Return the target of a GripperCommand: the last point of the command joint.

    :param part: of a trajectory, with joints of this controller only.
    :raises PlanningError: CONTROL_FAILED where the last point has no positions.
    """
    jaws = controller.joints if controller.parallel else (
        controller.command_joint or controller.joints[0],)
    found = [k for k, name in enumerate(part.joint_names) if name in jaws]
    columns = found or [0]
    effort = part.effort[-1, columns[-1]] if part.effort is not None else np.nan
    return GripperTarget(
        part.joint_names[columns[0]], sum(_last(part, column) for column in columns),
        None if np.isnan(effort) else float(effort), assumed=not found,
    )


def parallel_gripper_target(
    part: JointTrajectory, controller: MoveItControllerSettings
) -> GripperTarget:
    """
    Return the target of a ParallelGripperCommand: the last point of the first joint.

    :param part: of a trajectory, with joints of this controller only.
    :raises PlanningError: CONTROL_FAILED where the part lacks that joint, or its position.
    """
    joint = controller.joints[0]
    if joint not in part.joint_names:
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED,
            f"the trajectory has no joint '{joint}', which controller '{controller.name}' "
            f'commands; it has {", ".join(part.joint_names)}', _SOURCE)
    return GripperTarget(joint, _last(part, part.joint_names.index(joint)))


def _last(part: JointTrajectory, column: int) -> float:
    """Return the last position of a joint [rad or m]."""
    value = float(part.positions[-1, column])
    if np.isnan(value):
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED,
            f"the last point has no position of joint '{part.joint_names[column]}', which a "
            'gripper needs', _SOURCE)
    return value
