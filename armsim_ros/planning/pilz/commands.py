# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The commands PTP, LIN and CIRC: from a request to a trajectory that was checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.cartesian.curve_follower import CurveFollower
from armsim_ros.planning.cartesian.curves import Arc, Curve, Line
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraints.path_constraints import ConstraintSet
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.pilz.goal import check_scaling, CommandGoal, point_of, read_goal
from armsim_ros.planning.pilz.profile import along_curve, point_to_point, TrapezoidalProfile
from armsim_ros.planning.request import Constraints, MotionPlanRequest
from armsim_ros.planning.request_checks import link_speed_limit
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.start_state import check_start
from armsim_ros.planning.timing.path_timing import first_fault
from armsim_ros.planning.timing.quintic import QuinticMotion
from armsim_ros.trajectory import JointTrajectory

PIPELINE = 'pilz_industrial_motion_planner'
COMMANDS = ('CIRC', 'LIN', 'PTP')

SAMPLING_TIME = 0.1
"""Largest time [s] between two points of a trajectory."""

_AT_REST = 1e-6
_LIMIT_TOLERANCE = 1.01


def run_command(
    context: PlanningContext, request: MotionPlanRequest, scene: PlanningScene, budget: Budget
) -> tuple[JointTrajectory, float]:
    """
    Return the trajectory of a command and the length of its path [rad or m].

    :param scene: what to plan in; its state is the start.
    :raises PlanningError: with the code of section "Pilz" of what a client may rely on.
    """
    command = request.planner_id
    if command not in COMMANDS:
        raise PlanningError(
            MoveItErrorCode.PLANNING_FAILED,
            f"planner_id '{command}' is no command of {PIPELINE}; "
            f'{nearest(command, COMMANDS)} known: {", ".join(COMMANDS)}', PIPELINE,
        )
    check_scaling(request)
    if any(abs(value) > 1e-8 for value in request.start_state.velocities):
        raise PlanningError(
            MoveItErrorCode.INVALID_ROBOT_STATE,
            'the start state has a velocity; PTP, LIN and CIRC begin at rest', PIPELINE,
        )
    group = request.group_name
    kept = Constraints() if command == 'CIRC' else request.path_constraints
    validity = context.validity(scene, group, ConstraintSet(kept, scene, context.log))
    start = context.model.extract(scene.q, group)
    check_start(validity, start)
    goal = read_goal(context, request, scene)
    end = context.model.extract(goal.q, group)
    if float(np.max(np.abs(end - start))) < _AT_REST:
        return QuinticMotion.at_rest(start).trajectory(validity.joint_names), 0.0
    if command == 'PTP':
        limits = context.limits.limits(validity.joint_names)
        motion = point_to_point(start, end, limits.scaled(
            request.max_velocity_scaling_factor, request.max_acceleration_scaling_factor
        ), SAMPLING_TIME)
    else:
        curve = _curve(command, context, request, scene, goal)
        motion = along_curve(
            CurveFollower(context, validity, goal.frame), start, curve,
            _profile(context, request, curve), SAMPLING_TIME, lambda: budget.check(command),
        )
        _check_limits(context, motion, validity.joint_names, command)
    motion = _slow_enough(context, request, validity, motion)
    budget.check('ValidateSolution')
    fault = first_fault(motion, validity, context.settings.fine_step)
    if fault:
        raise PlanningError(
            MoveItErrorCode.INVALID_MOTION_PLAN,
            f'{command} goes its way whatever stands there: {fault}; give another goal, or plan '
            "around the obstacle with pipeline 'ompl'", 'ValidateSolution',
        )
    length = float(np.sum(np.linalg.norm(np.diff(motion.positions, axis=0), axis=1)))
    return motion.trajectory(validity.joint_names), length


def _profile(
    context: PlanningContext, request: MotionPlanRequest, curve: Curve
) -> TrapezoidalProfile:
    tool = context.settings.cartesian_limits
    distance, angle = max(curve.length, 1e-9), max(curve.angle, 1e-9)
    faster, sooner = request.max_velocity_scaling_factor, request.max_acceleration_scaling_factor
    turning = tool.max_rot_vel * tool.max_trans_acc / tool.max_trans_vel
    stopping = tool.max_rot_vel * abs(tool.max_trans_dec) / tool.max_trans_vel
    return TrapezoidalProfile(
        faster * min(tool.max_trans_vel / distance, tool.max_rot_vel / angle),
        sooner * min(tool.max_trans_acc / distance, turning / angle),
        sooner * min(abs(tool.max_trans_dec) / distance, stopping / angle),
    )


def _curve(
    command: str, context: PlanningContext, request: MotionPlanRequest, scene: PlanningScene,
    goal: CommandGoal,
) -> Curve:
    first = context.model.link_pose(scene.q, goal.frame.link) @ goal.frame.offset
    if command == 'LIN':
        return Line(first, goal.pose)
    kept = request.path_constraints
    if kept.name not in ('center', 'interim'):
        raise PlanningError(
            MoveItErrorCode.INVALID_MOTION_PLAN,
            f"path_constraints.name is '{kept.name}'; CIRC takes 'center' or 'interim' with one "
            'position constraint', 'CIRC',
        )
    if len(kept.position_constraints) != 1:
        raise PlanningError(
            MoveItErrorCode.INVALID_GOAL_CONSTRAINTS,
            f'path_constraints has {len(kept.position_constraints)} position constraints; CIRC '
            'takes exactly one', 'CIRC',
        )
    helper = kept.position_constraints[0]
    if helper.link_name and not scene.has_frame(helper.link_name):
        raise PlanningError(
            MoveItErrorCode.INVALID_LINK_NAME,
            f"the link '{helper.link_name}' of the {kept.name} point is not known", 'CIRC',
        )
    if not helper.regions:
        raise PlanningError(
            MoveItErrorCode.INVALID_MOTION_PLAN,
            f'the {kept.name} point has no pose: give one primitive pose', 'CIRC',
        )
    point = point_of(helper, scene)
    if kept.name == 'center':
        return Arc.around(first, goal.pose, point)
    return Arc.through(first, goal.pose, point)


@dataclass(frozen=True, slots=True)
class Excess:
    """
    A joint that is too fast.

    :param kind: velocity or acceleration.
    :param times: how often the limit.
    """

    kind: str
    joint: str
    found: float
    allowed: float
    times: float

    def __str__(self) -> str:
        """Name the joint, what it would need, and its limit."""
        return (f"would need {self.kind} {self.found:.3f} of joint '{self.joint}', whose limit is "
                f'{self.allowed:.3f}')


def worst_excess(
    context: PlanningContext, motion: QuinticMotion, joint_names: Sequence[str]
) -> Excess | None:
    """Return the joint that is furthest beyond a limit; only limits that were given count."""
    limits = context.limits.limits(joint_names)
    speed, acceleration = motion.peaks()
    given = [context.model.robot.joints[name].limits.acceleration for name in joint_names]
    known = np.where(np.isfinite(given) & (np.array(given) > 0.0), limits.acceleration, np.inf)
    for kind, found, allowed in (
        ('velocity', speed, limits.velocity), ('acceleration', acceleration, known)
    ):
        worst = int(np.argmax(found / allowed))
        excess = Excess(kind, joint_names[worst], float(found[worst]), float(allowed[worst]),
                        float(found[worst] / allowed[worst]))
        if excess.times > _LIMIT_TOLERANCE:
            return excess
    return None


def _check_limits(
    context: PlanningContext, motion: QuinticMotion, joint_names: Sequence[str], command: str
) -> None:
    excess = worst_excess(context, motion, joint_names)
    if excess is not None:
        raise PlanningError(
            MoveItErrorCode.FAILURE,
            f'{command} {excess}; give a max_{excess.kind}_scaling_factor below '
            f'{1.0 / excess.times:.2f} times the present one, or keep away from the singularity',
            command,
        )


def _slow_enough(
    context: PlanningContext, request: MotionPlanRequest, validity: StateValidity,
    motion: QuinticMotion,
) -> QuinticMotion:
    """Return the motion slowed to the request's ``max_cartesian_speed``."""
    limit = link_speed_limit(
        context.model, validity, request.group_name, request.cartesian_speed_limited_link,
        request.max_cartesian_speed,
    )
    if limit is None:
        return motion
    times = np.linspace(0.0, motion.duration, 8 * len(motion.times))
    positions = motion.sample(times)
    slopes = np.gradient(positions, times, axis=0)
    factor = 1.01 / float(np.min(limit(positions, slopes)))
    return motion.slowed(max(1.0, factor))
