# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""States of joints and trajectory controllers as messages, filled in place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import DynamicJointState, InterfaceValue, JointTrajectoryControllerState
from sensor_msgs.msg import JointState

from armsim_ros.control.trajectory.controller_state import ControllerSnapshot
from armsim_ros.nodes.conversions.serialized import SerializedMessage
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.conversions.trajectory import fill_point


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
            for names in interfaces.values()
        ]

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
