# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From free waypoints to a timed motion that was checked as a controller will run it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.planning.collision.motion_proof import first_blocked
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.timing.limits import MotionLimits, SpeedLimit
from armsim_ros.planning.timing.time_parameterization import BlendedPath, time_path
from armsim_ros.quintic_motion import QuinticMotion

MAX_DEVIATION = 0.05
"""Largest distance [rad or m] in joint space between a corner and the blend that rounds it."""

FINAL_SHARE = 0.6
"""The last check's step as a share of that of the path's."""

_LEAST_DEVIATION = 1e-4
_SHRINK = 0.35
_ATTEMPTS = 4
_LOOKS = 4
_SAMPLES = 9
_NOTHING = 2e-4  # [m] by which a blend may leave a free corner unlooked at: the proof comes later
_OVERSHOOT = 1e-3


def time_waypoints(
    waypoints: Vector, validity: StateValidity, limits: MotionLimits,
    speed_limit: SpeedLimit | None, step: float, rough: bool = False, *,
    max_deviation: float = MAX_DEVIATION,
) -> QuinticMotion:
    """
    Return the fastest motion through free waypoints that is free itself.

    Every blend shrinks until it is free; where the timed motion is not free yet, all shrink.

    :param waypoints: (k, m) k >= 2.
    :param step: largest motion of any point between two checks [m].
    :param rough: the waypoints come of a search in larger steps: half of the clearance has to
        be left, and only blends that are not free are made smaller, where the motion is not free:
        the path itself may be blocked.
    :param max_deviation: of a blend from its corner [rad or m].
    :raises PlanningError: INVALID_MOTION_PLAN with time and cause where it stays blocked;
        FAILURE where the limits cannot be kept.
    """
    deviation = np.full(len(waypoints) - 2, max(max_deviation, _LEAST_DEVIATION))
    fault: Fault | None = None
    clearance = 0.5 * validity.clearance if rough else 0.0
    if not rough:
        _shrink_corners(waypoints, deviation, validity)
    for attempt in range(2 if rough else _ATTEMPTS):
        motion = time_path(BlendedPath(waypoints, deviation), limits, speed_limit)
        fault = first_fault(motion, validity, FINAL_SHARE * step, clearance)
        if fault is None:
            return motion
        if not len(deviation):
            break
        if rough:
            if attempt or not _shrink_corners(waypoints, deviation, validity):
                break
        else:
            deviation = np.maximum(deviation * _SHRINK**2, _LEAST_DEVIATION)
    raise PlanningError(
        MoveItErrorCode.INVALID_MOTION_PLAN,
        f'the timed trajectory is not valid {fault}; plan again, or keep more clearance around '
        'objects',
        'ValidateSolution', fault.contacts if fault else ())


def _shrink_corners(
    waypoints: Vector, deviation: Vector, validity: StateValidity
) -> bool:
    """Make the blend at every inner waypoint so small that it is free; return whether any was."""
    before = deviation.copy()
    steps = np.diff(waypoints, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    turns = np.linalg.norm(np.diff(steps / lengths[:, None], axis=0), axis=1)
    cut = np.minimum(deviation, turns * np.minimum(lengths[:-1], lengths[1:]) / 8.0)
    weight = float(np.linalg.norm(validity.displacement_weights))
    corners = np.flatnonzero(cut * weight > _NOTHING)
    while len(corners):
        path = BlendedPath(waypoints, deviation)
        samples = [path.corner_samples(int(corner), _SAMPLES) for corner in corners]
        blocked = validity.blocked(np.concatenate(samples), 0.5 * validity.clearance)
        ends = np.cumsum([len(each) for each in samples])
        corners = corners[[bool(part.any()) for part in np.split(blocked, ends[:-1])]]
        deviation[corners] = np.maximum(deviation[corners] * _SHRINK, _LEAST_DEVIATION)
        corners = corners[deviation[corners] > _LEAST_DEVIATION]
    return not np.array_equal(before, deviation)


@dataclass(frozen=True, slots=True)
class Fault:
    """
    The first state of a motion that is not valid.

    :param text: when and why, as a phrase.
    :param contacts: the collisions in it.
    """

    text: str
    contacts: tuple[Contact, ...] = ()

    def __str__(self) -> str:
        """Return when and why."""
        return self.text


def first_fault(
    motion: QuinticMotion, validity: StateValidity, step: float, clearance: float = 0.0,
    since: float = 0.0,
) -> Fault | None:
    """
    Return where a motion leaves the free states; None for nowhere.

    :param motion: is followed between its points too.
    :param step: largest motion [m] of any point between two checks of path constraints.
    :param clearance: [m] that shall be left to everything.
    :param since: time [s] before which nothing is checked.
    """
    t = _blocked_at(motion, validity, step, clearance, since)
    if t is None:
        return None
    state = motion.sample(np.array([t]))[0]
    return Fault(f'at {t:.3f} s: {validity.why_not(state)}', validity.contacts(state))


def _blocked_at(
    motion: QuinticMotion, validity: StateValidity, step: float, clearance: float, since: float
) -> float | None:
    """Return the time [s] at which a motion leaves limits or free states, None for never."""
    if len(motion.times) < 2 or since >= motion.duration:
        return None
    times = np.linspace(since, motion.duration, 1 + _LOOKS * (len(motion.times) - 1))
    positions = motion.sample(times)
    beyond = np.flatnonzero(np.any(
        (positions < validity.lower - _OVERSHOOT) | (positions > validity.upper + _OVERSHOOT),
        axis=1))
    return float(times[beyond[0]]) if len(beyond) else first_blocked(
        positions, validity, step, times, clearance)
