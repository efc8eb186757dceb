# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The answer to a request for a Cartesian path: followed, cut at jumps, timed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import PlanningError
from armsim_ros.planning.cartesian_path import (
    CartesianInterpolator,
    CartesianPath,
    CartesianRequest,
    cut_at_jump,
)
from armsim_ros.planning.constraint_terms import Frame
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.limits import scaling_factor
from armsim_ros.planning.path_timing import time_waypoints
from armsim_ros.planning.regions import is_place
from armsim_ros.planning.request_checks import link_speed_limit
from armsim_ros.planning.scene import PlanningScene
from armsim_ros.planning.smoothing import without_repeats
from armsim_ros.planning.start_state import bounded_start
from armsim_ros.planning.state_validity import StateValidity
from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint

Vector = NDArray[np.float64]

MAX_DEVIATION = 0.002
"""Largest distance [rad or m] in joint space between a corner and its blend."""

_SOURCE = 'compute_cartesian_path'


@dataclass(frozen=True, slots=True)
class CartesianResponse:
    """
    The answer to a :class:`CartesianRequest`.

    :param message: why the path ends early or is missing, else ''.
    :param fraction: covered part of the path, 0..1.
    :param start: joint -> position [rad or m] of all movable joints.
    """

    error_code: MoveItErrorCode
    message: str = ''
    source: str = ''
    trajectory: JointTrajectory = field(default_factory=lambda: JointTrajectory(()))
    fraction: float = 0.0
    start: Mapping[str, float] = field(default_factory=dict)


def plan_cartesian(
    context: PlanningContext, request: CartesianRequest, scene: PlanningScene,
    cancelled: Callable[[], bool],
) -> CartesianResponse:
    """Return the feasible part of a path; a shorter one is a success with a fraction below 1."""
    start: dict[str, float] = {}

    def poll() -> None:
        if cancelled():
            raise PlanningError(
                MoveItErrorCode.PREEMPTED, 'the request was cancelled', _SOURCE)

    try:
        context.model.group_indices(request.group_name)
        if not request.max_step > 1e-9 or not np.isfinite(request.max_step):
            raise PlanningError(
                MoveItErrorCode.FAILURE,
                f'max_step is {request.max_step:g}; give a distance above 0, e.g. 0.01', _SOURCE,
            )
        if not request.waypoints:
            return CartesianResponse(MoveItErrorCode.SUCCESS)
        settings = context.settings
        scene = scene.with_start_state(request.start_state, strict=settings.strict_start_state)
        scene.set_state(
            bounded_start(scene, settings.start_state_max_bounds_error, context.log)
        )
        start = context.model.positions(scene.q)
        on_path = ConstraintSet(request.path_constraints, scene, context.log)
        with context.polled(poll):
            validity = context.validity(
                scene, request.group_name, on_path, request.avoid_collisions
            )
        path = _followed(context, request, scene, validity)
        trajectory = _timed(context, request, validity, path)
    except PlanningError as error:
        context.log.error(f'{_SOURCE}: {error}')
        return CartesianResponse(
            MoveItErrorCode(error.code), str(error), error.source or _SOURCE, start=start
        )
    if path.reason:
        context.log.info(f'{_SOURCE}: {path.fraction:.1%} of the path: {path.reason}')
    return CartesianResponse(
        MoveItErrorCode.SUCCESS, path.reason, _SOURCE if path.reason else '', trajectory,
        path.fraction, start,
    )


def _followed(
    context: PlanningContext, request: CartesianRequest, scene: PlanningScene,
    validity: StateValidity,
) -> CartesianPath:
    group = request.group_name
    name = request.link_name or context.tip(group)
    try:
        frame = Frame(*scene.link_of_frame(name))
    except PlanningError as error:
        raise PlanningError(MoveItErrorCode.INVALID_LINK_NAME, str(error), _SOURCE) from None
    if frame.link not in context.model.moved_links(group):
        raise PlanningError(
            MoveItErrorCode.INVALID_LINK_NAME,
            f"group '{group}' does not move link '{name}'", _SOURCE,
        )
    if not all(map(is_place, request.waypoints)):
        raise PlanningError(
            MoveItErrorCode.FAILURE, 'a waypoint has a number that is not finite or too large',
            _SOURCE,
        )
    relative = bool(request.frame_id) and request.frame_id == name
    waypoints = request.waypoints
    if not relative:
        base = scene.frame_pose(request.frame_id, scene.q)
        waypoints = tuple(base @ waypoint for waypoint in waypoints)
    interpolator = CartesianInterpolator(
        context.model, context.inverse(group), validity, frame,
        position_only=group in context.settings.position_only_ik,
    )
    path = interpolator.follow(
        context.model.extract(scene.q, group), waypoints, request.max_step,
        context.settings.fine_step, relative=relative,
    )
    joints = context.model.robot.joints
    cut_at_jump(path, request, tuple(joints[name].type for name in validity.joint_names))
    return path


def _timed(
    context: PlanningContext, request: CartesianRequest, validity: StateValidity,
    path: CartesianPath,
) -> JointTrajectory:
    waypoints = without_repeats(path.states, 1e-6)
    if len(waypoints) < 2:
        zero = np.zeros(len(path.states[0]))
        return JointTrajectory(
            validity.joint_names, (TrajectoryPoint(0.0, path.states[0], zero, zero),)
        )
    limits = context.limits.limits(validity.joint_names).scaled(
        scaling_factor(
            request.max_velocity_scaling_factor, 'max_velocity_scaling_factor', context.log
        ),
        scaling_factor(
            request.max_acceleration_scaling_factor, 'max_acceleration_scaling_factor',
            context.log,
        ),
    )
    speed_limit = link_speed_limit(
        context.model, validity, request.group_name, request.cartesian_speed_limited_link,
        request.max_cartesian_speed,
    )
    motion = time_waypoints(
        waypoints, validity, limits, speed_limit, context.settings.fine_step, MAX_DEVIATION
    )
    return motion.trajectory(validity.joint_names)
