# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit_msgs/msg/MotionPlanRequest`` to a request, and answers back into messages."""

from __future__ import annotations

from collections.abc import Sequence

from moveit_msgs.msg import (
    DisplayTrajectory,
    MoveItErrorCodes,
    RobotState,
    RobotTrajectory,
)
from moveit_msgs.msg import MotionPlanRequest as MotionPlanRequestMessage
from moveit_msgs.msg import (
    WorkspaceParameters as WorkspaceMessage,
)

from armsim_ros.nodes.conversions.constraints import constraints_from_message
from armsim_ros.nodes.conversions.robot_state import start_state_from_message
from armsim_ros.nodes.conversions.trajectory import trajectory_to_message
from armsim_ros.planning.request import MotionPlanRequest, WorkspaceParameters
from armsim_ros.trajectory import JointTrajectory


def request_from_message(message: MotionPlanRequestMessage, seed: int = -1) -> MotionPlanRequest:
    """
    Return the request of a message as it was given.

    :param seed: of the search; negative for a different seed each time.
    :raises PlanningError: for shapes or poses that cannot exist.
    """
    return MotionPlanRequest(
        group_name=message.group_name,
        goal_constraints=tuple(
            constraints_from_message(item) for item in message.goal_constraints
        ),
        start_state=start_state_from_message(message.start_state),
        path_constraints=constraints_from_message(message.path_constraints),
        pipeline_id=message.pipeline_id,
        planner_id=message.planner_id,
        num_planning_attempts=int(message.num_planning_attempts),
        allowed_planning_time=float(message.allowed_planning_time),
        max_velocity_scaling_factor=float(message.max_velocity_scaling_factor),
        max_acceleration_scaling_factor=float(message.max_acceleration_scaling_factor),
        max_cartesian_speed=float(message.max_cartesian_speed),
        cartesian_speed_limited_link=message.cartesian_speed_limited_link,
        workspace=_workspace(message.workspace_parameters),
        has_trajectory_constraints=bool(message.trajectory_constraints.constraints),
        seed=seed,
    )


def error_code_message(code: int, text: str = '', source: str = '') -> MoveItErrorCodes:
    """Return the message of an error code."""
    return MoveItErrorCodes(val=int(code), message=text, source=source)


def robot_trajectory_message(trajectory: JointTrajectory, frame_id: str) -> RobotTrajectory:
    """Return a trajectory's message; ``frame_id`` is the model frame."""
    message = RobotTrajectory(joint_trajectory=trajectory_to_message(trajectory))
    message.joint_trajectory.header.frame_id = frame_id
    return message


def display_trajectory_message(
    model_id: str, trajectories: Sequence[RobotTrajectory], start: RobotState
) -> DisplayTrajectory:
    """Return what RViz animates: trajectories and the full state that the first begins with."""
    return DisplayTrajectory(
        model_id=model_id, trajectory=list(trajectories), trajectory_start=start
    )


def _workspace(message: WorkspaceMessage) -> WorkspaceParameters:
    low, high = message.min_corner, message.max_corner
    return WorkspaceParameters(
        frame_id=message.header.frame_id,
        min_corner=(float(low.x), float(low.y), float(low.z)),
        max_corner=(float(high.x), float(high.y), float(high.z)),
    )
