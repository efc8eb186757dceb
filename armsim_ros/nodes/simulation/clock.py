# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``/clock``, and a warning when it diverges from the wall clock."""

from __future__ import annotations

from collections.abc import Callable
import time

from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage

from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.simulation.wanted_publisher import WantedPublisher
from armsim_ros.sim.clock import SimClock


class Clock:
    """
    Publishes the simulation's time.

    :param node: the node that publishes.
    :param period_ns: where it is given, every multiple of it that time has passed since the last
        message has its own [ns].
    """

    def __init__(self, node: Node, period_ns: int = 0) -> None:
        self._publisher = WantedPublisher(node, ClockMessage, '/clock', qos.CLOCK)
        self._message = ClockMessage()
        self._period_ns = period_ns
        self._last_ns = 0

    def publish(self, time_ns: int) -> None:
        """
        Publish a time, if it has subscribers.

        :param time_ns: [ns] of the simulation.
        """
        if self._publisher.wanted(time_ns):
            period_ns = self._period_ns
            if period_ns:
                for between_ns in range(
                    (self._last_ns // period_ns + 1) * period_ns, time_ns, period_ns
                ):
                    self._publish(between_ns)
            self._publish(time_ns)
        self._last_ns = time_ns

    def _publish(self, time_ns: int) -> None:
        fill_time(self._message.clock, time_ns)
        self._publisher.publish(self._message, time_ns)


#: From this difference on, stamps of the two clocks no longer pass as the same time [ns].
TOLERANCE_NS = 500_000_000


class ClockHint:
    """
    Compares the clocks and names the remedy once they differ.

    :param clock: simulated time, which started at the wall clock's.
    :param warn: takes the text.
    """

    def __init__(self, clock: SimClock, warn: Callable[[str], object]) -> None:
        self._clock = clock
        self._warn = warn
        self._said = False

    def look(self) -> None:
        """Compare once."""
        if self._said:
            return
        behind = self._clock.behind_ns(time.time_ns())
        if abs(behind) > TOLERANCE_NS:
            self._said = True
            side = 'behind' if behind > 0 else 'ahead of'
            self._warn(
                f'simulated time is now {abs(behind) / 1e9:.1f} s {side} the wall clock; programs '
                'that take stamps from the wall clock no longer agree with it: start them '
                'with the parameter use_sim_time:=true'
            )
