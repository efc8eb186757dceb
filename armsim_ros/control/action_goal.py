# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Goals of actions and how they end.

A goal is made in the thread that sends it and ended in the control loop's thread. Its status is
read from any thread. Callbacks run in the thread that ends the goal: they must only hand over.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
import threading
from typing import Generic, TypeVar


class GoalStatus(IntEnum):
    """Life of a goal, with the values of ``action_msgs/msg/GoalStatus``."""

    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6


ResultT = TypeVar('ResultT')


class ActionGoal(Generic[ResultT]):
    """A goal of an action; it ends exactly once."""

    def __init__(self) -> None:
        self.status = GoalStatus.ACCEPTED
        self.result: ResultT | None = None
        self.cancel_requested = False
        self._lock = threading.Lock()
        self._callbacks: list[Callable[[ActionGoal[ResultT]], None]] = []

    @property
    def done(self) -> bool:
        """Whether the goal has ended; its result is there then."""
        return self.status >= GoalStatus.SUCCEEDED

    def add_done_callback(self, callback: Callable[[ActionGoal[ResultT]], None]) -> None:
        """Call back once when the goal ends; at once where it has ended already."""
        with self._lock:
            if not self.done:
                self._callbacks.append(callback)
                return
        callback(self)

    def execute(self) -> None:
        """Note that the control loop has taken the goal up."""
        with self._lock:
            if self.status is GoalStatus.ACCEPTED:
                self.status = GoalStatus.EXECUTING

    def request_cancel(self) -> bool:
        """Note that a client wants to cancel; False where the goal has ended."""
        with self._lock:
            if self.done:
                return False
            self.cancel_requested = True
            self.status = GoalStatus.CANCELING
            return True

    def finish(self, status: GoalStatus, result: ResultT) -> bool:
        """End the goal; False, and no change, where it has ended before."""
        with self._lock:
            if self.done:
                return False
            self.result = result
            self.status = status
            callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            callback(self)
        return True
