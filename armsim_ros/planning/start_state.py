# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a motion can begin where it is asked to begin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import PlanningError
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.log import Log
from armsim_ros.planning.scene import PlanningScene
from armsim_ros.planning.state_validity import StateValidity

Vector = NDArray[np.float64]

ROUNDING = 1e-5
"""How far [rad or m] a measured position may lie beyond a limit without a word."""


def bounded_start(scene: PlanningScene, max_bounds_error: float, log: Log) -> Vector:
    """
    Return the scene's state with every joint inside its limits.

    :param scene: its state is the start.
    :param max_bounds_error: largest distance [rad or m] beyond a limit that is repaired.
    :returns: (n,).
    :raises PlanningError: START_STATE_INVALID with the joint, its value and its limits.
    """
    model = scene.kinematic_model
    q = scene.q.copy()
    for name in scene.robot.active_joints:
        index = model.index(name)
        value, low, high = float(q[index]), float(model.lower[index]), float(model.upper[index])
        beyond = max(low - value, value - high)
        if beyond <= 0.0:
            continue
        if not beyond <= max(max_bounds_error, ROUNDING):
            raise PlanningError(
                MoveItErrorCode.START_STATE_INVALID,
                f"joint '{name}' starts at {value:.5f}, outside its limits {low:.5f} .. "
                f'{high:.5f} by {beyond:.5f}; move the robot back by hand, or allow it with '
                'start_state_max_bounds_error',
                'CheckStartStateBounds',
            )
        q[index] = min(max(value, low), high)
        if beyond > ROUNDING:
            log.warning(
                f"joint '{name}' starts at {value:.5f}, beyond its limit: planning from "
                f'{float(q[index]):.5f}'
            )
    return model.apply_mimic(q)


def check_start(validity: StateValidity, start: Vector) -> None:
    """
    Refuse a start that collides or breaks the path constraints.

    :param start: (m,) the group's values.
    :raises PlanningError: START_STATE_IN_COLLISION with the touching pairs, or
        START_STATE_VIOLATES_PATH_CONSTRAINTS with the constraint.
    """
    if validity.collides(start):
        raise PlanningError(
            MoveItErrorCode.START_STATE_IN_COLLISION,
            f'the start state collides: {validity.touching(start)}; move the robot or the '
            'object, or allow the pair in the allowed collision matrix',
            'CheckStartStateCollision',
        )
    if not validity.constrained(start):
        raise PlanningError(
            MoveItErrorCode.START_STATE_VIOLATES_PATH_CONSTRAINTS,
            f'the start state breaks the path constraints: {validity.why_not(start)}; move to '
            'a state that keeps them first, or widen them',
            'CheckStartStatePathConstraints',
        )
