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
    Return the trajectory of a message as it stands; nothing is checked.

    :param message: the header's frame is not used.
    """
    return JointTrajectory(
        joint_names=tuple(message.joint_names),
        points=tuple(point_from_message(point) for point in message.points),
        stamp_ns=ns_from_time(message.header.stamp),
    )


def point_from_message(message: JointTrajectoryPointMessage) -> TrajectoryPoint:
    """Return the waypoint of a message as it stands."""
    return TrajectoryPoint(
        time_from_start=seconds_from_duration(message.time_from_start),
        positions=vector(message.positions),
        velocities=vector(message.velocities),
        accelerations=vector(message.accelerations),
        effort=vector(message.effort),
    )


def trajectory_to_message(trajectory: JointTrajectory) -> JointTrajectoryMessage:
    """Return the message of a trajectory."""
    message = JointTrajectoryMessage(joint_names=list(trajectory.joint_names))
    fill_time(message.header.stamp, trajectory.stamp_ns)
    message.points = [point_to_message(point) for point in trajectory.points]
    return message


def point_to_message(point: TrajectoryPoint) -> JointTrajectoryPointMessage:
    """Return the message of a waypoint."""
    message = JointTrajectoryPointMessage()
    fill_point(
        message,
        point.time_from_start,
        positions=point.positions,
        velocities=point.velocities,
        accelerations=point.accelerations,
        effort=point.effort,
    )
    return message


def fill_point(
    message: JointTrajectoryPointMessage,
    time_from_start: float,
    *,
    positions: Vector | None = None,
    velocities: Vector | None = None,
    accelerations: Vector | None = None,
    effort: Vector | None = None,
) -> None:
    """
    Write values into an existing waypoint message; a field without values becomes empty.

    :param time_from_start: [s].
    :param positions: (n,) [rad or m].
    :param velocities: (n,) [rad/s or m/s].
    :param accelerations: (n,) [rad/s^2 or m/s^2].
    :param effort: (n,) [N*m or N].
    """
    message.positions = _numbers(positions)
    message.velocities = _numbers(velocities)
    message.accelerations = _numbers(accelerations)
    message.effort = _numbers(effort)
    fill_duration(message.time_from_start, time_from_start)


def _numbers(values: Vector | None) -> array[float]:
    """Return values in the form that messages keep without looking at each of them."""
    numbers = array('d')
    if values is not None:
        numbers.frombytes(np.ascontiguousarray(values, dtype=np.float64).tobytes())
    return numbers
