# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The motion planner: the single object that answers all questions about motions."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
import threading

from armsim_ros.arrays import Vector
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.kinematics.inverse import end_of
from armsim_ros.log import Log
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.cartesian_path import plan_cartesian
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.planning.constraints import ConstraintSet, merged
from armsim_ros.planning.context import PlanningContext, PlanningSettings
from armsim_ros.planning.pilz.sequence import join, plan_items, SequenceItem, SequenceResponse
from armsim_ros.planning.pilz.sequence import SOURCE as SEQUENCE
from armsim_ros.planning.pipeline import planning_time, run_pipeline
from armsim_ros.planning.queries import (
    check_state,
    IKRequest,
    IKResponse,
    path_fault,
    solve_ik,
    StateReport,
)
from armsim_ros.planning.request import (
    CartesianRequest,
    CartesianResponse,
    Constraints,
    MotionPlanRequest,
    MotionPlanResponse,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.start_state import requested_scene
from armsim_ros.planning.timing.time_parameterization import warm_up
from armsim_ros.trajectory import JointTrajectory

__all__ = ['MotionPlanner', 'never', 'warm_up']


def never() -> bool:
    """Return False: never cancelled."""
    return False


class MotionPlanner:
    """
    Plans for the groups of a robot; any thread may ask, requests run one at a time.

    No error of a client raises: the answer carries a code, a sentence and its source.

    :param scene: any scene of the robot; each request brings its own, which is not changed.
    :param settings: what the user set.
    :param log: gets warnings, and the reason of every failure; without it warnings go to
        Python's ``logging``, and the reason is in the response alone.
    """

    def __init__(
        self, scene: PlanningScene, *, settings: PlanningSettings | None = None,
        log: Log | None = None,
    ) -> None:
        self._context = PlanningContext(scene, settings, log)
        self._settings = self._context.settings
        self._lock = threading.Lock()
        self._failures = log

    @property
    def settings(self) -> PlanningSettings:
        """What the user set; a request takes the value it has when it begins."""
        return self._settings

    @settings.setter
    def settings(self, settings: PlanningSettings) -> None:
        # A single reference, swapped: its setter must not wait for the plan of another.
        self._settings = settings

    @contextmanager
    def _request(self) -> Iterator[PlanningContext]:
        """Wait for the turn of a request, and begin it with the settings of now."""
        with self._lock:
            self._context.settings = self._settings
            yield self._context

    def _report(self, source: str, error: PlanningError) -> None:
        if self._failures is not None:
            self._failures.error(f'{source}: {error}')

    def prepare(self) -> None:
        """Do now what the first requests would wait for: imports and tables (about 1 s)."""
        warm_up()
        with self._request() as context:
            context.prepare()

    def plan(
        self, request: MotionPlanRequest, scene: PlanningScene, *,
        clock: Callable[[], float], cancelled: Callable[[], bool] = never,
    ) -> MotionPlanResponse:
        """
        Return a trajectory for a request, or the reason why there is none.

        :param scene: a snapshot, or an overlay for this request.
        :param clock: returns the time [s] that ``allowed_planning_time`` is measured in.
        :param cancelled: polled often; True ends the search.
        """
        with self._request() as context:
            began = clock()
            positions: dict[str, float] = {}
            refused = ''
            seconds = planning_time(context, request)
            budget = Budget(clock, began + seconds, cancelled)
            try:
                pipeline = context.settings.requested_pipeline(request.pipeline_id)
                started = requested_scene(context, pipeline, request, scene)
                positions = context.model.positions(started.q)
                refused = started.refused
                with context.polled(lambda: budget.check('planning pipeline')):
                    trajectory, length = run_pipeline(
                        context, pipeline, request, scene, started, budget)
            except PlanningError as error:
                source = error.source or 'planning pipeline'
                self._report(source, error)
                return MotionPlanResponse(
                    MoveItErrorCode(error.code), '; '.join(filter(None, (str(error), refused))),
                    source, JointTrajectory(()),
                    positions, request.group_name, clock() - began,
                    contacts=tuple(item for item in error.contacts if isinstance(item, Contact)))
            return MotionPlanResponse(
                MoveItErrorCode.SUCCESS, refused, 'planning scene' if refused else '', trajectory,
                positions, request.group_name, max(clock() - began, 1e-9), length)

    def plan_sequence(
        self, items: Sequence[SequenceItem], scene: PlanningScene, *,
        clock: Callable[[], float], cancelled: Callable[[], bool] = never, pipeline: str = '',
    ) -> SequenceResponse:
        """
        Return trajectories for motions that follow each other, or why there are none.

        :param items: the first may give a start state, later ones only for another group.
        :param pipeline: plans all motions; '' for the pipeline of the first.
        """
        if not items:
            return SequenceResponse()
        began = clock()
        answers: list[MotionPlanResponse] = []

        def plan(request: MotionPlanRequest) -> MotionPlanResponse:
            answers.append(self.plan(request, scene, clock=clock, cancelled=cancelled))
            return answers[-1]

        try:
            requests = plan_items(items, pipeline or items[0].request.pipeline_id, plan)
            with self._request() as context:
                runs = join(context, items, requests, answers, scene)
        except PlanningError as error:
            source = error.source or SEQUENCE
            self._report(source, error)
            return SequenceResponse(
                MoveItErrorCode(error.code), str(error), source, planning_time=clock() - began,
                plans=tuple(answers))
        return SequenceResponse(
            message=answers[0].message, source=answers[0].source,
            trajectories=tuple(run.motion.trajectory(run.names) for run in runs),
            requests=tuple(run.request for run in runs),
            start=answers[0].trajectory_start,
            planning_time=max(clock() - began, 1e-9), plans=tuple(answers))

    def cartesian_path(
        self, request: CartesianRequest, scene: PlanningScene, *,
        cancelled: Callable[[], bool] = never,
    ) -> CartesianResponse:
        """Return the part of a Cartesian path that can be followed, timed."""
        with self._request() as context:
            return plan_cartesian(context, request, scene, cancelled)

    def compute_ik(
        self, request: IKRequest, scene: PlanningScene, *, clock: Callable[[], float]
    ) -> IKResponse:
        """Return joint positions that put links where they are wanted."""
        return end_of(self.ik_in_turns(request, scene, clock=clock))

    def ik_in_turns(
        self, request: IKRequest, scene: PlanningScene, *, clock: Callable[[], float]
    ) -> Generator[None, None, IKResponse]:
        """Do as :meth:`compute_ik`, and yield between tries: others may ask meanwhile."""
        with self._request() as context:
            tries = solve_ik(context, request, scene, clock)
        while True:
            with self._request():
                try:
                    next(tries)
                except StopIteration as end:
                    response: IKResponse = end.value
                    return response
            yield

    def check_state(
        self, scene: PlanningScene, q: Vector, group: str = '',
        constraints: Constraints | None = None,
    ) -> StateReport:
        """
        Return whether a robot state is free and keeps constraints.

        :param q: (n,) full robot state.
        :param group: only links that this group moves; '' for all.
        """
        with self._request() as context:
            return check_state(context, scene, q, group, constraints or Constraints())

    def follows(self, scene: PlanningScene) -> bool:
        """Return whether a scene's collisions are those of the last request: checks are quick."""
        return self._context.checker.follows(scene)

    def path_fault(
        self, trajectory: JointTrajectory, from_time: float, scene: PlanningScene, group: str,
    ) -> str:
        """
        Return where the rest of a trajectory collides in a scene, links unpadded; '' for nowhere.

        :param from_time: [s] of the trajectory; the part before is not checked.
        """
        with self._request() as context:
            return path_fault(context, trajectory, from_time, scene, group)

    def goal_reached(self, request: MotionPlanRequest, scene: PlanningScene) -> bool:
        """
        Return whether the scene's robot state satisfies one of a request's goals already.

        Path constraints have to be satisfied too. A goal without a constraint that can be used
        is not a goal.
        """
        with self._request() as context:
            return any(
                not ConstraintSet(goal, scene, context.log).empty
                and ConstraintSet(
                    merged(goal, request.path_constraints, context.log), scene, context.log,
                ).satisfied(scene.q)
                for goal in request.goal_constraints)
