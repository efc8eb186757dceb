# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Requests of other threads to the control loop, and the goals and events that it sends back."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
import threading
from typing import Generic, Literal, TypeVar

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


Level = Literal['info', 'warning', 'error']
Kind = Literal[
    'goal_rejected', 'trajectory_rejected', 'goal_aborted', 'tolerance', 'stop', 'warning',
    'state', 'failure',
]

CAPACITY = 1000
"""So many events are kept for a reader; then the oldest are dropped."""


@dataclass(frozen=True, slots=True)
class ControllerEvent:
    """
    Something that a user should know.

    :param time_ns: when it happened [ns].
    :param source: name of the controller, or of the manager.
    :param kind: what a program may sort by.
    :param text: a sentence.
    """

    time_ns: int
    level: Level
    source: str
    kind: Kind
    text: str


class EventQueue:
    """Events of a source; any thread adds, any thread drains, without waiting."""

    def __init__(self, source: str) -> None:
        self.source = source
        self._events: deque[ControllerEvent] = deque(maxlen=CAPACITY)

    def add(self, time_ns: int, level: Level, kind: Kind, text: str) -> None:
        """Queue an event."""
        self._events.append(ControllerEvent(time_ns, level, self.source, kind, text))

    def warn(self, time_ns: int, text: str) -> None:
        """Queue a warning about what goes on all the same."""
        self.add(time_ns, 'warning', 'warning', text)

    def drain(self) -> list[ControllerEvent]:
        """Return all events that were not taken yet, oldest first."""
        taken: list[ControllerEvent] = []
        while True:
            try:
                taken.append(self._events.popleft())
            except IndexError:
                return taken


_PAUSE_NS = 5_000_000_000


class RepeatedWarning:
    """
    Adds a warning unless it was added less than five seconds before.

    :param events: takes the warnings.
    """

    def __init__(self, events: EventQueue) -> None:
        self._events = events
        self._said: dict[str, int] = {}

    def add(self, time_ns: int, text: str, subject: str = '') -> None:
        """
        Add it, if it is new or long ago.

        :param time_ns: simulated time [ns].
        :param subject: warnings with the same are the same, whatever their texts; '' is the text.
        """
        last = self._said.get(subject or text)
        if last is not None and 0 <= time_ns - last < _PAUSE_NS:
            return
        if len(self._said) > 20:
            self._said.clear()
        self._said[subject or text] = time_ns
        self._events.warn(time_ns, text)
