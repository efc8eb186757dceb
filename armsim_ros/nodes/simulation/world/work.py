# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Runs functions in the loop's thread or beside it while a request waits for them."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future as LoopFuture
from queue import SimpleQueue
import threading
from typing import Any, TypeVar

from rclpy.node import Node
from rclpy.task import Future

from armsim_ros.errors import SimulationError
from armsim_ros.nodes.simulation.dispatcher import Dispatcher, wake
from armsim_ros.sim.control_loop import ControlLoop

Result = TypeVar('Result')


class Work:
    """
    Runs functions elsewhere and resumes the coroutine that waits for them.

    Changes of the world are made in sequence in a thread of their own: to compile a
    world takes longer than a tick of the loop.

    :param node: its executor runs the coroutines.
    """

    def __init__(self, node: Node, loop: ControlLoop, dispatcher: Dispatcher) -> None:
        self.loop = loop
        self._node = node
        self._dispatcher = dispatcher
        self._changes: SimpleQueue[tuple[Callable[[], Any], LoopFuture[Any]]] = SimpleQueue()
        self._thread: threading.Thread | None = None

    async def in_loop(self, function: Callable[[], Result]) -> Result:
        """
        Return the result of a function that runs between two ticks.

        :raises SimulationError: the simulation ends.
        """
        return await self.finished(self.loop.call(function))

    async def beside(self, change: Callable[[], Result]) -> Result:
        """
        Return the result of a change of the world; changes are made in order of arrival.

        In it, ``wait_for_loop`` waits for what has to run between two ticks.

        :raises SimulationError: the simulation ends.
        """
        future: LoopFuture[Result] = LoopFuture()
        self._changes.put((change, future))
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name='world', daemon=True)
            self._thread.start()
        return await self.finished(future)

    def wait_for_loop(self, function: Callable[[], Result]) -> Result:
        """Return the result of a function that runs between two ticks; only within a change."""
        return _result(self.loop.call(function))

    async def finished(self, future: LoopFuture[Result]) -> Result:
        """
        Return the result of work in another thread.

        :raises SimulationError: the simulation ends.
        """
        done = Future()
        future.add_done_callback(lambda _: self._dispatcher.post(lambda: self._resume(done)))
        await done
        return _result(future)

    def _resume(self, done: Future) -> None:
        done.set_result(None)
        wake(self._node)

    def _run(self) -> None:
        while True:
            change, future = self._changes.get()
            try:
                future.set_result(change())
            except BaseException as error:  # noqa: BLE001 - it belongs to the caller
                future.set_exception(error)


def _result(future: LoopFuture[Result]) -> Result:
    try:
        return future.result()
    except BaseException as error:
        if future.cancelled():
            raise SimulationError('the simulation ends') from None
        raise error
