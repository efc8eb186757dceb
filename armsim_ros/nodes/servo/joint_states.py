# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint positions, read on demand."""

from __future__ import annotations

from collections.abc import Sequence
import math

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
