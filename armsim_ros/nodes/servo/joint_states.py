# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint positions and time, read on demand."""

from __future__ import annotations

from collections.abc import Sequence
import math
import time

from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from armsim_ros.arrays import Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.nodes.polling_node import PollingNode


class JointPositions:
    """
    The newest position of every joint.

    :param topics: joint states; several robots may have a topic each.
    :param needed: joints without which no command is followed; others keep their default until
        a message has them.
    """

    def __init__(
        self, node: PollingNode, kinematics: KinematicModel, topics: Sequence[str],
        needed: Sequence[str],
    ) -> None:
        self._kinematics = kinematics
        self._places = {name: place for place, name in enumerate(kinematics.names)}
        self._missing = set(needed)
        #: (n,) [rad or m].
        self.q: Vector = kinematics.default()
        #: Of the newest message [ns].
        self.stamp_ns = 0
        profile = QoSProfile(depth=4, reliability=qos.COMMAND.reliability)
        self.subscriptions = [
            node.poll(JointState, topic, self._receive, profile) for topic in topics
        ]

    @property
    def missing(self) -> tuple[str, ...]:
        """Needed joints that no message has had yet."""
        return tuple(sorted(self._missing))

    def _receive(self, message: JointState) -> None:
        q = self.q.copy()
        for name, value in zip(message.name, message.position, strict=False):
            place = self._places.get(name)
            if place is not None and math.isfinite(value):
                q[place] = value
        if self._missing:
            self._missing -= set(message.name)
        self.q = self._kinematics.apply_mimic(q)
        self.stamp_ns = ns_from_time(message.header.stamp)


_SAME_NS = 60_000_000
"""Clocks that differ by less are the same clock [ns]; their messages are a step behind."""


class StreamClock:
    """
    The node's time.

    A simulation that runs in real time keeps the wall clock's time; then the wall clock is
    read, which is finer than /clock. Otherwise, as in a pause, /clock is, which is subscribed
    to only then: stamps of joint states show as well that time is what it seems.

    :param node: whose time it is.
    """

    def __init__(self, node: PollingNode) -> None:
        self._node = node
        self._stamp_ns = 0
        self._simulated = bool(node.get_parameter('use_sim_time').value)
        #: Whether simulated time and the wall clock have parted.
        self.parted = False

    def look(self, stamp_ns: int) -> None:
        """
        Compare the clocks; the node has just caught up with its topics.

        :param stamp_ns: the newest stamp of joint states, 0 where none has come.
        """
        self._stamp_ns = stamp_ns
        if self._simulated and stamp_ns:
            self.parted = abs(self._simulated_ns() - time.time_ns()) > _SAME_NS
            if self.parted:
                self._node.follow_clock()

    def now_ns(self) -> int:
        """Return the time [ns]."""
        return self._simulated_ns() if self.parted else time.time_ns()

    def _simulated_ns(self) -> int:
        """Return the time of /clock, or of joint states where that is later."""
        return max(int(self._node.get_clock().now().nanoseconds), self._stamp_ns)
