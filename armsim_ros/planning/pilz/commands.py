# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The commands PTP, LIN and CIRC."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.pipeline_defaults import PILZ
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.kinematics.inverse import IKOptions, IKTarget
from armsim_ros.model.transforms import matrix_from_quat_xyzw, pose_from_parts
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.cartesian_curves import Arc, Curve, Line
from armsim_ros.planning.collision.contacts import BodyType
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraint_terms import Frame
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.pilz.joint_sampling import (
    given_limits,
    JointSampler,
    point_to_point,
    SAMPLING_TIME,
    TrapezoidalProfile,
)
from armsim_ros.planning.request import (
    Constraints,
    is_place,
    MotionPlanRequest,
    OrientationConstraint,
    PositionConstraint,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.search.shortening import path_length
from armsim_ros.planning.start_state import check_start
from armsim_ros.planning.timing.limits import link_speed_limit, MotionLimits
from armsim_ros.planning.timing.path_timing import first_fault
from armsim_ros.quintic_motion import QuinticMotion
from armsim_ros.trajectory import JointTrajectory

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
    kept = request.path_constraints
    if command == 'CIRC':
        # The position constraint is the auxiliary point.
        kept = replace(kept, position_constraints=())
    start = context.model.extract(scene.q, group)
    check_start(context.validity(scene, group), start)
    _check_request(context, request)
    goal = CommandGoal(context, request, present, scene)
    if command == 'CIRC':
        _check_arc(request.path_constraints)
    validity = context.validity(scene, group, ConstraintSet(kept, scene, context.log))
    plan = _point_to_point if command == 'PTP' else _along_curve
    motion = _slow_enough(
        context, request, validity, budget,
        lambda slowed: plan(context, slowed, scene, validity, goal, start, budget))
    budget.check('ValidateSolution')
    fault = first_fault(motion, validity, context.settings.fine_step)
    if fault:
        raise PlanningError(
            MoveItErrorCode.INVALID_MOTION_PLAN,
            f'{command} does not plan around obstacles: {fault}; give another goal, or plan with '
            'an OMPL pipeline', 'ValidateSolution', fault.contacts)
    return motion.trajectory(validity.joint_names), path_length(motion.positions)


def _check_context(context: PlanningContext, request: MotionPlanRequest) -> None:
    """Refuse requests for which there is no command, or no group with a solver."""
    group, fault = request.group_name, ''
    if request.planner_id not in COMMANDS:
        fault = (f"planner_id '{request.planner_id}' is not a command of {PILZ}; "
                 f'{nearest(request.planner_id, COMMANDS)} known: {", ".join(COMMANDS)}')
    elif group not in context.model.robot.semantic.groups:
        known = context.model.robot.semantic.groups
        fault = f"planning group '{group}' is not known; known: {', '.join(known) or 'none'}"
    elif context.solver_tip(group) is None:
        fault = (f"group '{group}' has no kinematics solver, which {PILZ} needs; only chains "
                 'with a kinematics_solver in kinematics.yaml have a solver')
    if fault:
        raise PlanningError(MoveItErrorCode.PLANNING_FAILED, fault, PILZ)


def _check_request(context: PlanningContext, request: MotionPlanRequest) -> None:
    """Refuse scaling factors outside (0.0001, 1], and a group that does not start at rest."""
    for name in ('max_velocity_scaling_factor', 'max_acceleration_scaling_factor'):
        value = getattr(request, name)
        if not _LEAST_SCALING < value <= 1.0:
            raise PlanningError(
                MoveItErrorCode.INVALID_MOTION_PLAN,
                f'{name} is {value:g}; PTP, LIN and CIRC take a number above 0.0001, up to 1',
                PILZ)
    start = request.start_state
    names = context.model.robot.semantic.groups[request.group_name].active_joints
    for name, velocity in zip(start.joint_names, start.velocities, strict=False):
        if name in names and not abs(velocity) < _LARGEST_START_VELOCITY:
            raise PlanningError(
                MoveItErrorCode.INVALID_ROBOT_STATE,
                f"joint '{name}' has the velocity {velocity:g} in the start state; PTP, LIN and "
                'CIRC start at rest', PILZ)


def _point_to_point(
    context: PlanningContext, request: MotionPlanRequest, scene: PlanningScene,
    validity: StateValidity, goal: CommandGoal, start: Vector, budget: Budget,
) -> QuinticMotion:
    """Return the motion of all joints together."""
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
    budget: Budget, plan: Callable[[MotionPlanRequest], QuinticMotion],
) -> QuinticMotion:
    """
    Return a motion that keeps the request's ``max_cartesian_speed``.

    It is planned with a lower profile, so that its points are :data:`SAMPLING_TIME` apart as
    those of all commands: motions that are sampled alike can be blended.
    """
    motion = plan(request)
    limit = link_speed_limit(context.model, validity, request)
    while limit is not None and len(motion.times) > 1:
        times = np.linspace(0.0, motion.duration, 8 * len(motion.times))
        positions = motion.sample(times)
        slopes = np.gradient(positions, times, axis=0)
        share = float(np.min(limit(positions, slopes)))
        if share >= 1.0:
            break
        budget.check(request.planner_id)
        factor = share / 1.01
        velocity = request.max_velocity_scaling_factor * factor
        if velocity <= _LEAST_SCALING:
            raise PlanningError(
                MoveItErrorCode.INVALID_MOTION_PLAN,
                f'max_cartesian_speed is {request.max_cartesian_speed:g} m/s; PTP, LIN and CIRC '
                'cannot be slowed to less than 0.0001 of the limits', PILZ)
        request = replace(
            request, max_velocity_scaling_factor=velocity,
            max_acceleration_scaling_factor=request.max_acceleration_scaling_factor * factor**2)
        motion = plan(request)
    return motion


_SOURCE = 'Pilz goal'


class CommandGoal:
    """
    Where a command ends.

    :param context: the robot and its solvers.
    :param request: a request for a group that has a solver.
    :param present: the monitored scene; frames are where they are in it.
    :param scene: its state is the start.
    :raises PlanningError: INVALID_GOAL_CONSTRAINTS where there is not one valid goal;
        NO_IK_SOLUTION for a link that the solver does not position.
    """

    def __init__(
        self, context: PlanningContext, request: MotionPlanRequest, present: PlanningScene,
        scene: PlanningScene,
    ) -> None:
        self._context = context
        self._group = request.group_name
        self._present, self._scene = present, scene
        if len(request.goal_constraints) != 1:
            raise _error(f'the request has {len(request.goal_constraints)} goal constraints; PTP, '
                         'LIN and CIRC take exactly one')
        self._goal = goal = request.goal_constraints[0]
        posed = len(goal.position_constraints) == len(goal.orientation_constraints) == 1
        if posed == bool(goal.joint_constraints):
            raise _error('the goal has to be either joint constraints, or one position and one '
                         'orientation constraint')
        if posed:
            self._check_pose()
        else:
            self._check_joints()

    def _check_joints(self) -> None:
        model = self._context.model
        names = model.robot.semantic.groups[self._group].joints
        for each in self._goal.joint_constraints:
            if each.joint_name not in names:
                raise _error(f"joint '{each.joint_name}' of the goal is not in group "
                             f"'{self._group}'; it has {', '.join(names)}")
            index = model.index(each.joint_name)
            low, high = float(model.lower[index]), float(model.upper[index])
            if not low <= each.position <= high:
                raise _error(f"goal {each.position:.4f} of joint '{each.joint_name}' is outside "
                             f'its limits {low:.4f} .. {high:.4f}')

    def _check_pose(self) -> None:
        position, orientation = self._constraints
        if not position.link_name or position.link_name != orientation.link_name:
            raise _error(f"the goal's position is for link '{position.link_name}', its "
                         f"orientation for '{orientation.link_name}'; both have to name the same "
                         'link')
        self._context.solver_target(self._scene, self._group, position.link_name)
        if not position.poses:
            raise _error(f"the position of '{position.link_name}' has no region with a pose")

    @property
    def _constraints(self) -> tuple[PositionConstraint, OrientationConstraint]:
        return self._goal.position_constraints[0], self._goal.orientation_constraints[0]

    @property
    def posed(self) -> bool:
        """Whether the goal is a pose."""
        return not self._goal.joint_constraints

    def check_all_joints(self) -> None:
        """Refuse joint goals that do not name every joint of the group."""
        expected = len(self._context.model.group_indices(self._group))
        if not self.posed and len(self._goal.joint_constraints) != expected:
            raise _error(f'the goal has {len(self._goal.joint_constraints)} joint constraints, '
                         f"group '{self._group}' has {expected} joints; LIN and CIRC take one "
                         'for every joint')

    def joint_state(self) -> Vector:
        """
        Return the full robot state (n,) of the goal; of a pose, a state without self-collision.

        :raises PlanningError: NO_IK_SOLUTION.
        """
        if self.posed:
            return self._solved()
        return self._context.model.vector(
            {each.joint_name: each.position for each in self._goal.joint_constraints},
            self._scene.q)

    def frame(self, auxiliary_link: str = '') -> Frame:
        """
        Return the frame that moves: the goal's link.

        :param auxiliary_link: for joint goals; '' for the tip of the group's solver.
        """
        name = self._constraints[0].link_name if self.posed else auxiliary_link
        return self._context.solver_target(self._scene, self._group, name)

    def pose(self) -> Matrix:
        """Return the pose (4, 4) of a pose goal's link in the model frame."""
        position, orientation = self._constraints
        named = bool(position.frame_id and orientation.frame_id)
        base = self._present.frame_pose(position.frame_id if named else '')
        turned = self._turned()
        point = position.poses[0][:3, 3] - turned @ np.asarray(position.target_point_offset)
        pose: Matrix = base @ pose_from_parts(point, turned)
        if not is_place(pose):
            raise _error(f"the pose of '{position.link_name}' has a number that is not finite or "
                         'too large')
        return pose

    def _turned(self) -> Matrix:
        """Return the goal's rotation (3, 3) in its own frame; quaternions are normalized."""
        quat = np.asarray(self._constraints[1].quat_xyzw, dtype=np.float64)
        length = float(np.linalg.norm(quat))
        if not length > 0.0:
            raise _error(f'the goal orientation {tuple(quat)} is not a quaternion')
        return matrix_from_quat_xyzw(quat / length)

    def _solved(self) -> Vector:
        context, group = self._context, self._group
        frame, pose = self.frame(), self.pose()
        result = context.inverse(group).solve(
            [IKTarget(frame.link, pose, frame.offset)], self._scene.q,
            IKOptions(self._keeps_off_itself))
        if result.q is None:
            raise PlanningError(
                MoveItErrorCode.NO_IK_SOLUTION,
                f"no joint positions put '{self._constraints[0].link_name}' at "
                f'{np.round(pose[:3, 3], 4).tolist()} m in the model frame: {result.message}',
                _SOURCE)
        return result.q

    def _keeps_off_itself(self, q: Vector) -> bool:
        """Return whether a state (n,) has no contact between links and what they carry."""
        return not self._context.checker.in_collision(q, self._group) or not any(
            BodyType.WORLD_OBJECT not in (contact.type1, contact.type2)
            for contact in self._context.checker.contacts(q, self._group))

    def auxiliary_point(self, constraints: Constraints) -> Vector:
        """
        Return the centre or interim point (3,) [m] of an arc in the model frame.

        The offset of a pose goal shifts it too.
        """
        helper = constraints.position_constraints[0]
        base = self._present.frame_pose(helper.frame_id)
        point: Vector = (base @ helper.poses[0])[:3, 3]
        if self.posed:
            point = point - self._turned() @ np.asarray(
                self._constraints[0].target_point_offset)
        if not is_place(point):
            raise _error('the auxiliary point has a number that is not finite or too large')
        return point


def _error(text: str) -> PlanningError:
    return PlanningError(MoveItErrorCode.INVALID_GOAL_CONSTRAINTS, text, _SOURCE)
