# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A client's node: calls, goals and topics, with an executor in a thread of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import suppress
import threading
import traceback
from typing import Any

import rclpy
from rclpy.action import ActionClient
from rclpy.callback_groups import CallbackGroup
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.polling_node import OutsideExecutors

#: How long the thread may take to end on a machine that is busy [s].
_END = 10.0


class NotServedError(ArmsimError):
    """The requested interface is not served; the text names it."""

    def __init__(self, name: str) -> None:
        super().__init__(f'waiting for {name}')
        self.name = name


class RosClient:
    """
    A node that serves nothing, and the thread that runs it.

    Everything that touches an rclpy client happens in that thread: an answer that comes before
    the request is noted would be lost.

    :param name: of the node.
    :param ros_args: ``--ros-args`` sections.
    """

    def __init__(self, name: str, ros_args: Sequence[str] = ()) -> None:
        self._context = Context()
        rclpy.init(args=[name, *ros_args], context=self._context,
                   signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node(name, context=self._context, enable_rosout=False,
                         start_parameter_services=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._aside = OutsideExecutors()
        self._services: dict[tuple[type, str], Any] = {}
        self._actions: dict[tuple[type, str], ActionClient] = {}
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._spin, name='ros_client', daemon=True)
        self._thread.start()

    def prepare(self, kind: type[Any], name: str, *, action: bool = False) -> None:
        """Make a client now, so that its server has found it when it is needed."""
        self.in_thread(lambda: (self._action if action else self._service)(kind, name))

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
            client = self._service(kind, name)
            if not client.service_is_ready():
                raise NotServedError(name)
            sent = client.call_async(kind.Request() if request is None else request)
            sent.add_done_callback(lambda done: _settle(answer, done.result, done.exception))
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
            client = self._action(kind, name)
            if not client.server_is_ready():
                raise NotServedError(name)
            sent = client.send_goal_async(
                goal, (lambda message: feedback(message.feedback)) if feedback else None)
            sent.add_done_callback(run.answered)

        self._guarded(send, run.result)
        return run

    def subscribe(self, kind: type[Any], topic: str, profile: QoSProfile | int,
                  callback: Callable[[Any], None]) -> None:
        """Call a function, in the client's thread, with each message of a topic."""
        self.in_thread(lambda: self.node.create_subscription(kind, topic, callback, profile))

    def poll(self, kind: type[Any], topic: str, profile: QoSProfile | int) -> Polled:
        """Subscribe without waking the executor: the messages wait until they are taken."""
        return Polled(self, kind, topic, profile, self._aside)

    def in_thread(self, work: Callable[[], Any]) -> Future[Any]:
        """Do something in the client's thread."""
        done: Future[Any] = Future()
        self._guarded(lambda: done.set_result(work()), done)
        return done

    def close(self) -> None:
        """Leave the graph."""
        if not self._closing.is_set():
            self._closing.set()
            # Waking alone does not end 'spin_once'; work to do does.
            self._executor.create_task(lambda: None)
            # A thread that still waits when the interpreter ends would abort the process.
            self._thread.join(_END)
            self._executor.shutdown(0.0)
            self.node.destroy_node()
            self._context.try_shutdown()

    def __enter__(self) -> RosClient:
        """Return the client."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the graph."""
        self.close()

    def _guarded(self, work: Callable[[], None], answer: Future[Any]) -> None:
        def run() -> None:
            try:
                work()
            except Exception as error:  # noqa: BLE001 - belongs to its waiter
                if not answer.done():
                    answer.set_exception(error)

        self._executor.create_task(run)

    def _service(self, kind: type[Any], name: str) -> Any:
        if (kind, name) not in self._services:
            self._services[kind, name] = self.node.create_client(kind, name)
        return self._services[kind, name]

    def _action(self, kind: type[Any], name: str) -> ActionClient:
        if (kind, name) not in self._actions:
            self._actions[kind, name] = ActionClient(self.node, kind, name)
        return self._actions[kind, name]

    def _spin(self) -> None:
        while not self._closing.is_set():
            try:
                self._executor.spin_once()
            except ExternalShutdownException:
                return
            except Exception:  # noqa: BLE001 - no message may end the thread
                if not self._closing.is_set():
                    self.node.get_logger().error(traceback.format_exc())


class GoalRun:
    """
    A goal on its way.

    ``result`` becomes the action's wrapped result (``status``, ``result``), None where the goal
    was rejected.
    """

    def __init__(self, client: RosClient, name: str) -> None:
        self.name = name
        self.result: Future[Any] = Future()
        self._client = client
        self._handle: Any = None
        self._cancel_wanted = False

    def cancel(self) -> None:
        """Ask the server to end the goal; also before it has accepted it."""
        def ask() -> None:
            self._cancel_wanted = True
            if self._handle is not None:
                self._handle.cancel_goal_async()

        self._client.in_thread(ask)

    def answered(self, sent: Any) -> None:
        """Take the server's answer to the goal; in the client's thread."""
        if sent.exception() is not None:
            _settle(self.result, sent.result, sent.exception)
            return
        self._handle = sent.result()
        if not self._handle.accepted:
            _settle(self.result, lambda: None, lambda: None)
            return
        if self._cancel_wanted:
            self._handle.cancel_goal_async()
        self._handle.get_result_async().add_done_callback(
            lambda done: _settle(self.result, done.result, done.exception))


class Polled:
    """A subscription that does not wake the executor."""

    def __init__(self, client: RosClient, kind: type[Any], topic: str, profile: QoSProfile | int,
                 group: CallbackGroup) -> None:
        self._kind = kind
        self._client = client
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


def _settle(answer: Future[Any], result: Callable[[], Any],
            exception: Callable[[], BaseException | None]) -> None:
    """Pass an answer on, unless its waiter is gone."""
    if answer.done():
        return
    with suppress(Exception):
        error = exception()
        if error is not None:
            answer.set_exception(error)
        else:
            answer.set_result(result())
