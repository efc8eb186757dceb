# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Warnings about a stream of messages: logged once, and again after a while."""

from __future__ import annotations

from armsim_ros.control.events import EventQueue

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
