# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint motions that take a link along a curve."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import PlanningError
from armsim_ros.kinematics.inverse import IKTarget
from armsim_ros.model.transforms import skew
from armsim_ros.planning.constraint_terms import Frame
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.pilz.curves import Curve
from armsim_ros.planning.pilz.profile import TrapezoidalProfile
from armsim_ros.planning.quintic import QuinticMotion
from armsim_ros.planning.state_validity import StateValidity

Vector = NDArray[np.float64]

PRECISION = 5e-4
"""Largest distance [m] of the link from the curve between two points."""

_MOST_HALVINGS = 5
_DAMPING = 1e-6


def follow(
    context: PlanningContext, validity: StateValidity, start: Vector, frame: Frame, curve: Curve,
    profile: TrapezoidalProfile, step: float, check: Callable[[], None],
) -> QuinticMotion:
    """
    Return the joint motion that takes a frame along a curve.

    :param start: (m,) the group's values at the curve's beginning.
    :param frame: what follows the curve.
    :param profile: when it is where.
    :param step: largest time between two points [s]; smaller ones are taken where the link
        would leave the curve by more than :data:`PRECISION`.
    :param check: called now and then; raises where the request was cancelled.
    :raises PlanningError: FAILURE where the arm cannot follow.
    """
    for _ in range(_MOST_HALVINGS):
        check()
        times = profile.times(step)
        motion = _sampled(context, validity, start, frame, curve, profile, times)
        if _deviation(context, validity, frame, curve, profile, motion) <= PRECISION:
            return motion
        step *= 0.5
    raise PlanningError(
        MoveItErrorCode.FAILURE,
        f"the joints would have to jump for '{frame.link}' to stay on its path; begin in another "
        'posture, or keep away from the singularity', 'link path',
    )


def _sampled(
    context: PlanningContext, validity: StateValidity, start: Vector, frame: Frame, curve: Curve,
    profile: TrapezoidalProfile, times: Vector,
) -> QuinticMotion:
    place, speed, rate = profile.sample(times)
    inverse = context.inverse(validity.group)
    q = validity.full(start)
    states, slopes = [], []
    for s in place:
        result = inverse.solve(
            [IKTarget(frame.link, curve.pose(float(s)), frame.offset)], q, max_starts=0
        )
        if result.q is None:
            raise PlanningError(
                MoveItErrorCode.FAILURE,
                f"'{frame.link}' cannot follow its path beyond {s:.0%} of it: {result.message}",
                'link path',
            )
        q = result.q
        states.append(context.model.extract(q, validity.group))
        slopes.append(_slope(context, validity, frame, q, curve.twist(float(s))))
    positions, slope = np.array(states), np.array(slopes)
    distinct = np.concatenate([[True], np.diff(place) > 1e-9])
    bend = np.zeros_like(slope)
    if np.count_nonzero(distinct) > 2:
        bend[distinct] = np.gradient(slope[distinct], place[distinct], axis=0)
    return QuinticMotion(
        times,
        positions,
        slope * speed[:, None],
        bend * speed[:, None] ** 2 + slope * rate[:, None],
    )


def _slope(
    context: PlanningContext, validity: StateValidity, frame: Frame, q: Vector, twist: Vector
) -> Vector:
    """Return how the joints (m,) move with the place on the curve."""
    jacobian = context.model.jacobian(q, frame.link, validity.group)
    arm = context.model.link_pose(q, frame.link)[:3, :3] @ frame.offset[:3, 3]
    jacobian[:3] -= skew(arm) @ jacobian[3:]
    rows = 3 if validity.group in context.settings.position_only_ik else 6
    used = jacobian[:rows]
    square = used @ used.T + _DAMPING * np.eye(rows)
    slope: Vector = used.T @ np.linalg.solve(square, twist[:rows])
    return slope


def _deviation(
    context: PlanningContext, validity: StateValidity, frame: Frame, curve: Curve,
    profile: TrapezoidalProfile, motion: QuinticMotion,
) -> float:
    """Return the largest distance [m] from the curve halfway between the points."""
    middles = 0.5 * (motion.times[1:] + motion.times[:-1])
    place, _, _ = profile.sample(middles)
    off = [
        float(np.linalg.norm(
            (context.model.link_pose(validity.full(values), frame.link) @ frame.offset
             - curve.pose(float(s)))[:3, 3]
        ))
        for s, values in zip(place, motion.sample(middles), strict=True)
    ]
    return max(off)
