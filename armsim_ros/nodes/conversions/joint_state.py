# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``sensor_msgs/msg/JointState`` and ``control_msgs/msg/DynamicJointState``, filled in place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from control_msgs.msg import DynamicJointState, InterfaceValue
import numpy as np
from sensor_msgs.msg import JointState

from armsim_ros.arrays import Vector
from armsim_ros.nodes.conversions.time import fill_time


class JointStateBuffer:
    """
    A message that is created once and refilled.

    :param joint_names: (n,).
    :param frame_id: frame in the header.
    """

    def __init__(self, joint_names: Sequence[str], frame_id: str = '') -> None:
        count = len(joint_names)
        self.message = JointState(name=list(joint_names))
        self.message.header.frame_id = frame_id
        nan = [float('nan')] * count
        self.message.position, self.message.velocity, self.message.effort = nan, nan, nan
        self._position = np.frombuffer(self.message.position, dtype=np.float64)
        self._velocity = np.frombuffer(self.message.velocity, dtype=np.float64)
        self._effort = np.frombuffer(self.message.effort, dtype=np.float64)

    def fill(
        self, time_ns: int, position: Vector, velocity: Vector, effort: Vector
    ) -> JointState:
        """
        Write a state into the message and return it.

        :param time_ns: [ns].
        :param position: (n,) [rad or m]; NaN where there is none, as for the others.
        :param velocity: (n,) [rad/s or m/s].
        :param effort: (n,) [N*m or N].
        """
        fill_time(self.message.header.stamp, time_ns)
        self._position[:] = position
        self._velocity[:] = velocity
        self._effort[:] = effort
        return self.message


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
