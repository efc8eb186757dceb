# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Events of controllers: log lines for their program."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Literal

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
        self._events.add(time_ns, 'warning', 'warning', text)
