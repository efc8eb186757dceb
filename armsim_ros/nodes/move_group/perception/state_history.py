# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where the robot was at a time."""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Mapping

#: States that are kept: several seconds of usual joint states.
_KEPT = 2000


class StateHistory:
    """The joint positions of the last seconds, interpolated."""

    def __init__(self) -> None:
        self._stamps: deque[int] = deque(maxlen=_KEPT)
        self._states: deque[dict[str, float]] = deque(maxlen=_KEPT)

    @property
    def newest_ns(self) -> int:
        """Time of the last state [ns]; 0 where there is none."""
        return self._stamps[-1] if self._stamps else 0

    def record(self, stamp_ns: int, positions: Mapping[str, float]) -> None:
        """Keep a state; where time has jumped back, what is later is forgotten."""
        while self._stamps and self._stamps[-1] > stamp_ns:
            self._stamps.pop()
            self._states.pop()
        if self._stamps and self._stamps[-1] == stamp_ns:
            self._states[-1] = dict(positions)
        else:
            self._stamps.append(stamp_ns)
            self._states.append(dict(positions))

    def at(self, stamp_ns: int) -> dict[str, float] | None:
        """
        Return the positions [rad or m] at a time, None where it is later than the last state.

        :param stamp_ns: [ns]; 0 is the time of the last state.
        :raises ValueError: it is before the first state that is kept.
        """
        if not self._stamps or stamp_ns > self._stamps[-1]:
            return None
        if stamp_ns == 0:
            return self._states[-1]
        if stamp_ns < self._stamps[0]:
            raise ValueError(
                f'it is {(self._stamps[0] - stamp_ns) / 1e9:.2f} s older than the oldest robot '
                'state that is kept')
        after = bisect_left(self._stamps, stamp_ns)
        late = self._states[after]
        if self._stamps[after] == stamp_ns:
            return late
        begin, end = self._stamps[after - 1], self._stamps[after]
        share = (stamp_ns - begin) / (end - begin)
        early = self._states[after - 1]
        return {name: value + share * (late[name] - value)
                for name, value in early.items() if name in late}
