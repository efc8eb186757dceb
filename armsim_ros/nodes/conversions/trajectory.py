# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories, tolerances and states of joints: messages to the core's values, and back."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import DynamicJointState, InterfaceValue, JointTrajectoryControllerState
from control_msgs.msg import JointTolerance as JointToleranceMessage
from geometry_msgs.msg import Transform, Twist
import numpy as np
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage
from trajectory_msgs.msg import JointTrajectoryPoint as JointTrajectoryPointMessage
from trajectory_msgs.msg import MultiDOFJointTrajectory, MultiDOFJointTrajectoryPoint

from armsim_ros.arrays import Vector
from armsim_ros.control.trajectory.controller_state import (
    ControllerSnapshot,
    ERROR,
    FEEDBACK,
    KINDS,
    OUTPUT,
    REFERENCE,
)
from armsim_ros.control.trajectory.tolerances import JointTolerance
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.execution.controller_selection import MultiDofTrajectory
from armsim_ros.nodes.conversions.serialized import SerializedMessage
from armsim_ros.nodes.conversions.time import (
    fill_duration,
    fill_time,
    ns_from_seconds,
    ns_from_time,
    seconds_from_duration,
)
from armsim_ros.trajectory import JointTrajectory, QUANTITIES, TrajectoryPoint


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
        [seconds_from_duration(point.time_from_start) for point in message.points], message.points,
        ns_from_time(message.header.stamp))


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
            name=message.name, position=message.position, velocity=message.velocity,
            acceleration=message.acceleration)
        for message in messages)


def serialized_joint_state(joint_names: Sequence[str], frame_id: str = '') -> SerializedMessage:
    """
    Return a message whose numbers are all positions, then velocities, then efforts.

    :param joint_names: (n,).
    :param frame_id: frame in the header.
    """
    nan = [float('nan')] * len(joint_names)
    message = JointState(name=list(joint_names), position=nan, velocity=nan, effort=nan)
    message.header.frame_id = frame_id
    return SerializedMessage(
        message, [message.header.stamp],
        [(message, name) for name in ('position', 'velocity', 'effort')])


class DynamicJointStateBuffer:
    """
    A message that is created once and refilled.

    :param interfaces: joint -> names of its state interfaces, in the order of the message.
    :param frame_id: frame in the header.
    """

    def __init__(self, interfaces: Mapping[str, Sequence[str]], frame_id: str = '') -> None:
        self.message = DynamicJointState(joint_names=list(interfaces))
        self.message.header.frame_id = frame_id
        self.message.interface_values = [
            InterfaceValue(interface_names=list(names), values=[float('nan')] * len(names))
            for names in interfaces.values()]

    def fill(self, time_ns: int, values: Sequence[Sequence[float]]) -> DynamicJointState:
        """
        Write values into the message and return it.

        :param time_ns: [ns].
        :param values: for each joint the values of its interfaces.
        """
        fill_time(self.message.header.stamp, time_ns)
        for interface, numbers in zip(self.message.interface_values, values, strict=True):
            interface.values = numbers
        return self.message


class SerializedControllerState:
    """
    The message of ``controller_state``, for all snapshots with the same joints and interfaces.

    :param snapshot: a snapshot with these joints and interfaces.
    """

    def __init__(self, snapshot: ControllerSnapshot) -> None:
        joints, states, commands = self._shape = _shape(snapshot)
        message = JointTrajectoryControllerState(joint_names=list(joints))
        parts = (
            (message.reference, REFERENCE, KINDS[:3]), (message.feedback, FEEDBACK, states),
            (message.error, ERROR, states), (message.output, OUTPUT, commands))
        numbers: list[tuple[Any, str]] = []
        rows = []
        for point, first, have in parts:
            for i, (kind, field) in enumerate(_FIELDS.items()):
                if kind in have:
                    setattr(point, field, _numbers(np.zeros(len(joints))))
                    numbers.append((point, field))
                    rows.append(first + i)
        self._rows = np.array(rows, np.intp)
        self._message = SerializedMessage(
            message, [message.header.stamp], [*numbers, (message, 'speed_scaling_factor')],
            [point.time_from_start for point, _, _ in parts])

    def fits(self, snapshot: ControllerSnapshot) -> bool:
        """Return whether the snapshot has the same joints and interfaces."""
        return self._shape == _shape(snapshot)

    def of(self, snapshot: ControllerSnapshot) -> bytes:
        """Return the serialized message of a snapshot that fits."""
        desired = ns_from_seconds(snapshot.desired_time_from_start)
        actual = ns_from_seconds(snapshot.actual_time_from_start)
        self._message.set_numbers(
            np.append(snapshot.data[self._rows], snapshot.speed_scaling_factor))
        self._message.set_durations(np.array([desired, actual, actual, desired]))
        return self._message.at(snapshot.time_ns)


#: Interface -> field of a point.
_FIELDS = dict(zip(KINDS, QUANTITIES, strict=True))


def _shape(snapshot: ControllerSnapshot) -> tuple[tuple[str, ...], ...]:
    return snapshot.joint_names, snapshot.state_interfaces, snapshot.command_interfaces


def fill_feedback(message: FollowJointTrajectory.Feedback, snapshot: ControllerSnapshot) -> None:
    """Write a snapshot into the feedback of ``follow_joint_trajectory``."""
    fill_time(message.header.stamp, snapshot.time_ns)
    message.joint_names = list(snapshot.joint_names)
    fill_point(message.desired, snapshot.reference, snapshot.desired_time_from_start)
    fill_point(message.actual, snapshot.feedback, snapshot.actual_time_from_start)
    fill_point(message.error, snapshot.error, snapshot.actual_time_from_start)
    message.desired.effort = snapshot.desired_effort.tolist()
    message.actual.effort = snapshot.commanded_effort.tolist()
    message.error.effort = [0.0] * len(snapshot.joint_names)
