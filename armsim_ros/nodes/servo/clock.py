# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The time of commands and trajectories, without a message for every look at it."""

from __future__ import annotations

import time

from armsim_ros.nodes.polling_node import PollingNode

_SAME_NS = 60_000_000
"""Clocks that are no farther apart are one clock [ns]; /clock itself is a step behind."""


class StreamClock:
    """
    The node's time.

    A simulation that runs in real time keeps the wall clock's time; then the wall clock is
    read, which is finer than /clock. Otherwise, as in a pause, /clock is.

    :param node: follows /clock if it is to.
    """

    def __init__(self, node: PollingNode) -> None:
        self._node = node
        self._simulated = bool(node.get_parameter('use_sim_time').value)
        #: Whether simulated time and the wall clock have parted.
        self.parted = False

    def look(self) -> None:
        """Compare the clocks; the node has just caught up with /clock."""
        if self._simulated:
            simulated = self._node.get_clock().now().nanoseconds
            self.parted = abs(simulated - time.time_ns()) > _SAME_NS

    def now_ns(self) -> int:
        """Return the time [ns]."""
        if self.parted:
            return int(self._node.get_clock().now().nanoseconds)
        return time.time_ns()
