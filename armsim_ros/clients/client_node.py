# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A node in a context of its own whose executor runs beside the test."""

from __future__ import annotations

from collections.abc import Callable, Mapping
import threading
import time
from types import TracebackType
from typing import Any, ClassVar

import rclpy
from rclpy.action import ActionClient, ActionServer
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future


class PatientActionClient(ActionClient):
    """
    rclpy's action client, which notes a request before it reads the answer.

    rclpy 7.1 drops an answer that its executor takes before the sending thread has noted the
    request (later versions hold a lock).
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        self._sending = threading.RLock()
        super().__init__(*args, **options)  # type: ignore[no-untyped-call] # rclpy's

    def send_goal_async(self, *args: Any, **options: Any) -> Any:
        """Send a goal."""
        with self._sending:
            return super().send_goal_async(*args, **options)  # type: ignore[no-untyped-call] # rclpy's

    def _cancel_goal_async(self, goal_handle: Any) -> Any:
        with self._sending:
            return super()._cancel_goal_async(goal_handle)  # type: ignore[no-untyped-call] # rclpy's

    def _get_result_async(self, goal_handle: Any) -> Any:
        with self._sending:
            return super()._get_result_async(goal_handle)  # type: ignore[no-untyped-call] # rclpy's

    async def execute(self, taken_data: Any) -> None:
        """Take answers once no request is about to be recorded."""
        with self._sending:
            pass
        await super().execute(taken_data)  # type: ignore[no-untyped-call] # rclpy's


LATCHED = QoSProfile(
    depth=10,
    reliability=QoSReliabilityPolicy.RELIABLE,
    durability=QoSDurabilityPolicy.TRANSIENT_LOCAL,
)


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


class ClientNode:
    """
    A client's node: calls services, collects topics, never blocks its own executor.

    :param domain: ROS domain id.
    :param name: node name.
    :param namespace: node namespace.
    """

    #: Names of all such nodes that this process ever had.
    names: ClassVar[set[str]] = set()

    def __init__(self, domain: int, name: str = 'client', namespace: str = '/') -> None:
        self.names.add(name)
        self.context = Context()
        rclpy.init(
            args=[],
            context=self.context,
            domain_id=domain,
            signal_handler_options=SignalHandlerOptions.NO,
        )
        self.node = Node(name, namespace=namespace, context=self.context)
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.node)
        self._clients: dict[tuple[type, str], Any] = {}
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._spin, name=name, daemon=True)
        self._thread.start()

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
        client = self._clients[kind, service]
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
               if key not in self._clients]
        for kind, name in new:
            self._clients[kind, name] = self.node.create_client(kind, name)
        for key in new:
            found = self._clients[key].wait_for_service(timeout)
            assert found, f'no service {key[1]} within {timeout} s'
        if new:
            self.settle()

    def settle(self) -> None:
        """Let others find what this node has just made."""
        self._closing.wait(FIND_BACK)

    def result(self, future: Future, timeout: float = PATIENCE, what: str = 'answer') -> Any:
        """
        Wait for a future of this node.

        :param timeout: [s].
        :raises AssertionError: it is not done in time.
        """
        assert self._is_done(future, timeout), f'no {what} within {timeout:.1f} s'
        return future.result()

    @staticmethod
    def _is_done(future: Future, timeout: float) -> bool:
        """Wait for a future; return whether it is done in time [s]."""
        done = threading.Event()
        future.add_done_callback(lambda _: done.set())
        return done.wait(max(timeout, 0.0))

    def in_executor(self, work: Callable[[], Any], timeout: float = PATIENCE) -> Any:
        """
        Do something in the executor's thread and return what it returns.

        rclpy's action client must be used there: an answer that arrives before the sending
        thread has noted its request is dropped.

        :param timeout: [s].
        """
        return self.result(self._executor.create_task(work), timeout, 'turn of the executor')

    def collect(self, topic: str, kind: type[Any], qos: QoSProfile | int = 10) -> Collector:
        """Subscribe to a topic and keep what arrives."""
        return Collector(self, topic, kind, qos)

    def latched(self, topic: str, kind: type[Any], timeout: float = PATIENCE) -> Any:
        """Return the last value of a latched topic."""
        return self.collect(topic, kind, LATCHED).wait(1, timeout)[-1]

    def close(self) -> None:
        """Leave the domain."""
        if not self._closing.is_set():
            self._closing.set()
            self._executor.create_task(lambda: None)  # ends the wait
            self._thread.join(5.0)
            self._executor.shutdown(0.0)
            # destroy_node() leaves actions, whose handles keep the participant in the domain
            for each in [*self.node.waitables]:
                if isinstance(each, ActionClient | ActionServer):
                    each.destroy()
            self.node.destroy_node()
            self.context.try_shutdown()

    def _spin(self) -> None:
        while not self._closing.is_set():
            try:
                self._executor.spin_once()
            except InvalidHandle:  # what another thread has just destroyed
                continue
            except ExternalShutdownException:
                return

    def __enter__(self) -> ClientNode:
        """Return the node."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Leave the domain."""
        self.close()


class Collector:
    """
    All messages of a topic, oldest first.

    :param client: the node that subscribes.
    :param topic: topic name.
    :param kind: message type.
    :param qos: profile of the subscription.
    """

    def __init__(
        self, client: ClientNode, topic: str, kind: type[Any], qos: QoSProfile | int
    ) -> None:
        self.topic = topic
        self._messages: list[Any] = []
        self._condition = threading.Condition()
        self._client = client
        self._subscription = client.node.create_subscription(kind, topic, self._receive, qos)

    @property
    def messages(self) -> list[Any]:
        """A copy of what has arrived."""
        with self._condition:
            return list(self._messages)

    def clear(self) -> None:
        """Forget what has arrived."""
        with self._condition:
            self._messages.clear()

    def wait(self, count: int = 1, timeout: float = PATIENCE) -> list[Any]:
        """
        Return all messages as soon as there are ``count``.

        :param timeout: [s].
        :raises AssertionError: fewer came in time.
        """
        with self._condition:
            enough = self._condition.wait_for(lambda: len(self._messages) >= count, timeout)
            assert enough, (
                f'{len(self._messages)} of {count} messages on {self.topic} in {timeout} s'
            )
            return list(self._messages)

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
                for message in self._messages[seen:]:
                    if matches(message):
                        return message
                seen = len(self._messages)
                left = deadline - time.monotonic()
                assert left > 0.0, (
                    f'none of {seen} messages on {self.topic} matched in {timeout} s'
                )
                self._condition.wait(left)

    def close(self) -> None:
        """Unsubscribe; in the executor's thread, which may be about to read from it."""
        self._client.in_executor(
            lambda: self._client.node.destroy_subscription(self._subscription)
        )

    def _receive(self, message: Any) -> None:
        with self._condition:
            self._messages.append(message)
            self._condition.notify_all()
