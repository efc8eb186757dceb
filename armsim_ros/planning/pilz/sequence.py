# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Several motions that follow each other, blended where that is asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.pilz.commands import COMMANDS, PIPELINE, SAMPLING_TIME, worst_excess
from armsim_ros.planning.request import Constraints, MotionPlanRequest, MotionPlanResponse
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import StartState
from armsim_ros.planning.timing.path_timing import first_fault
from armsim_ros.quintic_motion import QuinticMotion
from armsim_ros.trajectory import JointTrajectory

SOURCE = 'sequence'

BLEND_STEP = SAMPLING_TIME / 4.0
"""Largest time [s] between two points of a blend."""


Place = Callable[[Vector], Vector]
"""Joint values (n,) -> where the tool is (3,) [m]."""

_LOOK = 0.01
"""Time [s] between two looks at the distance from the meeting point."""
_HALVINGS = 30
_POINTS = 8
_TIME_RESOLUTION = 1e-6


@dataclass(frozen=True, slots=True)
class SequenceItem:
    """
    One motion of a sequence.

    :param blend_radius: within this distance [m] of its goal the next motion may begin; 0 is a
        stop.
    """

    request: MotionPlanRequest
    blend_radius: float = 0.0


@dataclass(frozen=True, slots=True)
class SequenceResponse:
    """
    The answer to a sequence.

    :param trajectories: one for each run of motions of the same group; empty unless all succeeded.
    :param requests: the first request of each trajectory.
    :param start: joint -> position [rad or m] of all movable joints.
    :param planning_time: [s].
    """

    error_code: MoveItErrorCode = MoveItErrorCode.SUCCESS
    message: str = ''
    source: str = ''
    trajectories: tuple[JointTrajectory, ...] = ()
    requests: tuple[MotionPlanRequest, ...] = ()
    start: Mapping[str, float] = field(default_factory=dict)
    planning_time: float = 0.0


@dataclass(slots=True)
class _Run:
    """
    Motions of one group, joined so far.

    :param changeable: time [s] from which on the motion may still be blended.
    """

    request: MotionPlanRequest
    names: tuple[str, ...]
    motion: QuinticMotion
    changeable: float = 0.0


def plan_items(
    items: Sequence[SequenceItem], plan: Callable[[MotionPlanRequest], MotionPlanResponse]
) -> tuple[tuple[MotionPlanRequest, ...], tuple[MotionPlanResponse, ...]]:
    """
    Plan each motion from where the one before it ends, with what the first one carries.

    :returns: the requests with their start states, and the answers.
    :raises PlanningError: for radii and start states that cannot be; else the code of the first
        motion that has no plan.
    """
    _check_radii(items)
    requests: list[MotionPlanRequest] = []
    answers: list[MotionPlanResponse] = []
    reached: dict[str, float] = {}
    groups: set[str] = set()
    for number, item in enumerate(items):
        request = _in_pipeline(item.request)
        if answers:
            start = _start(number, request, reached, groups)
            carried = requests[0].start_state.attached_objects
            request = replace(request, start_state=replace(
                start, attached_objects=(*carried, *start.attached_objects)))
        groups.add(request.group_name)
        answer = plan(request)
        if not answer.success:
            raise PlanningError(
                answer.error_code, f'motion {number}: {answer.message}', answer.source
            )
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
    Return the motions of each run of one group as one.

    :raises PlanningError: INVALID_MOTION_PLAN for spheres that overlap and blends that hit
        something; FAILURE for blends that cannot be or are too fast.
    """
    runs: list[_Run] = []
    radius = 0.0
    ends: list[Vector] = []
    for number, (request, answer) in enumerate(zip(requests, answers, strict=True)):
        trajectory, group = answer.trajectory, request.group_name
        started = scene.with_start_state(request.start_state)
        place = _place(context, group, started.q)
        follows = bool(runs) and runs[-1].request.group_name == group
        if radius and not follows:
            context.log.warning(
                f"motion {number} of group '{group}' begins after a stop, not with a blend: the "
                'motion before it is of another group'
            )
        ends = [*(ends if follows else ()), place(trajectory.positions[-1])]
        if len(trajectory) > 1:
            motion = QuinticMotion.of(trajectory)
            if not follows:
                runs.append(_Run(request, trajectory.joint_names, motion))
            elif radius:
                _check_overlap(number, ends, radius, items[number].blend_radius)
                run = runs[-1]
                run.motion, run.changeable = blended(
                    run.motion, motion, place, radius, BLEND_STEP, run.changeable
                )
                _check_blend(context, run, started, number)
            else:
                run = runs[-1]
                run.changeable = run.motion.duration
                run.motion = run.motion.then(motion)
        radius = items[number].blend_radius
    return tuple(runs)


def _place(context: PlanningContext, group: str, q: Vector) -> Place:
    model, tip = context.model, context.tip(group)

    def place(values: Vector) -> Vector:
        point: Vector = model.link_pose(model.insert(q, group, values), tip)[:3, 3]
        return point

    return place


def _in_pipeline(request: MotionPlanRequest) -> MotionPlanRequest:
    """Return a request of a command in the pipeline of the commands."""
    if not request.pipeline_id and request.planner_id in COMMANDS:
        return replace(request, pipeline_id=PIPELINE)
    return request


def _check_radii(items: Sequence[SequenceItem]) -> None:
    for number, item in enumerate(items):
        if not 0.0 <= item.blend_radius < np.inf:
            raise _error(f'the blend_radius of motion {number} is {item.blend_radius:g}; it '
                         'takes a length in metres, 0 for a stop')
    if items[-1].blend_radius:
        raise _error(f'the blend_radius of the last motion is {items[-1].blend_radius:g}; there '
                     'is nothing to blend with, give 0')


def _start(
    number: int, request: MotionPlanRequest, reached: Mapping[str, float], groups: set[str]
) -> StartState:
    given = request.start_state
    if given.joint_names and request.group_name in groups:
        raise PlanningError(
            MoveItErrorCode.INVALID_ROBOT_STATE,
            f"motion {number} gives a start state, but group '{request.group_name}' begins where "
            'an earlier motion has ended; leave it empty', SOURCE,
        )
    positions = {**reached, **dict(zip(given.joint_names, given.positions, strict=False))}
    return replace(
        given, joint_names=tuple(positions), positions=tuple(positions.values()), is_diff=True,
        velocities=(),
    )


def _check_overlap(number: int, ends: Sequence[Vector], before: float, after: float) -> None:
    distance = float(np.linalg.norm(ends[-1] - ends[-2]))
    if before + after > distance:
        raise _error(f'the blends before and after motion {number} overlap: their radii '
                     f'{before:g} and {after:g} m are more than the {distance:.4f} m between its '
                     'ends')


def _check_blend(
    context: PlanningContext, run: _Run, scene: PlanningScene, number: int
) -> None:
    group, which = run.request.group_name, f'the blend before motion {number}'
    excess = worst_excess(context, run.motion, run.names)
    if excess is not None:
        # On the same path velocity goes with the pace, acceleration with its square.
        pace = excess.times if excess.kind == 'velocity' else excess.times**0.5
        raise PlanningError(
            MoveItErrorCode.FAILURE,
            f'{which} {excess}; give its two motions a max_velocity_scaling_factor below '
            f'{1.0 / pace:.2f} times the present one, or another blend_radius', 'blend',
        )
    validity = context.validity(scene, group, ConstraintSet(Constraints(), scene, context.log))
    fault = first_fault(run.motion, validity, context.settings.fine_step)
    if fault:
        raise _error(f'{which} cannot be run: {fault}; give a smaller blend_radius')


def _error(text: str) -> PlanningError:
    return PlanningError(MoveItErrorCode.INVALID_MOTION_PLAN, text, SOURCE)


def blended(
    first: QuinticMotion, second: QuinticMotion, place: Place, radius: float, step: float,
    since: float = 0.0,
) -> tuple[QuinticMotion, float]:
    """
    Return two motions as one that does not stop between them, and when the blend ends [s].

    Inside a sphere about the point where they meet, the weight of the second motion grows from 0
    to 1 by a polynomial without a step in its first two derivatives. Both motions keep their pace;
    the one with the shorter way through the sphere waits: the second at its start, the first at
    its end.

    :param radius: of the sphere [m].
    :param step: largest time between two points of the blend [s].
    :param since: time [s] of the first motion before which it must not be changed.
    :raises PlanningError: FAILURE where one of them never leaves the sphere.
    """
    meeting = place(first.positions[-1])

    def outside(motion: QuinticMotion, time: float) -> bool:
        at = place(motion.sample(np.array([time]))[0])
        return float(np.linalg.norm(at - meeting)) >= radius

    enters = first.duration - _first_time(
        lambda time: outside(first, first.duration - time), first.duration - since,
        'first', radius,
    )
    leaves = _first_time(lambda time: outside(second, time), second.duration, 'second', radius)
    window = max(first.duration - enters, leaves)
    late = window - leaves
    count = max(int(np.ceil(window / step)), _POINTS)
    times = np.linspace(0.0, window, count + 1)
    rest, step_up = np.zeros((2, 1)), np.array([[0.0], [1.0]])
    weight, growth, bend = QuinticMotion(
        np.array([0.0, window]), step_up, rest, rest).states(times)
    q1, v1, a1 = first.states(enters + times)
    q2, v2, a2 = second.states(times - late)
    blend = QuinticMotion(
        times,
        q1 + weight * (q2 - q1),
        v1 + growth * (q2 - q1) + weight * (v2 - v1),
        a1 + bend * (q2 - q1) + 2.0 * growth * (v2 - v1) + weight * (a2 - a1),
    )
    before = first.part(0, int(np.searchsorted(first.times, enters - _TIME_RESOLUTION)))
    remaining = int(np.searchsorted(second.times, leaves + _TIME_RESOLUTION))
    end = enters + window
    return before.joined(blend, enters).joined(second.part(remaining), end - leaves), end


def _first_time(
    outside: Callable[[float], bool], longest: float, which: str, radius: float
) -> float:
    """Return when a motion passes the sphere; it begins in the middle of it."""
    inner = 0.0
    while inner < longest:
        outer = min(inner + _LOOK, longest)
        if outside(outer):
            for _ in range(_HALVINGS):
                middle = 0.5 * (inner + outer)
                inner, outer = (inner, middle) if outside(middle) else (middle, outer)
            return outer
        inner = outer
    raise PlanningError(
        MoveItErrorCode.FAILURE,
        f'the {which} motion lies within the blend radius {radius:g} m of the point where both '
        'meet; give a smaller blend_radius',
        'blend',
    )
