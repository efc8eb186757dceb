# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Two motions that flow into each other instead of stopping between them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import PlanningError
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.quintic import QuinticMotion

Vector = NDArray[np.float64]
Place = Callable[[Vector], Vector]
"""Joint values (n,) -> where the tool is (3,) [m]."""

_LOOK = 0.01
"""Time [s] between two looks at the distance from the meeting point."""
_HALVINGS = 30
_POINTS = 8
_TIME_RESOLUTION = 1e-6


def appended(first: QuinticMotion, second: QuinticMotion) -> QuinticMotion:
    """Return the first motion, a stop, and the second."""
    return _joined(first, _part(second, 1, len(second.times)), first.duration)


def blended(
    first: QuinticMotion, second: QuinticMotion, place: Place, radius: float, step: float,
    since: float = 0.0,
) -> tuple[QuinticMotion, float]:
    """
    Return two motions as one that does not stop between them, and when the blend ends [s].

    Inside a sphere about the point where they meet, the weight of the second motion grows from 0
    to 1 by a polynomial without a step in its first two derivatives. Both motions keep their pace;
    the one with the shorter way through the sphere waits: the second at its start, the first at
    its end.

    :param radius: of the sphere [m].
    :param step: largest time between two points of the blend [s].
    :param since: time [s] of the first motion before which it must not be changed.
    :raises PlanningError: FAILURE where one of them never leaves the sphere.
    """
    meeting = place(first.positions[-1])

    def outside(motion: QuinticMotion, time: float) -> bool:
        at = place(motion.sample(np.array([time]))[0])
        return float(np.linalg.norm(at - meeting)) >= radius

    enters = first.duration - _first_time(
        lambda time: outside(first, first.duration - time), first.duration - since,
        'first', radius,
    )
    leaves = _first_time(lambda time: outside(second, time), second.duration, 'second', radius)
    window = max(first.duration - enters, leaves)
    late = window - leaves
    count = max(int(np.ceil(window / step)), _POINTS)
    times = np.linspace(0.0, window, count + 1)
    x = times / window
    weight = (x**3 * (10.0 - 15.0 * x + 6.0 * x**2))[:, None]
    growth = (30.0 * x**2 * (1.0 - x) ** 2 / window)[:, None]
    bend = (60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / window**2)[:, None]
    q1, v1, a1 = first.states(enters + times)
    q2, v2, a2 = second.states(times - late)
    blend = QuinticMotion(
        times,
        q1 + weight * (q2 - q1),
        v1 + growth * (q2 - q1) + weight * (v2 - v1),
        a1 + bend * (q2 - q1) + 2.0 * growth * (v2 - v1) + weight * (a2 - a1),
    )
    before = _part(first, 0, int(np.searchsorted(first.times, enters - _TIME_RESOLUTION)))
    rest = int(np.searchsorted(second.times, leaves + _TIME_RESOLUTION))
    after = _part(second, rest, len(second.times))
    end = enters + window
    return _joined(_joined(before, blend, enters), after, end - leaves), end


def _first_time(
    outside: Callable[[float], bool], longest: float, which: str, radius: float
) -> float:
    """Return when a motion passes the sphere; it begins in the middle of it."""
    inner = 0.0
    while inner < longest:
        outer = min(inner + _LOOK, longest)
        if outside(outer):
            for _ in range(_HALVINGS):
                middle = 0.5 * (inner + outer)
                inner, outer = (inner, middle) if outside(middle) else (middle, outer)
            return outer
        inner = outer
    raise PlanningError(
        MoveItErrorCode.FAILURE,
        f'the {which} motion lies within the blend radius {radius:g} m of the point where both '
        'meet; give a smaller blend_radius',
        'blend',
    )


def _part(motion: QuinticMotion, begin: int, end: int) -> QuinticMotion:
    rows = slice(begin, end)
    return QuinticMotion(
        motion.times[rows], motion.positions[rows], motion.velocities[rows],
        motion.accelerations[rows],
    )


def _joined(first: QuinticMotion, second: QuinticMotion, offset: float) -> QuinticMotion:
    """Return the points of both, those of the second later by an offset [s]."""
    return QuinticMotion(
        np.concatenate([first.times, second.times + offset]),
        np.concatenate([first.positions, second.positions]),
        np.concatenate([first.velocities, second.velocities]),
        np.concatenate([first.accelerations, second.accelerations]),
    )
