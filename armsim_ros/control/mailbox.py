# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What other threads ask of the control loop."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
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
