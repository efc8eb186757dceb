# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint commands on the controller's topic, and the topic ``~/status``."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from typing import Any

from moveit_msgs.msg import ServoStatus as ServoStatusMessage
import numpy as np
from rclpy.serialization import serialize_message
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from armsim_ros.config.servo import ARRAY, ServoParameters
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.serialized import SerializedMessage
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.servo.commands import Finding
from armsim_ros.servo.stream import Cycle, ServoStream
from armsim_ros.servo.trajectory_window import TrajectoryWindow, WindowPoints


class JointCommands:
    """
    Publishes what a stream brings, as trajectories or as plain numbers.

    :param topic: of the controller.
    :param names: (m,) of the joints.
    """

    def __init__(
        self,
        node: PollingNode,
        topic: str,
        names: tuple[str, ...],
        parameters: ServoParameters,
    ) -> None:
        self.topic = topic
        self._plain = parameters.command_out_type == ARRAY
        kind = Float64MultiArray if self._plain else JointTrajectory
        self._publisher = node.create_publisher(kind, topic, qos.STATE)
        self._window = TrajectoryWindow(names, round(parameters.max_expected_latency * 1e9))
        self._period_ns = round(parameters.publish_period * 1e9)
        self._names = names
        #: Fields and number of the points -> the message that has them.
        self._messages: dict[tuple[tuple[str, ...], int], SerializedMessage] = {}

    @property
    def heard(self) -> bool:
        """Whether there are subscribers."""
        return self._publisher.get_subscription_count() > 0

    def start(self, now_ns: int, stream: ServoStream) -> None:
        """Begin anew with a stream that rests at the controller's reference."""
        self._window.start(now_ns, stream.state)

    def replan(
        self, now_ns: int, cycle_ns: int, stream: ServoStream, step: Callable[[], object]
    ) -> None:
        """Replace what lies ahead, see :meth:`TrajectoryWindow.replan`; plain numbers are now."""
        if not self._plain:
            self._window.replan(now_ns, cycle_ns, self._period_ns, stream, step)

    def go_back(self, now_ns: int, stream: ServoStream) -> bool:
        """Forget what lies too far ahead, see :meth:`TrajectoryWindow.go_back`."""
        return self._plain or self._window.go_back(now_ns, self._period_ns, stream)

    def publish(
        self, cycle_ns: int, cycle: Cycle, stream: ServoStream, parameters: ServoParameters
    ) -> None:
        """Publish what a cycle of a stream has brought."""
        if self._plain:
            values = (
                cycle.positions if parameters.publish_joint_positions else cycle.velocities
            )
            self._publisher.publish(Float64MultiArray(data=values.tolist()))
            return
        self._window.add(cycle_ns, stream.state)
        points = self._window.points(accelerations=parameters.publish_joint_accelerations)
        if points is None:
            return
        fields = tuple(name for name, requested in (
            ('positions', parameters.publish_joint_positions),
            ('velocities', parameters.publish_joint_velocities),
            ('accelerations', parameters.publish_joint_accelerations),
        ) if requested)
        self._publisher.publish(self._serialized(points, fields))

    def _serialized(self, points: WindowPoints, fields: tuple[str, ...]) -> bytes:
        """Return a trajectory as it is sent."""
        shape = fields, len(points.spans_ns)
        message = self._messages.get(shape)
        if message is None:
            message = self._messages[shape] = self._make(*shape)
        message.set_numbers(
            np.concatenate([getattr(points, name) for name in fields], axis=1).ravel())
        message.set_durations(points.spans_ns)
        return message.at(points.stamp_ns)

    def _make(self, fields: tuple[str, ...], count: int) -> SerializedMessage:
        numbers = array('d', [0.0] * len(self._names))
        filled: dict[str, Any] = dict.fromkeys(fields, numbers)
        points = [JointTrajectoryPoint(**filled) for _ in range(count)]
        message = JointTrajectory(joint_names=list(self._names), points=points)
        return SerializedMessage(
            message, [message.header.stamp],
            [(point, name) for point in points for name in fields],
            [point.time_from_start for point in points],
        )


class StatusTopic:
    """Publishes the result of each cycle."""

    def __init__(self, node: PollingNode, topic: str) -> None:
        self._publisher = node.create_publisher(ServoStatusMessage, topic, qos.STATE)
        self._finding: Finding | None = None
        self._serialized = b''

    @property
    def heard(self) -> bool:
        """Whether there are subscribers."""
        return self._publisher.get_subscription_count() > 0

    def publish(self, finding: Finding) -> None:
        """Publish a finding; late subscribers get the last."""
        if finding != self._finding:
            self._finding = finding
            self._serialized = serialize_message(
                ServoStatusMessage(code=int(finding.code), message=finding.message))
        self._publisher.publish(self._serialized)
