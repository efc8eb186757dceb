# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A client's node, the thread that runs it, and goals on their way to action servers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import suppress
import threading
import traceback
from typing import Any, TYPE_CHECKING

import rclpy
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from typing_extensions import Self

from armsim_ros.nodes.polling_node import destroy_actions
from armsim_ros.nodes.wait_set_executor import WaitSetExecutor

if TYPE_CHECKING:  # half of what a client without actions would import
    from rclpy.action import ActionClient

    from armsim_ros.clients.action_client import PatientActionClient

#: How long the thread may take to end on a machine that is busy [s].
_END = 10.0


class SpinningNode:
    """
    A node in a context of its own, whose executor runs in a thread of its own.

    :param name: of the node.
    :param ros_args: ``--ros-args`` sections.
    :param domain: ROS domain id; that of the environment where None.
    :param kind: class of the node.
    :param options: those of the class.
    """

    def __init__(
        self, name: str, ros_args: Sequence[str] = (), *, domain: int | None = None,
        kind: type[Node] = Node, **options: Any
    ) -> None:
        self.context = Context()
        rclpy.init(args=[name, *ros_args], context=self.context, domain_id=domain,
                   signal_handler_options=SignalHandlerOptions.NO)
        self.node = kind(name, context=self.context, **options)
        self._others: list[Node] = []
        self._executor = WaitSetExecutor(context=self.context)
        self._executor.add_node(self.node)
        self._services: dict[tuple[type, str], Any] = {}
        self._actions: dict[tuple[type, str], PatientActionClient] = {}
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._spin, name=name, daemon=True)
        self._thread.start()

    def add_node(self, node: Node) -> None:
        """Run another node of the same context, too; it leaves with this one."""
        self._others.append(node)
        self._executor.add_node(node)

    def service(self, kind: type[Any], name: str) -> Any:
        """Return rclpy's client of a service; it is made once."""
        if (kind, name) not in self._services:
            self._services[kind, name] = self.node.create_client(kind, name)
        return self._services[kind, name]

    def action(self, kind: type[Any], name: str, **profiles: Any) -> PatientActionClient:
        """
        Return rclpy's client of an action; it is made once.

        :param profiles: QoS profiles as ``ActionClient`` takes them.
        """
        from armsim_ros.clients.action_client import PatientActionClient

        if (kind, name) not in self._actions:
            self._actions[kind, name] = PatientActionClient(self.node, kind, name, **profiles)
        return self._actions[kind, name]

    def drop_action(self, kind: type[Any], name: str) -> None:
        """Destroy the client of an action; in the executor's thread."""
        self._actions.pop((kind, name)).destroy()

    def in_thread(self, work: Callable[[], Any]) -> Future[Any]:
        """Do something in the thread of the executor."""
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
            for node in (*self._others, self.node):
                destroy_node(node)
            self.context.try_shutdown()

    def __enter__(self) -> Self:
        """Return the client."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the graph."""
        self.close()

    def _guarded(self, work: Callable[[], None], answer: Future[Any]) -> None:
        """Do something in the thread; its failure is that of an answer."""
        def run() -> None:
            try:
                work()
            except Exception as error:  # noqa: BLE001 - belongs to its waiter
                if not answer.done():
                    answer.set_exception(error)

        self._executor.create_task(run)

    def _spin(self) -> None:
        while not self._closing.is_set():
            try:
                self._executor.spin_once()
            except InvalidHandle:  # what another thread has just destroyed
                continue
            except ExternalShutdownException:
                return
            except Exception:  # noqa: BLE001 - no message may end the thread
                if not self._closing.is_set():
                    self.node.get_logger().error(traceback.format_exc())


def destroy_node(node: Node) -> None:
    """Destroy a node and its actions."""
    destroy_actions(node)
    node.destroy_node()


class GoalRun:
    """
    A goal on its way.

    ``accepted`` becomes whether the server took it; ``result`` the action's wrapped result
    (``status``, ``result``), None where the goal was rejected.

    :param client: that sends it.
    :param name: of the action.
    """

    def __init__(self, client: SpinningNode, name: str) -> None:
        self.name = name
        self.accepted: Future[bool] = Future()
        self.result: Future[Any] = Future()
        self._client = client
        self._handle: Any = None
        self._cancels: list[Future[Any]] = []

    def send(self, action: ActionClient, goal: Any,
             feedback: Callable[[Any], None] | None = None) -> None:
        """
        Send the goal.

        :param feedback: gets each feedback, in the client's thread.
        """
        sent = action.send_goal_async(
            goal, (lambda message: feedback(message.feedback)) if feedback else None)
        sent.add_done_callback(self._answered)

    def fail(self, error: Exception) -> None:
        """Have those who wait get an error: the goal was not sent."""
        for future in (self.accepted, self.result):
            if not future.done():
                future.set_exception(error)

    def cancel(self) -> Future[Any]:
        """
        Ask the server to end the goal; also before it has accepted it.

        :returns: the server's response to be; None where it rejected the goal.
        """
        answer: Future[Any] = Future()

        def ask() -> None:
            if self._handle is None:
                self._cancels.append(answer)
            else:
                self._cancel(answer)

        self._client.in_thread(ask)
        return answer

    def _cancel(self, answer: Future[Any]) -> None:
        if self._handle.accepted:
            forward(self._handle.cancel_goal_async(), answer)
        elif not answer.done():
            answer.set_result(None)

    def _answered(self, sent: Any) -> None:
        """Take the server's answer to the goal; in the client's thread."""
        if sent.exception() is not None:
            self.fail(sent.exception())
            return
        self._handle = sent.result()
        if not self.accepted.done():
            self.accepted.set_result(bool(self._handle.accepted))
        for answer in self._cancels:
            self._cancel(answer)
        if self._handle.accepted:
            forward(self._handle.get_result_async(), self.result)
        elif not self.result.done():
            self.result.set_result(None)


def forward(source: Any, answer: Future[Any]) -> None:
    """Have a future of rclpy's settle another, unless the waiter of that is gone."""
    def settle(done: Any) -> None:
        with suppress(Exception):  # cancelled meanwhile
            if done.exception() is not None:
                answer.set_exception(done.exception())
            else:
                answer.set_result(done.result())

    source.add_done_callback(settle)
