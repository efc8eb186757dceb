# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The commands PTP, LIN and CIRC: their goals, and the motions to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.kinematics.inverse import IKOptions, IKTarget
from armsim_ros.model.transforms import matrix_from_quat_xyzw, pose_from_parts
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.cartesian.curves import Arc, Curve, CurveFollower, Line
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraint_terms import Frame
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.pilz.profile import along_curve, point_to_point, TrapezoidalProfile
from armsim_ros.planning.request import (
    Constraints,
    is_place,
    MotionPlanRequest,
    PositionConstraint,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.search.shortening import path_length
from armsim_ros.planning.start_state import check_start
from armsim_ros.planning.timing.limits import link_speed_limit
from armsim_ros.planning.timing.path_timing import first_fault
from armsim_ros.quintic_motion import QuinticMotion
from armsim_ros.trajectory import JointTrajectory

_SOURCE = 'Pilz goal'
_LEAST_SCALING = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class CommandGoal:
    """
    Where a command ends.

    :param q: (n,) full robot state there.
    :param frame: the link that the goal is about, or the group's last one.
    :param pose: (4, 4) of that frame in the model frame.
    """

    q: Vector
    frame: Frame
    pose: Vector


def check_scaling(request: MotionPlanRequest) -> None:
    """Refuse scaling factors outside (0.0001, 1]: a command's speed is part of its meaning."""
    for name in ('max_velocity_scaling_factor', 'max_acceleration_scaling_factor'):
        value = getattr(request, name)
        if not _LEAST_SCALING < value <= 1.0:
            raise PlanningError(
                MoveItErrorCode.INVALID_MOTION_PLAN,
                f'{name} is {value:g}; PTP, LIN and CIRC take a number above 0.0001, up to 1',
                _SOURCE,
            )


def read_goal(
    context: PlanningContext, request: MotionPlanRequest, scene: PlanningScene
) -> CommandGoal:
    """
    Return the goal of a request.

    :param scene: its state is the start.
    :raises PlanningError: INVALID_GOAL_CONSTRAINTS for what is no single goal; NO_IK_SOLUTION
        where its pose cannot be reached.
    """
    if len(request.goal_constraints) != 1:
        raise _error(f'the request has {len(request.goal_constraints)} goal constraints; PTP, LIN '
                     'and CIRC take exactly one')
    goal = request.goal_constraints[0]
    if goal.empty:
        raise _error('the goal constraint is empty')
    posed = goal.position_constraints or goal.orientation_constraints
    if goal.joint_constraints and posed:
        raise _error('the goal mixes joint constraints with a pose; give one of the two')
    if posed:
        return _pose_goal(context, request.group_name, goal, scene)
    return _joint_goal(context, request.group_name, goal, scene)


def _joint_goal(
    context: PlanningContext, group: str, goal: Constraints, scene: PlanningScene
) -> CommandGoal:
    model = context.model
    names = [model.names[index] for index in model.group_indices(group)]
    values: dict[str, float] = {}
    for each in goal.joint_constraints:
        if each.joint_name not in names:
            raise _error(f"joint '{each.joint_name}' of the goal is not in group '{group}'; it "
                         f'has {", ".join(names)}')
        index = model.index(each.joint_name)
        low, high = float(model.lower[index]), float(model.upper[index])
        if not low - 1e-6 <= each.position <= high + 1e-6:
            raise _error(f"goal {each.position:.4f} of joint '{each.joint_name}' is outside its "
                         f'limits {low:.4f} .. {high:.4f}')
        values[each.joint_name] = min(max(each.position, low), high)
    if not values:
        raise _error('the goal has no joint, position or orientation constraint')
    q = model.vector(values, scene.q)
    frame = Frame(context.tip(group), np.eye(4))
    return CommandGoal(q, frame, model.link_pose(q, frame.link))


def _pose_goal(
    context: PlanningContext, group: str, goal: Constraints, scene: PlanningScene
) -> CommandGoal:
    if len(goal.position_constraints) != 1 or len(goal.orientation_constraints) != 1:
        raise _error(f'the goal has {len(goal.position_constraints)} position and '
                     f'{len(goal.orientation_constraints)} orientation constraints; a pose is '
                     'one of each')
    position, orientation = goal.position_constraints[0], goal.orientation_constraints[0]
    if not position.link_name or position.link_name != orientation.link_name:
        raise _error(f"the goal's position is for link '{position.link_name}', its orientation "
                     f"for '{orientation.link_name}'; both have to name the same link")
    try:
        frame = Frame(*scene.link_of_frame(position.link_name))
    except PlanningError as error:
        raise _error(str(error)) from None
    quat = np.asarray(orientation.quat_xyzw)
    if not abs(float(np.linalg.norm(quat)) - 1.0) <= 1e-3:
        raise _error(f'the goal orientation {orientation.quat_xyzw} is not of length 1')
    turned = scene.frame_pose(orientation.frame_id, scene.q)[:3, :3] @ matrix_from_quat_xyzw(quat)
    offset = np.asarray(position.target_point_offset)
    pose = pose_from_parts(point_of(position, scene) - turned @ offset, turned)
    inverse, target = context.inverse(group), IKTarget(frame.link, pose, frame.offset)
    result = inverse.solve(
        [target], scene.q, IKOptions(lambda q: not context.checker.in_collision(q, group)))
    if result.q is None:
        result = inverse.solve([target], scene.q)
    if result.q is None:
        raise PlanningError(
            MoveItErrorCode.NO_IK_SOLUTION,
            f"no joint positions put '{position.link_name}' at "
            f'{np.round(pose[:3, 3], 4).tolist()} m in the model frame: {result.message}',
            _SOURCE,
        )
    return CommandGoal(result.q, frame, pose)


def point_of(position: PositionConstraint, scene: PlanningScene) -> Vector:
    """
    Return the point (3,) of a position constraint's region in the model frame.

    :raises PlanningError: INVALID_GOAL_CONSTRAINTS where it has no region, or one that is none.
    """
    if not position.regions:
        raise _error(f"the position of '{position.link_name}' has no region with a pose")
    region = position.regions[0]
    fault = region.fault
    if fault or not is_place(np.asarray(position.target_point_offset)):
        raise _error(f"the position of '{position.link_name}' cannot be used: "
                     + (fault or 'target_point_offset is not finite'))
    base = scene.frame_pose(position.frame_id, scene.q)
    point: Vector = (base @ region.pose)[:3, 3]
    return point


def _error(text: str) -> PlanningError:
    return PlanningError(MoveItErrorCode.INVALID_GOAL_CONSTRAINTS, text, _SOURCE)


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
    return motion.trajectory(validity.joint_names), path_length(motion.positions)


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
    helpers = kept.position_constraints
    code, fault = MoveItErrorCode.INVALID_MOTION_PLAN, ''
    if kept.name not in ('center', 'interim'):
        fault = (f"path_constraints.name is '{kept.name}'; CIRC takes 'center' or 'interim' with "
                 'one position constraint')
    elif len(helpers) != 1:
        code = MoveItErrorCode.INVALID_GOAL_CONSTRAINTS
        fault = f'path_constraints has {len(helpers)} position constraints; CIRC takes exactly one'
    elif helpers[0].link_name and not scene.has_frame(helpers[0].link_name):
        code = MoveItErrorCode.INVALID_LINK_NAME
        fault = f"the link '{helpers[0].link_name}' of the {kept.name} point is not known"
    elif not helpers[0].regions:
        fault = f'the {kept.name} point has no pose: give one primitive pose'
    if fault:
        raise PlanningError(code, fault, 'CIRC')
    point = point_of(helpers[0], scene)
    arc = Arc.around if kept.name == 'center' else Arc.through
    return arc(first, goal.pose, point)


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
    limit = link_speed_limit(context.model, validity, request)
    if limit is None:
        return motion
    times = np.linspace(0.0, motion.duration, 8 * len(motion.times))
    positions = motion.sample(times)
    slopes = np.gradient(positions, times, axis=0)
    factor = 1.01 / float(np.min(limit(positions, slopes)))
    return motion.slowed(max(1.0, factor))
