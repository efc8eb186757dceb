# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The delays of transforms on their way from the publisher, as tf2_monitor prints them."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Collection, Iterable, Mapping

#: A message does not name its publisher.
_AUTHORITY = '<no authority available>'
#: So many newest values are kept of each frame.
_KEPT = 1000
#: The shortest time that a rate is computed over [s].
_SHORTEST_SPAN = 1e-8


class TransformDelays:
    """The delays of each frame and of all messages together."""

    def __init__(self) -> None:
        self._frames: Mapping[str, deque[float]] = defaultdict(lambda: deque(maxlen=_KEPT))
        self._messages: deque[float] = deque(maxlen=_KEPT)
        self._arrivals: deque[float] = deque(maxlen=_KEPT)

    def add(self, stamps: Iterable[tuple[str, float]], now: float) -> None:
        """
        Add a message.

        :param stamps: child frame and stamp [s] of each transform.
        :param now: when it arrived [s].
        """
        delays = []
        for frame, stamp in stamps:
            delays.append(now - stamp)
            self._frames[frame].append(now - stamp)
        self._messages.append(sum(delays) / max(1, len(delays)))
        self._arrivals.append(now)

    def frame_lines(self, chosen: Collection[str] | None) -> list[str]:
        """Return a line for each frame; for the chosen ones only, where they are given."""
        return [f'Frame: {frame}, published by {_AUTHORITY}, Average Delay: {_mean(delays):g}, '
                f'Max Delay: {max(0.0, *delays):g}'
                for frame, delays in sorted(self._frames.items())
                if chosen is None or frame in chosen]

    def broadcaster_lines(self) -> list[str]:
        """Return a line for each broadcaster: one for all, because messages do not name theirs."""
        if not self._messages:
            return []
        span = max(_SHORTEST_SPAN, self._arrivals[-1] - self._arrivals[0])
        return [f'Node: {_AUTHORITY} {len(self._arrivals) / span:g} Hz, Average Delay: '
                f'{_mean(self._messages):g} Max Delay: {max(0.0, *self._messages):g}']


def _mean(values: Collection[float]) -> float:
    return sum(values) / len(values)
