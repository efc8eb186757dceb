# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A trajectory controller's snapshot as state and feedback messages, filled in place."""

from __future__ import annotations

from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTrajectoryControllerState

from armsim_ros.control.trajectory.controller_state import ControllerSnapshot
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.conversions.trajectory import fill_point


def fill_controller_state(
    message: JointTrajectoryControllerState, snapshot: ControllerSnapshot
) -> None:
    """Write a snapshot into the message of ``controller_state``."""
    fill_time(message.header.stamp, snapshot.time_ns)
    message.joint_names = list(snapshot.joint_names)
    fill_point(message.reference, snapshot.reference, snapshot.desired_time_from_start)
    fill_point(message.feedback, snapshot.feedback, snapshot.actual_time_from_start)
    fill_point(message.error, snapshot.error, snapshot.actual_time_from_start)
    fill_point(message.output, snapshot.output, snapshot.desired_time_from_start)
    message.speed_scaling_factor = snapshot.speed_scaling_factor


def fill_feedback(
    message: FollowJointTrajectory.Feedback, snapshot: ControllerSnapshot
) -> None:
    """Write a snapshot into the feedback of ``follow_joint_trajectory``."""
    fill_time(message.header.stamp, snapshot.time_ns)
    message.joint_names = list(snapshot.joint_names)
    fill_point(message.desired, snapshot.reference, snapshot.desired_time_from_start)
    fill_point(message.actual, snapshot.feedback, snapshot.actual_time_from_start)
    fill_point(message.error, snapshot.error, snapshot.actual_time_from_start)
    message.desired.effort = snapshot.desired_effort.tolist()
    message.actual.effort = snapshot.commanded_effort.tolist()
    message.error.effort = [0.0] * len(snapshot.joint_names)
