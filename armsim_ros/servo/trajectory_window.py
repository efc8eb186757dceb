# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The newest streamed points as a trajectory for a controller."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.servo.stream import ServoStream, StreamState
from armsim_ros.trajectory import JointTrajectory

FEWEST = 3
"""With less points than these nothing is held back."""
_SLACK_NS = 20_000_000
"""So long may a message take to the controller [ns]."""
_REACH_NS = 3_000_000
"""
What is due sooner, a message comes too late to change [ns].

A longer transition deviates by what braking changes meanwhile, less than 0.1 mrad.
"""


@dataclass(frozen=True, slots=True, eq=False)
class WindowPoints:
    """
    The points of a window, as they are sent.

    :param stamp_ns: of the first point [ns].
    :param spans_ns: (k,) from the first point to each, integers [ns].
    :param positions: (k, m) [rad or m].
    :param velocities: (k, m) [rad/s or m/s].
    :param accelerations: (k, m) [rad/s^2 or m/s^2], if they were asked for.
    """

    stamp_ns: int
    spans_ns: NDArray[np.int64]
    positions: Matrix
    velocities: Matrix
    accelerations: Matrix | None


class TrajectoryWindow:
    """
    The points that a controller still has to follow: from just before now to the latency ahead.

    Upstream's servo sends as many of the past as well, which no controller reads.

    :param joint_names: (m,) of the stream.
    :param latency_ns: how far ahead points are stamped [ns].
    """

    def __init__(self, joint_names: tuple[str, ...], latency_ns: int) -> None:
        """Start empty."""
        self._joint_names, self._latency_ns = joint_names, latency_ns
        self._points: deque[tuple[int, StreamState]] = deque()

    def start(self, now_ns: int, state: StreamState) -> None:
        """Begin anew with a stream that rests at the controller's reference."""
        self._points = deque([(now_ns, state)])

    def replan(
        self, now_ns: int, cycle_ns: int, period_ns: int, stream: ServoStream,
        step: Callable[[], object],
    ) -> None:
        """
        Have another command followed at once, not only where the points that lie ahead end.

        The stream goes back to the first point that a message can still change, and on from
        there, up to the cycle that is to be added next.

        :param cycle_ns: time of that cycle [ns].
        :param step: advances the stream by a period.
        """
        points = self._points
        if points[-1][0] < now_ns + _REACH_NS:
            return
        while len(points) > 1 and points[-2][0] >= now_ns + _REACH_NS:
            points.pop()
        due, state = points[-1]
        stream.restore(state)
        while due + 2 * period_ns <= cycle_ns + self._latency_ns:
            step()
            due += period_ns
            points.append((due, stream.state))

    def go_back(self, now_ns: int, period_ns: int, stream: ServoStream) -> bool:
        """
        Forget what lies farther ahead than a point that is added now, as time was set back.

        The stream goes back to the newest point that stays; False where there is none.
        """
        points = self._points
        while points and points[-1][0] > now_ns + self._latency_ns - period_ns:
            points.pop()
        if points:
            stream.restore(points[-1][1])
        return bool(points)

    def add(self, now_ns: int, state: StreamState) -> None:
        """Add where the stream (m joints) is after this cycle; the past is forgotten."""
        due = now_ns + self._latency_ns
        while len(self._points) > 1 and self._points[-1][0] >= due:
            self._points.pop()
        self._points.append((due, state))
        # The last point before now stays: the controller is between it and the next.
        while len(self._points) > FEWEST and self._points[1][0] <= now_ns - _SLACK_NS:
            self._points.popleft()

    def points(self, *, accelerations: bool = False) -> WindowPoints | None:
        """
        Return all points but the newest, whose velocity is not known before the next point.

        The last velocity is 0, so that the arm comes to rest where nothing follows. The first
        command of a stream goes out at once, though: it leads to rest anyhow. None where there
        is no command yet.

        :param accelerations: whether to include them.
        """
        if len(self._points) < FEWEST:
            return self._first()
        stamps = np.array([stamp for stamp, _ in self._points], dtype=np.int64)
        spans = stamps - stamps[0]
        times = spans * 1e-9
        positions = np.array([state.sent for _, state in self._points])
        slopes = _slopes(times, positions)
        velocities = np.zeros((len(times) - 1, positions.shape[1]))
        before, after = slopes[:-1], slopes[1:]
        smaller = np.where(np.abs(before) < np.abs(after), before, after)
        velocities[1:-1] = np.where(before * after > 0.0, smaller, 0.0)[:-1]
        changes = None
        if accelerations:
            changes = np.zeros_like(velocities)
            changes[1:-1] = _slopes(times[:-1], velocities)[:-1]
        return WindowPoints(int(stamps[0]), spans[:-1], positions[:-1], velocities, changes)

    def trajectory(self) -> JointTrajectory | None:
        """Return the same as a trajectory for a controller, without accelerations."""
        found = self.points()
        if found is None:
            return None
        times = found.spans_ns.astype(np.float64) * 1e-9
        return JointTrajectory(
            self._joint_names, times, found.positions, found.velocities, stamp_ns=found.stamp_ns)

    def _first(self) -> WindowPoints | None:
        if len(self._points) < 2:
            return None
        (start, begin), (due, end) = self._points
        still = np.zeros((2, len(begin.sent)))
        return WindowPoints(
            start, np.array([0, due - start]), np.array([begin.sent, end.sent]), still, still)


def _slopes(times: Vector, values: Matrix) -> Matrix:
    """Return how fast values (k, m) change from each time (k,) to the next (k - 1, m)."""
    slopes: Matrix = (values[1:] - values[:-1]) / (times[1:] - times[:-1])[:, None]
    return slopes
