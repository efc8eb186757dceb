# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Several motions that follow each other, blended where that is asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.constraint_terms import Frame
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.pilz.joint_sampling import JointSampler
from armsim_ros.planning.request import MotionPlanRequest, MotionPlanResponse
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import StartState
from armsim_ros.planning.timing.path_timing import first_fault
from armsim_ros.quintic_motion import QuinticMotion
from armsim_ros.trajectory import JointTrajectory

SOURCE = 'sequence'


@dataclass(frozen=True, slots=True)
class SequenceItem:
    """
    A motion of a sequence.

    :param blend_radius: within this distance [m] of its goal the next motion may begin; 0 is a
        stop.
    """

    request: MotionPlanRequest
    blend_radius: float = 0.0


@dataclass(frozen=True, slots=True)
class SequenceResponse:
    """
    The answer to a sequence.

    :param trajectories: for each run of motions of the same group; empty unless all succeeded.
    :param requests: the first request of each trajectory.
    :param start: joint -> position [rad or m] of all movable joints.
    :param planning_time: [s].
    :param plans: of the single motions, before they are joined, up to the first that failed.
    """

    error_code: MoveItErrorCode = MoveItErrorCode.SUCCESS
    message: str = ''
    source: str = ''
    trajectories: tuple[JointTrajectory, ...] = ()
    requests: tuple[MotionPlanRequest, ...] = ()
    start: Mapping[str, float] = field(default_factory=dict)
    planning_time: float = 0.0
    plans: tuple[MotionPlanResponse, ...] = ()


@dataclass(slots=True)
class _Run:
    """
    Motions of a group, joined so far.

    :param done: what no blend changes any more, None where there is nothing yet.
    :param tail: the motion that the next may be blended with.
    """

    request: MotionPlanRequest
    names: tuple[str, ...]
    tail: QuinticMotion
    done: QuinticMotion | None = None

    def append(self, motion: QuinticMotion) -> None:
        """Add a motion after a stop."""
        self.done, self.tail = self.motion, motion

    @property
    def motion(self) -> QuinticMotion:
        """All motions joined."""
        return self.tail if self.done is None else _appended(self.done, self.tail)


def plan_items(
    items: Sequence[SequenceItem], pipeline: str,
    plan: Callable[[MotionPlanRequest], MotionPlanResponse],
) -> tuple[MotionPlanRequest, ...]:
    """
    Plan each motion from where its predecessor ends, with what the first carries.

    :param pipeline: plans all motions.
    :param plan: plans a motion.
    :returns: the requests with their start states.
    :raises PlanningError: for radii and start states that are not allowed; PREEMPTED where a
        motion is cancelled, FAILURE where it has no plan for another reason.
    """
    _check_radii(items)
    _check_start_states(items)
    requests: list[MotionPlanRequest] = []
    reached: dict[str, float] = {}
    for number, item in enumerate(items):
        request = replace(item.request, pipeline_id=pipeline)
        if requests:
            request = replace(request, start_state=_start(
                request.start_state, reached, requests[0].start_state))
        answer = plan(request)
        if not answer.success:
            cancelled = answer.error_code == MoveItErrorCode.PREEMPTED
            raise PlanningError(
                MoveItErrorCode.PREEMPTED if cancelled else MoveItErrorCode.FAILURE,
                f'motion {number}: {answer.error_code.name}: {answer.message}', answer.source)
        if not requests:
            reached.update(answer.trajectory_start)
        trajectory = answer.trajectory
        reached.update(zip(trajectory.joint_names, trajectory.positions[-1].tolist(), strict=True))
        requests.append(request)
    return tuple(requests)


def join(
    context: PlanningContext, items: Sequence[SequenceItem],
    requests: Sequence[MotionPlanRequest], answers: Sequence[MotionPlanResponse],
    scene: PlanningScene,
) -> tuple[_Run, ...]:
    """
    Return the motions of each run of the same group, joined.

    :raises PlanningError: INVALID_MOTION_PLAN for spheres that overlap and blends that hit
        something; FAILURE for blends that are not possible or too fast.
    """
    radii = _usable_radii(context, items)
    _check_overlap(context, radii, requests, answers, scene)
    runs: list[_Run] = []
    for number, (request, answer) in enumerate(zip(requests, answers, strict=True)):
        trajectory = answer.trajectory
        motion = QuinticMotion.of(trajectory)
        if not number or runs[-1].request.group_name != request.group_name:
            runs.append(_Run(request, trajectory.joint_names, motion))
        elif radii[number - 1] > 0.0:
            started = scene.with_start_state(
                request.start_state, strict=context.settings.strict_start_state)
            _blend(context, runs[-1], motion, radii[number - 1], started, number)
        else:
            runs[-1].append(motion)
    return tuple(runs)


def _appended(first: QuinticMotion, second: QuinticMotion) -> QuinticMotion:
    """Return two motions joined; a first point of the second at the first's end is left out."""
    again = second.times[0] <= 0.0 or meet(first, second)
    return first.joined(second.part(1) if again else second, first.duration)


def _blend(
    context: PlanningContext, run: _Run, motion: QuinticMotion, radius: float,
    scene: PlanningScene, number: int,
) -> None:
    """Blend a motion into a run."""
    group = run.request.group_name
    tip = context.solver_tip(group)
    assert tip is not None
    validity = context.validity(scene, group)
    try:
        before, blend, rest = Blender(context, validity, tip).blended(run.tail, motion, radius)
    except PlanningError as error:
        raise PlanningError(
            MoveItErrorCode.FAILURE, f'the blend before motion {number}: {error}', BLEND
        ) from None
    fault = first_fault(
        _appended(_appended(before, blend), rest), validity, context.settings.fine_step,
        since=before.duration)
    if fault:
        raise _error(f'the blend before motion {number} is not valid {fault}; give a smaller '
                     'blend_radius')
    run.done = before if run.done is None else _appended(run.done, before)
    run.done, run.tail = _appended(run.done, blend), rest


def _check_radii(items: Sequence[SequenceItem]) -> None:
    for number, item in enumerate(items):
        if not item.blend_radius >= 0.0:
            raise _error(f'the blend_radius of motion {number} is {item.blend_radius:g}; it '
                         'has to be a length in metres, 0 for a stop')
    if items[-1].blend_radius:
        raise _error(f'the blend_radius of the last motion is {items[-1].blend_radius:g}; there '
                     'is no motion to blend with, give 0')


def _check_start_states(items: Sequence[SequenceItem]) -> None:
    groups: set[str] = set()
    for number, item in enumerate(items):
        given, group = item.request.start_state, item.request.group_name
        if group in groups and (given.joint_names or given.positions or given.velocities):
            raise PlanningError(
                MoveItErrorCode.INVALID_ROBOT_STATE,
                f"motion {number} gives a start state, but group '{group}' begins where an "
                'earlier motion has ended; leave it empty', SOURCE)
        groups.add(group)


def _start(given: StartState, reached: Mapping[str, float], first: StartState) -> StartState:
    """Return the start state of a motion: where the motions before it end."""
    positions = {**reached, **dict(zip(given.joint_names, given.positions, strict=False))}
    return replace(
        given, joint_names=tuple(positions), positions=tuple(positions.values()), is_diff=True,
        velocities=(), attached_objects=(*first.attached_objects, *given.attached_objects))


def _usable_radii(context: PlanningContext, items: Sequence[SequenceItem]) -> list[float]:
    """Return the radii; where the group changes or has no solver there is a stop."""
    radii = [item.blend_radius for item in items]
    for number, (item, following) in enumerate(pairwise(items)):
        group = item.request.group_name
        if not item.blend_radius:
            continue
        if group != following.request.group_name or context.solver_tip(group) is None:
            radii[number] = 0.0
            context.log.warning(
                f"motion {number} of group '{group}' ends with a stop, not with a blend: the "
                'next motion is of another group, or the group has no kinematics solver')
    return radii


def _check_overlap(
    context: PlanningContext, radii: Sequence[float], requests: Sequence[MotionPlanRequest],
    answers: Sequence[MotionPlanResponse], scene: PlanningScene,
) -> None:
    model = context.model
    for number in range(len(answers) - 2):
        group = requests[number].group_name
        both = radii[number] + radii[number + 1]
        tip = context.solver_tip(group)
        if tip is None or not both or group != requests[number + 1].group_name:
            continue
        q = scene.with_start_state(requests[number].start_state).q
        first, second = (
            model.link_pose(model.insert(q, group, answer.trajectory.positions[-1]), tip)[:3, 3]
            for answer in answers[number:number + 2])
        distance = float(np.linalg.norm(first - second))
        if distance <= both:
            raise _error(f'the blends after motion {number} and after motion {number + 1} '
                         f'overlap: their radii {radii[number]:g} and {radii[number + 1]:g} m are '
                         f'not less than the {distance:.4f} m between the ends of the motions')


def _error(text: str) -> PlanningError:
    return PlanningError(MoveItErrorCode.INVALID_MOTION_PLAN, text, SOURCE)


BLEND = 'blend'
_SAME = 1e-4
"""Largest difference of states [rad or m, and per s], and of sampling times [s]."""


class Blender:
    """
    Blends motions of a group.

    :param context: the robot and its solvers.
    :param validity: of the group.
    :param tip: the tip of the group's solver.
    """

    def __init__(self, context: PlanningContext, validity: StateValidity, tip: str) -> None:
        self._model = context.model
        self._validity, self._tip = validity, tip
        self._sampler = JointSampler(
            context, validity, Frame(tip, np.eye(4)), BLEND, validity.poll)

    def poses(self, motion: QuinticMotion) -> Matrix:
        """Return where the tip is at every point of a motion (k, 4, 4)."""
        return np.array([
            self._model.link_pose(self._validity.full(values), self._tip)
            for values in motion.positions])

    def blended(
        self, first: QuinticMotion, second: QuinticMotion, radius: float
    ) -> tuple[QuinticMotion, QuinticMotion, QuinticMotion]:
        """
        Return what is left of the first motion, the blend, and what is left of the second.

        The tip leaves the first motion where it enters the sphere and joins the second where it
        leaves the sphere; between, its poses change between both motions by a polynomial of degree
        five. Times of blend and rest count from the end of the part before.

        :param radius: of the sphere [m].
        :raises PlanningError: FAILURE where the motions cannot be blended; NO_IK_SOLUTION or
            PLANNING_FAILED where the joints cannot follow.
        """
        step = _sampling_time(first, second)
        _check_meeting(first, second)
        ways = self.poses(first), self.poses(second)
        meeting = ways[0][-1, :3, 3]
        near = [np.linalg.norm(way[:, :3, 3] - meeting, axis=1) for way in ways]
        enters = _crossing(near[0][::-1], radius, 'first')
        enter = len(near[0]) - 1 - enters
        leave = _crossing(near[1], radius, 'second')
        align = len(near[0]) - leave - 1 if enters > leave else enter
        count = leave + align - enter + 1
        poses = []
        for k in range(count):
            a = ways[0][min(enter + k, len(ways[0]) - 1)]
            b = ways[1][max(enter + k - align, 0)]
            poses.append((step * (k + 1), _between(a, b, (k + 1) / count)))
        blend = self._sampler.followed(
            poses, first.positions[enter - 1], first.velocities[enter - 1], step)
        rest = second.part(leave + 1)
        return first.part(0, enter), blend, QuinticMotion(
            rest.times - rest.times[0] + step, rest.positions, rest.velocities,
            rest.accelerations)


def _sampling_time(first: QuinticMotion, second: QuinticMotion) -> float:
    """Return the time [s] between the points of both motions but their last ones."""
    intervals: list[Vector] = [np.diff(motion.times)[:-1] for motion in (first, second)]
    every: NDArray[np.float64] = np.concatenate(intervals)
    if not len(every):
        raise _no_blend('both motions have too few points')
    if np.abs(every - every[0]).max() > _SAME:
        raise _no_blend('the motions are not sampled at the same even times; blend motions of '
                        'PTP, LIN and CIRC')
    return float(every[0])


def meet(first: QuinticMotion, second: QuinticMotion) -> bool:
    """Return whether a motion ends in the state in which another starts."""
    return all(
        float(np.linalg.norm(a[-1] - b[0])) <= _SAME for a, b in (
            (first.positions, second.positions), (first.velocities, second.velocities),
            (first.accelerations, second.accelerations)))


def _check_meeting(first: QuinticMotion, second: QuinticMotion) -> None:
    if not meet(first, second):
        raise _no_blend('the second motion does not start where the first one ends')
    if any(float(np.linalg.norm(each)) > _SAME
           for each in (first.velocities[-1], first.accelerations[-1])):
        raise _no_blend('the motions do not rest where they meet')


def _crossing(near: Vector, radius: float, which: str) -> int:
    """Return the last point before the distances (k,) from the meeting point pass the radius."""
    crossing = np.flatnonzero((near[:-1] <= radius) & (near[1:] >= radius))
    if not len(crossing):
        raise _no_blend(f'the {which} motion lies within the blend radius {radius:g} m of the '
                        'point where both meet; give a smaller blend_radius')
    return int(crossing[0])


def _between(first: Matrix, second: Matrix, share: float) -> Matrix:
    """Return the pose (4, 4) between two, by a polynomial of a share 0..1."""
    weight = 6.0 * share**5 - 15.0 * share**4 + 10.0 * share**3
    pose = np.eye(4)
    pose[:3, 3] = first[:3, 3] + weight * (second[:3, 3] - first[:3, 3])
    turn = pin.log3(first[:3, :3].T @ second[:3, :3])
    pose[:3, :3] = first[:3, :3] @ pin.exp3(weight * turn)
    return pose


def _no_blend(text: str) -> PlanningError:
    return PlanningError(MoveItErrorCode.FAILURE, f'blending failed: {text}', BLEND)
