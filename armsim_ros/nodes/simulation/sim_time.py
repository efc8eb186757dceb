# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulation's nodes and the time of their clocks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.parameter import Parameter
from rclpy.time_source import CLOCK_TOPIC
from rosgraph_msgs.msg import Clock

from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.guarded_node import GuardedNode

#: Steady time between updates of clocks that are not read [s]; rcl reads them, too.
IDLE_PERIOD = 1.0


class ToldNode(GuardedNode):
    """
    A node that gets the time of ``/clock`` from its own program, not from the topic.

    Its clock is set when it is read: to set a clock wakes the executor where the node has
    an action server, which at the rate of ``/clock`` would take most of a processor.

    :param name: of the node.
    :param now: returns the simulation's time [ns].
    :param options: those of ``rclpy.node.Node``.
    """

    def __init__(self, name: str, now: Callable[[], int], **options: Any) -> None:
        self._receive: Callable[[Clock], None] | None = None
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
            message = Clock()
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
        """
        Create a node.

        :param options: those of ``rclpy.node.Node``.
        """
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
