# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``/clock``."""

from __future__ import annotations

from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage

from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time


class Clock:
    """
    Publishes the simulation's time.

    :param node: the node that publishes.
    """

    def __init__(self, node: Node) -> None:
        """Make the publisher."""
        self._publisher = node.create_publisher(ClockMessage, '/clock', qos.CLOCK)
        self._message = ClockMessage()

    def publish(self, time_ns: int) -> None:
        """
        Publish a time.

        :param time_ns: [ns] of the simulation.
        """
        fill_time(self._message.clock, time_ns)
        self._publisher.publish(self._message)
