# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The commands PTP, LIN and CIRC."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.cartesian.curves import Arc, Curve, Line
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.pilz.goal import CommandGoal
from armsim_ros.planning.pilz.joint_sampling import (
    given_limits,
    JointSampler,
    point_to_point,
    SAMPLING_TIME,
    TrapezoidalProfile,
)
from armsim_ros.planning.request import Constraints, MotionPlanRequest
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.search.shortening import path_length
from armsim_ros.planning.start_state import check_start
from armsim_ros.planning.timing.limits import link_speed_limit, MotionLimits
from armsim_ros.planning.timing.path_timing import first_fault
from armsim_ros.quintic_motion import QuinticMotion
from armsim_ros.trajectory import JointTrajectory

PIPELINE = 'pilz_industrial_motion_planner'
COMMANDS = ('CIRC', 'LIN', 'PTP')

LEAST_MOVEMENT = 0.001
"""A PTP by less than this in every joint [rad or m] is at its goal."""

_LEAST_SCALING = 1e-4
_LARGEST_START_VELOCITY = 1e-8


def run_command(
    context: PlanningContext, request: MotionPlanRequest, present: PlanningScene,
    scene: PlanningScene, budget: Budget,
) -> tuple[JointTrajectory, float]:
    """
    Return the trajectory of a command and the length of its path [rad or m].

    :param present: the monitored scene; frames are where they are in it.
    :param scene: what to plan in; its state is the start.
    :raises PlanningError: with the code of the first rule that the request breaks.
    """
    group, command = request.group_name, request.planner_id
    _check_context(context, request)
    kept = Constraints() if command == 'CIRC' else request.path_constraints
    start = context.model.extract(scene.q, group)
    check_start(context.validity(scene, group), start)
    _check_request(context, request)
    goal = CommandGoal(context, request, present, scene)
    if command == 'CIRC':
        _check_arc(request.path_constraints)
    validity = context.validity(scene, group, ConstraintSet(kept, scene, context.log))
    if command == 'PTP':
        motion = _point_to_point(context, request, validity, goal, start)
    else:
        motion = _along_curve(context, request, scene, validity, goal, start, budget)
    motion = _slow_enough(context, request, validity, motion)
    budget.check('ValidateSolution')
    fault = first_fault(motion, validity, context.settings.fine_step)
    if fault:
        raise PlanningError(
            MoveItErrorCode.INVALID_MOTION_PLAN,
            f'{command} does not plan around obstacles: {fault}; give another goal, or plan with '
            "pipeline 'ompl'", 'ValidateSolution', fault.contacts,
        )
    return motion.trajectory(validity.joint_names), path_length(motion.positions)


def _check_context(context: PlanningContext, request: MotionPlanRequest) -> None:
    """Refuse requests for which there is no command, or no group with a solver."""
    group, fault = request.group_name, ''
    if request.planner_id not in COMMANDS:
        fault = (f"planner_id '{request.planner_id}' is not a command of {PIPELINE}; "
                 f'{nearest(request.planner_id, COMMANDS)} known: {", ".join(COMMANDS)}')
    elif group not in context.model.robot.semantic.groups:
        known = context.model.robot.semantic.groups
        fault = f"planning group '{group}' is not known; known: {', '.join(known) or 'none'}"
    elif context.solver_tip(group) is None:
        fault = (f"group '{group}' has no kinematics solver, which {PIPELINE} needs; only chains "
                 'with a kinematics_solver in kinematics.yaml have a solver')
    if fault:
        raise PlanningError(MoveItErrorCode.PLANNING_FAILED, fault, PIPELINE)


def _check_request(context: PlanningContext, request: MotionPlanRequest) -> None:
    """Refuse scaling factors outside (0.0001, 1], and a group that does not start at rest."""
    for name in ('max_velocity_scaling_factor', 'max_acceleration_scaling_factor'):
        value = getattr(request, name)
        if not _LEAST_SCALING < value <= 1.0:
            raise PlanningError(
                MoveItErrorCode.INVALID_MOTION_PLAN,
                f'{name} is {value:g}; PTP, LIN and CIRC take a number above 0.0001, up to 1',
                PIPELINE,
            )
    start = request.start_state
    names = context.model.robot.semantic.groups[request.group_name].active_joints
    for name, velocity in zip(start.joint_names, start.velocities, strict=False):
        if name in names and not abs(velocity) < _LARGEST_START_VELOCITY:
            raise PlanningError(
                MoveItErrorCode.INVALID_ROBOT_STATE,
                f"joint '{name}' has the velocity {velocity:g} in the start state; PTP, LIN and "
                'CIRC start at rest', PIPELINE,
            )


def _point_to_point(
    context: PlanningContext, request: MotionPlanRequest, validity: StateValidity,
    goal: CommandGoal, start: Vector,
) -> QuinticMotion:
    end = context.model.extract(goal.joint_state(), validity.group)
    if float(np.max(np.abs(end - start))) < LEAST_MOVEMENT:
        rest = np.zeros((1, len(start)))
        return QuinticMotion(np.array([SAMPLING_TIME]), start[None], rest, rest)
    return point_to_point(start, end, _common_limits(context, validity.joint_names).scaled(
        request.max_velocity_scaling_factor, request.max_acceleration_scaling_factor))


def _common_limits(context: PlanningContext, joint_names: tuple[str, ...]) -> MotionLimits:
    """Return the limits of joints; those that are not given count only where none is given."""
    limits = context.limits.limits(joint_names)
    velocity, acceleration = given_limits(context.model.robot, joint_names)
    return replace(
        limits,
        velocity=velocity if np.isfinite(velocity).any() else limits.velocity,
        acceleration=acceleration if np.isfinite(acceleration).any() else limits.acceleration)


def _along_curve(
    context: PlanningContext, request: MotionPlanRequest, scene: PlanningScene,
    validity: StateValidity, goal: CommandGoal, start: Vector, budget: Budget,
) -> QuinticMotion:
    """Return the motion of a frame along a line or an arc."""
    command, kept = request.planner_id, request.path_constraints
    auxiliary = ''
    if command == 'CIRC' and not goal.posed:
        auxiliary = kept.position_constraints[0].link_name
        if auxiliary not in context.model.robot.links:
            raise PlanningError(
                MoveItErrorCode.INVALID_LINK_NAME,
                f"the link '{auxiliary}' of the {kept.name} point is not known; the arc of a "
                'joint goal is that of this link', command)
    goal.check_all_joints()
    frame = goal.frame(auxiliary)
    state = goal.joint_state()
    last = goal.pose() if goal.posed else (
        context.model.link_pose(state, frame.link) @ frame.offset)
    first = context.model.link_pose(scene.q, frame.link) @ frame.offset
    curve: Curve
    if command == 'LIN':
        curve = Line(first, last)
    else:
        arc = Arc.around if kept.name == 'center' else Arc.through
        curve = arc(first, last, goal.auxiliary_point(kept))
    tool = context.settings.cartesian_limits
    # Rotation counts as length with this factor.
    length = max(curve.length, curve.angle * tool.max_trans_vel / tool.max_rot_vel)
    profile = TrapezoidalProfile(
        length, request.max_velocity_scaling_factor * tool.max_trans_vel,
        request.max_acceleration_scaling_factor * tool.max_trans_acc)

    def pose_at(time: float) -> Matrix:
        return curve.pose(profile.states(np.array([time]))[0].item() / max(length, 1e-12))

    sampler = JointSampler(context, validity, frame, command, lambda: budget.check(command))
    return sampler.from_rest_to_rest(pose_at, profile.duration, start)


def _check_arc(kept: Constraints) -> None:
    fault = ''
    if kept.name not in ('center', 'interim'):
        fault = (f"path_constraints.name is '{kept.name}'; CIRC takes 'center' or 'interim' with "
                 'one position constraint')
    elif len(kept.position_constraints) != 1:
        fault = (f'path_constraints has {len(kept.position_constraints)} position constraints; '
                 'CIRC takes exactly one')
    elif len(kept.position_constraints[0].poses) != 1:
        fault = (f'the {kept.name} point has {len(kept.position_constraints[0].poses)} primitive '
                 'poses; CIRC takes exactly one')
    if fault:
        raise PlanningError(MoveItErrorCode.INVALID_MOTION_PLAN, fault, 'CIRC')


def _slow_enough(
    context: PlanningContext, request: MotionPlanRequest, validity: StateValidity,
    motion: QuinticMotion,
) -> QuinticMotion:
    """Return the motion slowed to the request's ``max_cartesian_speed``."""
    limit = link_speed_limit(context.model, validity, request)
    if limit is None or len(motion.times) < 2:
        return motion
    times = np.linspace(0.0, motion.duration, 8 * len(motion.times))
    positions = motion.sample(times)
    slopes = np.gradient(positions, times, axis=0)
    factor = 1.01 / float(np.min(limit(positions, slopes)))
    return motion.slowed(max(1.0, factor))
