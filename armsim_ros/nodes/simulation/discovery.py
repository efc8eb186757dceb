# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Discovery of clients and of other simulations, without blocking.

A request can arrive before its client's reply reader has been discovered. The middleware then
waits up to 100 ms inside the call that sends the answer (rmw_fastrtps, ``rmw_response.cpp``),
and rclpy keeps the interpreter's lock meanwhile, which would stop the control loop.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
import time

from rclpy.node import Node
from rclpy.task import Future

from armsim_ros.nodes.simulation.dispatcher import Dispatcher, wake

#: How often discovery is checked [s], and how many times at most.
_PERIOD, _TRIES = 0.005, 100


class ClientDiscovery:
    """Compares a service's discovered request writers and reply readers."""

    def __init__(self, node: Node, dispatcher: Dispatcher, service: str) -> None:
        self._node = node
        self._dispatcher = dispatcher
        self._service = node.resolve_service_name(service)
        self._request_topic = f'rq{self._service}Request'
        self._tolerated = 0

    async def completed(self) -> None:
        """Return when every client that can ask can be answered too, or after half a second."""
        for _ in range(_TRIES):
            if self._unanswerable() <= self._tolerated:
                return
            later = Future()
            self._dispatcher.post_later(_PERIOD, partial(self._resume, later))
            await later
        # Something that only writes requests, such as a recorder's player: not to be waited for.
        self._tolerated = self._unanswerable()

    def _unanswerable(self) -> int:
        asking = self._node.get_publishers_info_by_topic(self._request_topic, no_mangle=True)
        missing = len(asking) - self._node.count_clients(self._service)
        self._tolerated = min(self._tolerated, max(missing, 0))
        return missing

    def _resume(self, later: Future) -> None:
        later.set_result(None)
        wake(self._node)


#: How long another simulation is searched after the start [s]; discovery takes a few tenths.
WATCH_TIME = 2.0


class DomainWatch:
    """
    Searches for a second controller manager of our name in the ROS graph.

    On one machine a lock keeps the second away; this finds those of other machines. Only the
    latest searches: an older one no longer does. Two that start at the same time
    both find the other and both give up.

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
                f'another simulation already runs as {name} on this ROS domain, and both '
                'publish the same topics. Stop it, or set another ROS_DOMAIN_ID, or start this '
                'simulation with namespace:=NAME'
            )
