# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The time of commands and trajectories, without a message for every read."""

from __future__ import annotations

import time

from armsim_ros.nodes.polling_node import PollingNode

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
