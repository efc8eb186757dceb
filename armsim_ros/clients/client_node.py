# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A client for tests and scripts, whose calls wait with a time limit and assert their answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
import math
import threading
import time
from typing import Any, ClassVar

from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from armsim_ros.clients.node import GoalRun, SpinningNode
from armsim_ros.errors import SimulationError

LATCHED = QoSProfile(
    depth=10, reliability=QoSReliabilityPolicy.RELIABLE,
    durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)


PATIENCE = 30.0
"""Time [s] in which everything happens on a machine under load."""

FIND_BACK = 0.2
"""
Time [s] for a server to find a new client.

Fast DDS drops an answer where the server has not found its reader 0.1 s after the request, as
happens where the server does not get to run; the client cannot detect when it has.
"""


#: How services are named that only ask, which does no harm to do again, and after which time [s].
ASKING = ('check_', 'compute_', 'describe_', 'get_', 'list_', 'query_')
ASK_AGAIN = 5.0


class ClientNode(SpinningNode):
    """
    A client's node: calls services, collects topics, never blocks its own executor.

    :param domain: ROS domain id; that of the environment where None.
    :param name: node name.
    :param namespace: node namespace.
    """

    #: Names of all such nodes that this process ever had.
    names: ClassVar[set[str]] = set()

    def __init__(
        self, domain: int | None = None, name: str = 'client', namespace: str = '/'
    ) -> None:
        self.names.add(name)
        super().__init__(name, domain=domain, namespace=namespace)

    def call(
        self, service: str, kind: type[Any], request: Any = None, timeout: float = PATIENCE
    ) -> Any:
        """
        Call a service and return the response.

        What only asks is called again where no answer comes, see :data:`FIND_BACK`.

        :param kind: the service type.
        :param request: the request; None sends an empty request.
        :param timeout: [s] for the server to appear and answer.
        :raises AssertionError: no server or no answer in time.
        """
        deadline = time.monotonic() + timeout
        self.connect({service: kind}, timeout)
        client = self.service(kind, service)
        assert client.wait_for_service(timeout), f'no service {service} within {timeout} s'
        request = kind.Request() if request is None else request
        future = client.call_async(request)
        asks = service.rpartition('/')[-1].startswith(ASKING)
        while asks and time.monotonic() < deadline - ASK_AGAIN:
            if self._is_done(future, ASK_AGAIN):
                break
            future = client.call_async(request)
        return self.result(future, deadline - time.monotonic(), f'answer of {service}')

    def connect(self, services: Mapping[str, type], timeout: float = PATIENCE) -> None:
        """
        Make ready to call services, many at once if needed.

        :param services: name -> type.
        :param timeout: [s] for a server to appear.
        :raises AssertionError: no server in time.
        """
        new = [key for key in ((kind, name) for name, kind in services.items())
               if key not in self._services]
        for kind, name in new:
            self.service(kind, name)
        for kind, name in new:
            found = self.service(kind, name).wait_for_service(timeout)
            assert found, f'no service {name} within {timeout} s'
        if new:
            self.settle()

    def settle(self) -> None:
        """Let others find what this node has just made."""
        self._closing.wait(FIND_BACK)

    def goal(self, kind: type[Any], name: str, message: Any,
             feedback: Callable[[Any], None] | None = None, timeout: float = PATIENCE) -> GoalRun:
        """
        Send a goal to an action server.

        :param feedback: gets each feedback, in the executor's thread.
        :param timeout: [s] for the server to appear.
        :raises AssertionError: no server in time.
        """
        assert self.has_server(kind, name, timeout), f'no action server {name} in {timeout} s'
        run, action = GoalRun(self, name), self.action(kind, name)
        self.in_executor(lambda: run.send(action, message, feedback))
        return run

    def has_server(self, kind: type[Any], name: str, timeout: float = PATIENCE) -> bool:
        """
        Return whether an action has a server, which has found this client.

        :param timeout: [s] for the server to appear.
        """
        is_new = (kind, name) not in self._actions
        found = bool(self.action(kind, name).wait_for_server(timeout))
        if found and is_new:
            self.settle()
        return found

    def in_executor(self, work: Callable[[], Any], timeout: float = PATIENCE) -> Any:
        """
        Do something in the executor's thread and return what it returns.

        :param timeout: [s].
        """
        return self.result(self.in_thread(work), timeout, 'turn of the executor')

    def result(self, future: Any, timeout: float = PATIENCE, what: str = 'answer') -> Any:
        """
        Wait for a future of this node.

        :param timeout: [s].
        :raises AssertionError: it is not done in time.
        """
        assert self._is_done(future, timeout), f'no {what} within {timeout:.1f} s'
        return future.result()

    @staticmethod
    def _is_done(future: Any, timeout: float) -> bool:
        """Wait for a future of rclpy's or Python's; return whether it is done in time [s]."""
        done = threading.Event()
        future.add_done_callback(lambda _: done.set())
        return done.wait(max(timeout, 0.0))

    def collect(self, topic: str, kind: type[Any], qos: QoSProfile | int = 10) -> Collector:
        """Subscribe to a topic and keep what arrives."""
        return Collector(self, topic, kind, qos)

    def latched(self, topic: str, kind: type[Any], timeout: float = PATIENCE) -> Any:
        """Return the last value of a latched topic."""
        return self.collect(topic, kind, LATCHED).wait(1, timeout)[-1]


class Collector:
    """
    All messages of a topic, oldest first.

    They stay serialized until someone reads them, which spares most of the work where many come
    and few are read.

    :param client: the node that subscribes.
    :param topic: topic name.
    :param kind: message type.
    :param qos: profile of the subscription.
    """

    def __init__(
        self, client: ClientNode, topic: str, kind: type[Any], qos: QoSProfile | int
    ) -> None:
        self.topic = topic
        self._kind = kind
        #: The first so many are messages, the others serialized.
        self._read = 0
        self._messages: list[Any] = []
        self._condition = threading.Condition()
        self._client = client
        self._subscription = client.node.create_subscription(
            kind, topic, self._receive, qos, raw=True)

    @property
    def messages(self) -> list[Any]:
        """A copy of what has arrived."""
        with self._condition:
            return self._from(0)

    def clear(self) -> None:
        """Forget what has arrived."""
        with self._condition:
            self._messages.clear()
            self._read = 0

    def wait(self, count: int = 1, timeout: float = PATIENCE) -> list[Any]:
        """
        Return all messages as soon as there are ``count``.

        :param timeout: [s].
        :raises AssertionError: fewer came in time.
        """
        with self._condition:
            enough = self._condition.wait_for(lambda: len(self._messages) >= count, timeout)
            assert enough, (
                f'{len(self._messages)} of {count} messages on {self.topic} in {timeout} s')
            return self._from(0)

    def wait_after(self, act: Callable[[], Any], timeout: float = PATIENCE) -> Any:
        """
        Call a function that makes another node publish, and return the first message.

        It is called again while nothing arrives: the publisher may discover the subscription late.

        :param act: the function; it may be called several times.
        :param timeout: [s].
        :raises AssertionError: no message in time.
        """
        deadline = time.monotonic() + timeout
        while time.monotonic() < deadline:
            act()
            with self._condition:
                if self._condition.wait_for(lambda: self._messages, FIND_BACK):
                    break
        return self.wait(1, max(deadline - time.monotonic(), 0.0))[0]

    def wait_for(self, matches: Callable[[Any], bool], timeout: float = PATIENCE) -> Any:
        """
        Return the first message that matches, waiting for it.

        :param timeout: [s].
        :raises AssertionError: none came in time.
        """
        seen = 0
        deadline = time.monotonic() + timeout
        with self._condition:
            while True:
                for message in self._from(seen):
                    if matches(message):
                        return message
                seen = len(self._messages)
                left = deadline - time.monotonic()
                assert left > 0.0, (
                    f'none of {seen} messages on {self.topic} matched in {timeout} s')
                self._condition.wait(left)

    def close(self) -> None:
        """Unsubscribe; in the executor's thread, which may be about to read from it."""
        self._client.in_executor(
            lambda: self._client.node.destroy_subscription(self._subscription))

    def _from(self, begin: int) -> list[Any]:
        for index in range(self._read, len(self._messages)):
            self._messages[index] = deserialize_message(self._messages[index], self._kind)
            self._read = index + 1
        return self._messages[begin:]

    def _receive(self, serialized: bytes) -> None:
        with self._condition:
            self._messages.append(serialized)
            self._condition.notify_all()


#: Time in which the topics of a running arm have a message [s].
FIRST_MESSAGE = 9.0


class LatestMessage:
    """
    The last message of a topic.

    :param client: the node that subscribes.
    :param remedy: for an error where no message comes.
    """

    def __init__(self, client: ClientNode, kind: type[Any], topic: str, remedy: str) -> None:
        self._client, self._topic, self._remedy = client, topic, remedy
        self._message: Any = None
        self._is_new = False
        self._received = -math.inf
        self._dropped = ''
        self._condition = threading.Condition()
        self._subscription = client.node.create_subscription(kind, topic, self._receive, 1)

    def get(self, timeout: float = FIRST_MESSAGE) -> Any:
        """
        Return the last message, waiting for the first.

        :param timeout: [s].
        :raises SimulationError: none came in time.
        """
        return self._awaited(lambda: self._message is not None, timeout)

    def take(self, timeout: float = FIRST_MESSAGE) -> Any:
        """Return a message that was not taken before, waiting for it, as ``get`` does."""
        with self._condition:
            message = self._awaited(lambda: self._is_new, timeout)
            self._is_new = False
            return message

    @property
    def age(self) -> float:
        """How long ago the last message came [s]; infinite before the first."""
        return time.monotonic() - self._received

    def close(self) -> None:
        """Unsubscribe."""
        self._client.in_executor(
            lambda: self._client.node.destroy_subscription(self._subscription))

    def _receive(self, message: Any) -> None:
        with self._condition:
            self._message, self._is_new = message, True
            self._received = time.monotonic()
            self._condition.notify_all()

    def _awaited(self, condition: Callable[[], bool], timeout: float) -> Any:
        with self._condition:
            if not self._condition.wait_for(condition, timeout):
                raise SimulationError(
                    f"no message on '{self._topic}' within {timeout:g} s; "
                    + (self._dropped or self._remedy))
            return self._message


class JointStates(LatestMessage):
    """
    The last joint states of a topic.

    Messages with fewer positions than names, or more, are dropped with a warning, as
    robot_state_publisher does.

    :param client: the node that subscribes.
    :param remedy: for an error where no message comes.
    """

    def __init__(self, client: ClientNode, topic: str, remedy: str) -> None:
        super().__init__(client, JointState, topic, remedy)

    @property
    def positions(self) -> dict[str, float]:
        """Joint -> position [rad or m], of the last message."""
        message = self.get()
        return dict(zip(message.name, message.position, strict=True))

    def _receive(self, message: JointState) -> None:
        names, positions = len(message.name), len(message.position)
        if names == positions:
            super()._receive(message)
            return
        self._dropped = (f'a message with {names} names and {positions} positions was dropped; '
                         'its publisher must give each joint a position')
        self._client.node.get_logger().warning(f"'{self._topic}': {self._dropped}", once=True)
