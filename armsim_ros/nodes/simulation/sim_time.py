# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulation's nodes, the time of their clocks, and ``/clock``."""

from __future__ import annotations

from collections.abc import Callable
import time
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.time_source import CLOCK_TOPIC
from rosgraph_msgs.msg import Clock as ClockMessage

from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.polling_node import GuardedNode
from armsim_ros.nodes.qos import WantedPublisher
from armsim_ros.sim.clock import SimClock

#: Steady time between updates of clocks that are not read [s]; rcl reads them, too.
IDLE_PERIOD = 1.0


class ToldNode(GuardedNode):
    """
    A node that gets the time of ``/clock`` from its own program, not from the topic.

    Its clock is set when it is read: to set a clock wakes the executor where the node has
    an action server, which at the rate of ``/clock`` would take most of a processor.

    :param now: returns the simulation's time [ns].
    """

    def __init__(self, name: str, now: Callable[[], int], **options: Any) -> None:
        self._receive: Callable[[ClockMessage], None] | None = None
        self._now = now
        self._told_ns = -1
        super().__init__(name, **options)

    def get_clock(self) -> Any:
        """Return the clock, set to the current time."""
        self.update()
        return super().get_clock()

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Any, qos_profile: Any, **options: Any
    ) -> Any:
        """Subscribe; for ``/clock``, which the time source wants, only keep the callback."""
        if topic == CLOCK_TOPIC:
            self._receive = callback
            return None
        return super().create_subscription(msg_type, topic, callback, qos_profile, **options)

    def update(self) -> None:
        """Set the node's clock if it uses sim time."""
        now_ns = self._now()
        if self._receive is not None and now_ns != self._told_ns:
            self._told_ns = now_ns
            message = ClockMessage()
            fill_time(message.clock, now_ns)
            self._receive(message)


class SimTime:
    """
    Creates the program's nodes and sets their clocks.

    :param used: the nodes' parameter ``use_sim_time`` at first.
    """

    def __init__(self, *, used: bool) -> None:
        self._used = used
        #: Returns the simulation's time [ns].
        self.now: Callable[[], int] = lambda: 0
        #: As a dictionary, which threads may change while another copies it.
        self._nodes: dict[ToldNode, None] = {}

    def node(self, name: str, **options: Any) -> ToldNode:
        """Create a node."""
        parameter = Parameter('use_sim_time', value=self._used)
        node = ToldNode(name, lambda: self.now(), parameter_overrides=[parameter], **options)
        self._nodes[node] = None
        return node

    def forget(self, node: ToldNode) -> None:
        """Stop setting a node's clock."""
        self._nodes.pop(node, None)

    def update(self) -> None:
        """Set all clocks."""
        for node in list(self._nodes):
            node.update()


class Clock:
    """
    Publishes the simulation's time.

    :param period_ns: where it is given, every multiple of it that time has passed since the last
        message has its own [ns].
    """

    def __init__(self, node: Node, period_ns: int = 0) -> None:
        self._publisher = WantedPublisher(node, ClockMessage, '/clock', qos.CLOCK)
        self._message = ClockMessage()
        self._period_ns = period_ns
        self._last_ns = 0

    def publish(self, time_ns: int) -> None:
        """Publish a time, if it has subscribers."""
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
        self._clock, self._warn = clock, warn
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
                'with the parameter use_sim_time:=true')
