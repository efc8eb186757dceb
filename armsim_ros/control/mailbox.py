# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What other threads hand to the control loop: requests, and goals that it ends."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from enum import IntEnum
import threading
from typing import Generic, TypeVar

RequestT = TypeVar('RequestT')

#: How much of a stream waits at most while time is paused.
STREAM_CAPACITY = 100


class Mailbox(Generic[RequestT]):
    """
    Requests in the order in which they came; any thread leaves some, any thread takes some.

    No thread waits, and no request is taken twice.

    :param wake: called after each post, so that a loop that sleeps takes it up.
    :param capacity: how many wait at most; more push out the oldest. None: all of them.
    """

    __slots__ = ('_requests', '_wake')

    def __init__(self, wake: Callable[[], object], capacity: int | None = None) -> None:
        self._requests: deque[RequestT] = deque(maxlen=capacity)
        self._wake = wake

    def __bool__(self) -> bool:
        """Return whether there is a request."""
        return bool(self._requests)

    def post(self, request: RequestT) -> None:
        """Leave a request."""
        self._requests.append(request)
        self._wake()

    def take(self, limit: int) -> list[RequestT]:
        """Return the oldest requests and forget them; others may take some meanwhile."""
        taken: list[RequestT] = []
        try:
            while len(taken) < limit:
                taken.append(self._requests.popleft())
        except IndexError:
            pass
        return taken

    def take_all(self) -> list[RequestT]:
        """Return all requests and forget them."""
        return self.take(len(self._requests) + 1) if self._requests else []


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
