# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``trajectory_msgs`` and ``control_msgs/msg/JointTolerance`` to the core's values and back."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Sequence
from typing import Any

from control_msgs.msg import JointTolerance as JointToleranceMessage
from geometry_msgs.msg import Transform, Twist
import numpy as np
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage
from trajectory_msgs.msg import JointTrajectoryPoint as JointTrajectoryPointMessage
from trajectory_msgs.msg import MultiDOFJointTrajectory, MultiDOFJointTrajectoryPoint

from armsim_ros.arrays import Vector
from armsim_ros.control.trajectory.tolerances import JointTolerance
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.execution.multi_dof import MultiDofTrajectory
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


def multi_dof_from_message(message: MultiDOFJointTrajectory) -> MultiDofTrajectory | None:
    """
    Return the trajectory of multi-DOF joints, None where it has no points.

    :raises PlanningError: CONTROL_FAILED where the transforms do not fit the joints.
    """
    if not message.points:
        return None
    count = len(message.joint_names)
    for k, point in enumerate(message.points):
        if len(point.transforms) != count:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f'point {k} has {len(point.transforms)} transforms for {count} multi-DOF joints')
    velocities = None
    if all(len(point.velocities) == count for point in message.points):
        velocities = np.array([
            [_xyz(twist.linear) + _xyz(twist.angular) for twist in point.velocities]
            for point in message.points])
    return MultiDofTrajectory(
        tuple(message.joint_names),
        np.array([seconds_from_duration(point.time_from_start) for point in message.points]),
        np.array([
            [[*_xyz(pose.translation), *_xyz(pose.rotation), pose.rotation.w]
             for pose in point.transforms] for point in message.points]),
        velocities, ns_from_time(message.header.stamp))


def multi_dof_to_message(trajectory: MultiDofTrajectory) -> MultiDOFJointTrajectory:
    """Return the message of a trajectory of multi-DOF joints."""
    message = MultiDOFJointTrajectory(joint_names=list(trajectory.joint_names))
    fill_time(message.header.stamp, trajectory.stamp_ns)
    for k, time in enumerate(trajectory.times.tolist()):
        point = MultiDOFJointTrajectoryPoint()
        fill_duration(point.time_from_start, time)
        for row in trajectory.transforms[k].tolist():
            pose = Transform()
            _fill_xyz(pose.translation, row[:3])
            _fill_xyz(pose.rotation, row[3:6])
            pose.rotation.w = row[6]
            point.transforms.append(pose)
        for row in [] if trajectory.velocities is None else trajectory.velocities[k].tolist():
            twist = Twist()
            _fill_xyz(twist.linear, row[:3])
            _fill_xyz(twist.angular, row[3:])
            point.velocities.append(twist)
        message.points.append(point)
    return message


def _xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def _fill_xyz(vector: Any, values: Sequence[float]) -> None:
    vector.x, vector.y, vector.z = values


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
    """Return values in the form that messages keep without checking each of them."""
    return array('d', np.asarray(values, dtype=np.float64).tobytes())


def tolerances_from_messages(
    messages: Iterable[JointToleranceMessage],
) -> tuple[JointTolerance, ...]:
    """Return tolerances unchanged: 0 keeps the default, -1 erases it."""
    return tuple(
        JointTolerance(
            name=message.name,
            position=message.position,
            velocity=message.velocity,
            acceleration=message.acceleration,
        )
        for message in messages
    )
