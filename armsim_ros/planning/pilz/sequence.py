# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Several motions that follow each other, blended where that is asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.pilz.blending import Blender, meet
from armsim_ros.planning.pilz.blending import SOURCE as BLEND
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
    :param plans: of the single motions, before they are joined.
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
) -> tuple[tuple[MotionPlanRequest, ...], tuple[MotionPlanResponse, ...]]:
    """
    Plan each motion from where its predecessor ends, with what the first carries.

    :param pipeline: plans all motions.
    :returns: the requests with their start states, and the answers.
    :raises PlanningError: for radii and start states that are not allowed; FAILURE where a
        motion has no plan.
    """
    _check_radii(items)
    _check_start_states(items)
    requests: list[MotionPlanRequest] = []
    answers: list[MotionPlanResponse] = []
    reached: dict[str, float] = {}
    for number, item in enumerate(items):
        request = replace(item.request, pipeline_id=pipeline)
        if answers:
            request = replace(request, start_state=_start(
                request.start_state, reached, requests[0].start_state))
        answer = plan(request)
        if not answer.success:
            raise PlanningError(
                MoveItErrorCode.FAILURE,
                f'motion {number}: {answer.error_code.name}: {answer.message}', answer.source)
        if not answers:
            reached.update(answer.trajectory_start)
        trajectory = answer.trajectory
        reached.update(zip(trajectory.joint_names, trajectory.positions[-1].tolist(), strict=True))
        requests.append(request)
        answers.append(answer)
    return tuple(requests), tuple(answers)


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
                'earlier motion has ended; leave it empty', SOURCE,
            )
        groups.add(group)


def _start(given: StartState, reached: Mapping[str, float], first: StartState) -> StartState:
    """Return the start state of a motion: where the motions before it end."""
    positions = {**reached, **dict(zip(given.joint_names, given.positions, strict=False))}
    return replace(
        given, joint_names=tuple(positions), positions=tuple(positions.values()), is_diff=True,
        velocities=(), attached_objects=(*first.attached_objects, *given.attached_objects),
    )


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
