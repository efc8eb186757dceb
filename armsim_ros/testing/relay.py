# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Topics and services that fail on purpose on their way.

A relay is between a running stack and a node under test, which is started with the relayed
name in place of upstream's: ``--ros-args -r /clock:=/jumping_clock``.
"""

from __future__ import annotations

from collections.abc import Callable
import threading
from typing import Any

from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock as ClockMessage

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.nodes.conversions.time import ns_from_time, time_from_ns

SECOND_NS = 1_000_000_000


class TopicRelay:
    """
    Passes the messages of a topic on, but for some.

    :param client: the node to use.
    :param source: topic that the stack publishes, or the node under test.
    :param target: topic on which its messages appear.
    :param kind: message type.
    :param drops: gets the number of a message, from 0 on, and the message; True drops it.
    :param qos: profile of both ends.
    """

    def __init__(
        self, client: ClientNode, source: str, target: str, kind: type[Any], *,
        drops: Callable[[int, Any], bool] = lambda number, message: False,
        qos: QoSProfile | int = 10
    ) -> None:
        self.dropped = 0
        self.passed = 0
        self._drops = drops
        self._publisher = client.node.create_publisher(kind, target, qos)
        self._subscription = client.node.create_subscription(kind, source, self._pass, qos)

    def _pass(self, message: Any) -> None:
        if self._drops(self.dropped + self.passed, message):
            self.dropped += 1
            return
        self.passed += 1
        self._publisher.publish(self._changed(message))

    def _changed(self, message: Any) -> Any:
        return message


class ClockRelay(TopicRelay):
    """
    Passes ``/clock`` on, and makes it jump.

    :param client: the node to use.
    :param target: topic on which the clock appears.
    """

    def __init__(self, client: ClientNode, target: str = '/jumping_clock') -> None:
        self._offset_ns = 0
        super().__init__(client, '/clock', target, ClockMessage)

    def jump(self, seconds: float) -> None:
        """Let all times from now on be later, or earlier, by so much [s]."""
        self._offset_ns += round(seconds * SECOND_NS)

    def _changed(self, message: Any) -> Any:
        now_ns = ns_from_time(message.clock) + self._offset_ns
        return ClockMessage(clock=time_from_ns(max(0, now_ns)))


class ServiceRelay:
    """
    Passes the requests of a service on, in sequence, and withholds its answers back.

    It has a node of its own; to be closed, or used as a context.

    :param client: the node that calls the stack.
    :param source: service of the stack.
    :param target: service that the node under test calls.
    :param kind: service type.
    :param delay: wall time for which an answer is kept back [s].
    """

    def __init__(
        self, client: ClientNode, source: str, target: str, kind: type[Any], *, delay: float
    ) -> None:
        self.delay = delay
        self._client, self._source, self._kind = client, source, kind
        self._closing = threading.Event()
        client.connect({source: kind})
        self._front = ClientNode(client.context.get_domain_id(), 'late_services')
        self._front.node.create_service(kind, target, self._answer)
        self._front.settle()

    def close(self) -> None:
        """Take the late service away."""
        self._closing.set()
        self._front.close()

    def _answer(self, request: Any, _: Any) -> Any:
        response = self._client.call(self._source, self._kind, request)
        self._closing.wait(self.delay)
        return response

    def __enter__(self) -> ServiceRelay:
        """Return the relay."""
        return self

    def __exit__(self, *_: object) -> None:
        """Take the late service away."""
        self.close()
