# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A client for programs: calls that return futures, and topics that are read on demand."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import suppress
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.qos import QoSProfile

from armsim_ros.clients.node import forward, GoalRun, SpinningNode
from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.polling_node import OutsideExecutors
from armsim_ros.nodes.shutdown import bounded_shutdown


class NotServedError(ArmsimError):
    """The requested interface is not served; the text names it."""

    def __init__(self, name: str) -> None:
        super().__init__(f'waiting for {name}')
        self.name = name


class RosClient(SpinningNode):
    """
    A node that serves nothing, and the thread that runs it.

    Clients of services and actions are made and used in that thread.

    :param name: of the node.
    :param ros_args: ``--ros-args`` sections.
    :param options: of the node, see :class:`SpinningNode`.
    """

    def __init__(self, name: str, ros_args: Sequence[str] = (), **options: Any) -> None:
        super().__init__(name, ros_args, **{
            'enable_rosout': False, 'start_parameter_services': False, **options})
        self._aside = OutsideExecutors()

    def close(self) -> None:
        """Leave the graph; a process that the middleware blocks then ends with status 1."""
        with bounded_shutdown():
            super().close()

    def prepare(self, kind: type[Any], name: str, *, action: bool = False) -> None:
        """Make a client now, so that its server has found it when it is needed."""
        self.in_thread(lambda: (self.action if action else self.service)(kind, name))

    def serves(self, kind: type[Any], name: str, *, action: bool = False) -> bool:
        """Return whether a server of a prepared client is in the graph."""
        if action:
            client = self._actions.get((kind, name))
            return client is not None and client.server_is_ready()
        service = self._services.get((kind, name))
        return service is not None and service.service_is_ready()

    def call(self, kind: type[Any], name: str, request: Any = None) -> Future[Any]:
        """
        Call a service.

        :param kind: the service type.
        :param request: None sends an empty request.
        :returns: the response to be; NotServedError where there is no server.
        """
        answer: Future[Any] = Future()

        def send() -> None:
            client = self.service(kind, name)
            if not client.service_is_ready():
                raise NotServedError(name)
            sent = client.call_async(kind.Request() if request is None else request)
            forward(sent, answer)
            answer.add_done_callback(
                lambda _: answer.cancelled() and client.remove_pending_request(sent))

        self._guarded(send, answer)
        return answer

    def goal(self, kind: type[Any], name: str, goal: Any,
             feedback: Callable[[Any], None] | None = None) -> GoalRun:
        """
        Send a goal to an action server.

        :param feedback: gets each feedback, in the client's thread.
        """
        run = GoalRun(self, name)

        def send() -> None:
            client = self.action(kind, name)
            if client.server_is_ready():
                run.send(client, goal, feedback)
            else:
                run.fail(NotServedError(name))

        self._guarded(send, run.result)
        return run

    def subscribe(self, kind: type[Any], topic: str, profile: QoSProfile | int,
                  callback: Callable[[Any], None]) -> None:
        """Call a function, in the client's thread, with each message of a topic."""
        self.in_thread(lambda: self.node.create_subscription(kind, topic, callback, profile))

    def poll(self, kind: type[Any], topic: str, profile: QoSProfile | int) -> Polled:
        """Subscribe without waking the executor: the messages wait until they are taken."""
        return Polled(self, kind, topic, profile, self._aside)


class Polled:
    """A subscription that does not wake the executor."""

    def __init__(self, client: RosClient, kind: type[Any], topic: str, profile: QoSProfile | int,
                 group: CallbackGroup) -> None:
        self._kind, self._client = kind, client
        self._subscription = client.in_thread(lambda: client.node.create_subscription(
            kind, topic, lambda _: None, profile, callback_group=group)).result(5.0)

    def take(self, most: int = 100) -> list[Any]:
        """Return what has come since the last call, oldest first."""
        taken: list[Any] = []
        with suppress(InvalidHandle), self._subscription.handle:
            while len(taken) < most:
                pair = self._subscription.handle.take_message(self._kind, False)
                if pair is None:
                    break
                taken.append(pair[0])
        return taken

    def close(self) -> None:
        """Unsubscribe."""
        self._client.in_thread(lambda: self._client.node.destroy_subscription(self._subscription))
