# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A tick that the executor's coroutines wait for."""

from __future__ import annotations

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.task import Future

PERIOD = 0.02


class Ticker:
    """
    Wakes waiting coroutines every 20 ms of real time, and on request.

    The timer is stopped while nothing waits.

    :param node: its executor runs the timer.
    """

    def __init__(self, node: Node) -> None:
        self._waiting: list[Future] = []
        self._timer = node.create_timer(
            PERIOD,
            self._pulse,
            callback_group=ReentrantCallbackGroup(),
            clock=Clock(clock_type=ClockType.STEADY_TIME),
        )
        self._timer.cancel()

    def next(self) -> Future:
        """Return a future that is done at the next tick."""
        future = Future()
        self._waiting.append(future)
        if self._timer.is_canceled():
            self._timer.reset()
        return future

    def wake(self) -> None:
        """Tick now; call it from the executor's thread."""
        waiting, self._waiting = self._waiting, []
        for future in waiting:
            future.set_result(None)

    def _pulse(self) -> None:
        if self._waiting:
            self.wake()
        else:
            self._timer.cancel()
