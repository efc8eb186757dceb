# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What is remembered of each publisher of a topic."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Generic, TypeVar

from armsim_ros.nodes.bridge.topic_reader import Received

#: RMW_MESSAGE_INFO_SEQUENCE_NUMBER_UNSUPPORTED: the middleware does not number publications.
_NO_NUMBER = (1 << 64) - 1

T = TypeVar('T')


class Publications(Generic[T]):
    """The number of each publisher's newest message, and its latched message in any form."""

    def __init__(self) -> None:
        self._numbers: dict[bytes, int] = {}
        self._latched: dict[bytes, T] = {}
        self._absent: set[bytes] = set()

    def is_new(self, message: Received) -> bool:
        """Note a message; return whether it is not one that a new subscription gets again."""
        if message.number == _NO_NUMBER:
            return True
        is_new = message.number > self._numbers.get(message.publisher, 0)
        if is_new:
            self._numbers[message.publisher] = message.number
        return is_new

    def latch(self, message: Received, form: T) -> None:
        """Keep a message instead of the one before of the same publisher."""
        self._latched[message.publisher] = form

    def latched(self) -> Iterable[T]:
        """Return the latched message of each publisher."""
        return self._latched.values()

    def drop_latched(self) -> None:
        """Keep no message any more."""
        self._latched.clear()

    def forget_others(self, publishers: set[bytes]) -> None:
        """Forget publishers that are missing twice in a row: the graph may lag behind."""
        absent = (self._numbers.keys() | self._latched.keys()) - publishers
        for publisher in absent & self._absent:
            self._numbers.pop(publisher, None)
            self._latched.pop(publisher, None)
        self._absent = absent
