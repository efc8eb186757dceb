# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``trajectory_msgs/msg/JointTrajectory`` to the core's trajectory and back."""

from __future__ import annotations

from array import array
from collections.abc import Sequence

import numpy as np
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage
from trajectory_msgs.msg import JointTrajectoryPoint as JointTrajectoryPointMessage

from armsim_ros.arrays import Vector
from armsim_ros.nodes.conversions.time import (
    fill_duration,
    fill_time,
    ns_from_time,
    seconds_from_duration,
)
from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint


def vector(values: Sequence[float]) -> Vector:
    """Return a message's numbers as an array of its own (n,)."""
    return np.array(values, dtype=np.float64)


def trajectory_from_message(message: JointTrajectoryMessage) -> JointTrajectory:
    """
    Return the trajectory of a message, with a fault where its points do not fit its joints.

    :param message: the header's frame is not used.
    """
    return JointTrajectory.of_points(
        message.joint_names,
        [seconds_from_duration(point.time_from_start) for point in message.points],
        message.points,
        ns_from_time(message.header.stamp),
    )


def trajectory_to_message(trajectory: JointTrajectory) -> JointTrajectoryMessage:
    """Return the message of a trajectory."""
    message = JointTrajectoryMessage(joint_names=list(trajectory.joint_names))
    fill_time(message.header.stamp, trajectory.stamp_ns)
    message.points = [JointTrajectoryPointMessage() for _ in trajectory.times]
    for target, point, time in zip(
        message.points, trajectory.points(), trajectory.times.tolist(), strict=True
    ):
        fill_point(target, point, time)
    return message


def fill_point(
    message: JointTrajectoryPointMessage, point: TrajectoryPoint, time_from_start: float
) -> None:
    """
    Write values into an existing waypoint message.

    :param time_from_start: [s].
    """
    message.positions = _numbers(point.positions)
    message.velocities = _numbers(point.velocities)
    message.accelerations = _numbers(point.accelerations)
    message.effort = _numbers(point.effort)
    fill_duration(message.time_from_start, time_from_start)


def _numbers(values: Vector) -> array[float]:
    """Return values in the form that messages keep without looking at each of them."""
    return array('d', np.asarray(values, dtype=np.float64).tobytes())
