# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Finds out whether another machine's simulation already lives under the same names."""

from __future__ import annotations

from collections.abc import Callable
import time

from rclpy.node import Node

#: How long another simulation is searched after the start [s]; discovery takes a few tenths.
WATCH_TIME = 2.0


class DomainWatch:
    """
    Looks for a second controller manager of our name in the ROS graph.

    On one machine a lock keeps the second away; this finds those of other machines. Only the
    latest searches: an older one no longer does. Two that start at the same time
    both find the other and both give up.

    :param node: our manager's node.
    :param found: called once with the message for the user.
    """

    def __init__(self, node: Node, found: Callable[[str], None]) -> None:
        self._node = node
        self._found = found
        self._end = time.monotonic() + WATCH_TIME

    def look(self) -> None:
        """Check once; does nothing after the watch time."""
        if time.monotonic() > self._end:
            return
        own = (self._node.get_name(), self._node.get_namespace())
        if self._node.get_node_names_and_namespaces().count(own) > 1:
            self._end = 0.0
            name = self._node.get_fully_qualified_name()
            self._found(
                f'another simulation already runs as {name} on this ROS domain; every topic '
                'would be doubled. Stop it, or set another ROS_DOMAIN_ID, or start this '
                'simulation with namespace:=NAME'
            )
