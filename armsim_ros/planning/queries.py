# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Questions about single states: are they valid, and which of them reaches a pose."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.kinematics.inverse import IKOptions, IKTarget
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.planning.constraint_terms import ConstraintResult
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.request import Constraints, is_place
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import StartState
from armsim_ros.planning.timing.path_timing import first_fault
from armsim_ros.quintic_motion import QuinticMotion
from armsim_ros.trajectory import JointTrajectory

DEFAULT_IK_TIMEOUT = 0.05
"""Time for inverse kinematics [s] where the request gives none, and kinematics.yaml no more."""

LONGEST_IK_TIMEOUT = 10.0
"""The most that a request gets [s]: a service cannot be cancelled."""


@dataclass(frozen=True, slots=True)
class StateReport:
    """
    Whether a state is free and keeps constraints; joint limits are not asked.

    :param contacts: a contact per colliding pair.
    :param constraint_results: of all given constraints: joints, positions, orientations.
    :param message: what is wrong, '' where nothing is.
    """

    valid: bool
    contacts: tuple[Contact, ...] = ()
    constraint_results: tuple[ConstraintResult, ...] = ()
    message: str = ''


@dataclass(frozen=True, slots=True, eq=False)
class LinkPose:
    """
    A requested pose of a link.

    :param link_name: '' for the solver's tip; attached objects and subframes too.
    :param pose: (4, 4) in ``frame_id``.
    :param frame_id: a frame of TF, where it is now; '' for the model frame.
    """

    link_name: str
    pose: Matrix
    frame_id: str = ''


@dataclass(frozen=True, slots=True, eq=False)
class IKRequest:
    """
    Poses to find joint positions for.

    :param start_state: first guess, and the other joints.
    :param targets: a single link fixed to the tip of the group's solver; or a link for each
        subgroup, in their order.
    :param timeout: [s]; the group's own where that is longer.
    """

    group_name: str
    targets: tuple[LinkPose, ...]
    start_state: StartState = field(default_factory=StartState)
    constraints: Constraints = field(default_factory=Constraints)
    avoid_collisions: bool = False
    timeout: float = 0.0


@dataclass(frozen=True, slots=True)
class IKResponse:
    """
    The answer to an :class:`IKRequest`.

    :param positions: joint -> [rad or m] of all movable joints; empty on failure.
    """

    error_code: MoveItErrorCode
    message: str = ''
    positions: Mapping[str, float] = field(default_factory=dict)


def check_state(
    context: PlanningContext, scene: PlanningScene, q: Vector, group: str,
    constraints: Constraints,
) -> StateReport:
    """
    Return whether a full robot state (n,) is free and keeps constraints.

    :param group: '' for all links of the robot, and so is an unknown group, with a warning.
    """
    known = context.model.robot.semantic.groups
    if group and group not in known:
        context.log.warning(
            f"planning group '{group}' is not known; known: {', '.join(known)}; all links are "
            'checked')
    context.checker.use(scene)
    contacts = tuple(context.checker.contacts(q, group if group in known else None))
    made = ConstraintSet(constraints, scene, context.log)
    results = tuple(made.evaluate(q))
    reasons = [
        *(str(contact) for contact in contacts),
        *(result.text for result in results if not result.satisfied),
    ]
    return StateReport(not reasons, contacts, results, '; '.join(reasons))


def solve_ik(
    context: PlanningContext, request: IKRequest, scene: PlanningScene, clock: Callable[[], float]
) -> Generator[None, None, IKResponse]:
    """
    Return joint positions that put links where they are wanted, or why there are none.

    It yields between tries; the collision checker may serve others meanwhile.
    """
    try:
        return (yield from _solve_ik(context, request, scene, clock))
    except PlanningError as error:
        context.log.error(f'compute_ik: {error}')
        return IKResponse(MoveItErrorCode(error.code), str(error))


def _solve_ik(
    context: PlanningContext, request: IKRequest, scene: PlanningScene, clock: Callable[[], float]
) -> Generator[None, None, IKResponse]:
    group = request.group_name
    model = context.model
    inverse = context.inverse(group)
    poses = [scene.transform(target.frame_id) @ target.pose for target in request.targets]
    scene = context.started(scene, request.start_state)
    targets = _targets(context, scene, request, poses)
    kept = ConstraintSet(request.constraints, scene, context.log)
    colliding: list[Vector] = []

    def valid(q: Vector) -> bool:
        context.checker.use(scene)
        if request.avoid_collisions and context.checker.in_collision(q, group):
            colliding.append(q)
            return False
        return kept.satisfied(q)

    inverse.prepare(targets)
    result = yield from inverse.tries(
        targets, scene.q, IKOptions(
            is_valid=valid, rng=np.random.default_rng(max(context.settings.seed, 0)),
            clock=clock, deadline=clock() + _ik_timeout(context, request)))
    if result.q is not None:
        return IKResponse(MoveItErrorCode.SUCCESS, scene.refused, model.positions(result.q))
    message = result.message
    if colliding:
        context.checker.use(scene)
        pairs = context.checker.contacts(colliding[0], group)
        message += f'; the first collides: {"; ".join(str(pair) for pair in pairs[:3])}'
    context.log.info(f'compute_ik: {message}')
    return IKResponse(MoveItErrorCode.NO_IK_SOLUTION, message)


def _ik_timeout(context: PlanningContext, request: IKRequest) -> float:
    """Return the time for inverse kinematics [s]."""
    default = max(
        context.settings.ik_timeouts.get(request.group_name, 0.0), DEFAULT_IK_TIMEOUT)
    if not request.timeout > default:
        return default
    if request.timeout > LONGEST_IK_TIMEOUT:
        context.log.warning(
            f'compute_ik: a timeout of {request.timeout:g} s is asked for; '
            f'using {LONGEST_IK_TIMEOUT:g} s')
    return min(request.timeout, LONGEST_IK_TIMEOUT)


def _targets(
    context: PlanningContext, scene: PlanningScene, request: IKRequest, poses: Sequence[Matrix]
) -> list[IKTarget]:
    """Return the targets of the group's solver, or of the solvers of its subgroups."""
    groups: tuple[str, ...] = (request.group_name,)
    if not poses:
        raise PlanningError(MoveItErrorCode.NO_IK_SOLUTION, 'the request has no pose')
    if len(poses) > 1:
        groups = context.model.robot.semantic.groups[request.group_name].subgroups
        if len(groups) != len(poses):
            raise PlanningError(
                MoveItErrorCode.NO_IK_SOLUTION,
                f"{len(poses)} poses are given for group '{request.group_name}', which consists "
                f'of {len(groups)} subgroups; give one pose, or one for each subgroup in their '
                f'order: {", ".join(groups) or "none"}')
    targets = []
    for group, target, pose in zip(groups, request.targets, poses, strict=True):
        frame = context.solver_target(scene, group, target.link_name)
        if not is_place(pose):
            raise PlanningError(
                MoveItErrorCode.NO_IK_SOLUTION,
                f"the pose for '{target.link_name or frame.link}' has a number that is not "
                'finite or too large')
        targets.append(IKTarget(frame.link, pose, frame.offset))
    return targets


def path_fault(
    context: PlanningContext, trajectory: JointTrajectory, from_time: float,
    scene: PlanningScene, group: str,
) -> str:
    """
    Return where the rest of a trajectory collides in a scene, links unpadded; '' for nowhere.

    :param trajectory: with velocities and accelerations.
    :param from_time: [s] of the trajectory; what comes before is not checked.
    :param group: planning group whose motion it is.
    """
    validity = context.validity(scene.unpadded(), group)
    start = context.model.extract(scene.q, group)
    motion = QuinticMotion.of(trajectory, dict(zip(validity.joint_names, start, strict=True)))
    fault = first_fault(
        motion, validity, context.settings.fine_step, since=max(from_time, 0.0))
    return str(fault or '')
