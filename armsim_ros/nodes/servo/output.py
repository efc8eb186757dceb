# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint commands on the controller's topic."""

from __future__ import annotations

from collections.abc import Callable

from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from armsim_ros.config.servo import ARRAY, ServoParameters
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.conversions.trajectory import fill_point
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.servo.stream import Cycle, ServoStream
from armsim_ros.servo.trajectory_window import TrajectoryWindow
from armsim_ros.trajectory import TrajectoryPoint


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
        self._message = JointTrajectory(joint_names=list(names))
        self._points: list[JointTrajectoryPoint] = []

    @property
    def heard(self) -> bool:
        """Whether anybody subscribes."""
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
        trajectory = self._window.trajectory()
        if trajectory is None:
            return
        sent = [what for what in ('positions', 'velocities', 'accelerations')
                if getattr(parameters, f'publish_joint_{what}')]
        message = self._message
        fill_time(message.header.stamp, trajectory.stamp_ns)
        while len(self._points) < len(trajectory):
            self._points.append(JointTrajectoryPoint())
        message.points = self._points[: len(trajectory)]
        for target, point, time in zip(
            message.points, trajectory.points(), trajectory.times.tolist(), strict=True
        ):
            values = {what: getattr(point, what) for what in sent}
            fill_point(target, TrajectoryPoint(**values), time)
        self._publisher.publish(message)
