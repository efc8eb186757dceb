# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The order in which trajectories are executed, and the topic ``trajectory_execution_event``."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from rclpy.task import Future
from std_msgs.msg import String

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.execution.controller_selection import actuated, MultiDofTrajectory
from armsim_ros.execution.rules import check_points, check_start, continues, meeting, obstruction
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.execution.controller_managers import (
    controller_manager,
    selected_controllers,
    start_tolerances,
)
from armsim_ros.nodes.move_group.execution.execution import (
    Execution,
    ExecutionOutcome,
    ExecutionWatch,
)
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.trajectory import JointTrajectory

#: A joint of another robot that has moved this far triggers a new check [rad or m].
MOVED = 0.03


class PathWatch:
    """
    Checks the rest of a trajectory for collisions in the monitored scene.

    What has changed since the trajectory was planned is checked at once.

    :param joint_names: of the trajectory that is being executed.
    :param fault: [s] since its start, scene -> where its rest collides, '' for nowhere; it is
        called in the queries' thread.
    :param planned_in: the monitored scene as it was when the plan was begun; None where that is
        not known, so that the whole is checked at its start.
    """

    def __init__(
        self, context: Context, joint_names: Sequence[str],
        fault: Callable[[float, PlanningScene], str], planned_in: PlanningScene | None = None,
    ) -> None:
        self._context, self._fault = context, fault
        scene = planned_in or context.scene.snapshot()
        joints, positions = set(joint_names), scene.kinematic_model.positions(scene.q)
        self._others = {name: positions[name] for robot in context.robots if not robot & joints
                        for name in robot}
        self._checked = None if planned_in is None else planned_in.content
        self._pending: Future | None = None

    def invalid(self, elapsed: float) -> str:
        """
        Return why the rest of the path has become invalid, '' while it is valid.

        It never waits: a check that was started is asked for its result the next time.

        :param elapsed: [s] since the start of the trajectory.
        """
        if self._pending is not None:
            if not self._pending.done():
                return ''
            sentence = str(self._pending.result())
            self._pending = None
            if sentence:
                return sentence
        context = self._context
        measured = context.states.positions
        others = {name: measured.get(name, before) for name, before in self._others.items()}
        moved = any(abs(others[name] - before) > MOVED for name, before in self._others.items())
        if moved or self._checked is None or not context.scene.content.collides_like(
                self._checked):
            scene = context.scene.snapshot()
            self._checked, self._others = scene.content, others
            self._pending = context.queries.submit(lambda: self._fault(elapsed, scene))
        return ''


@dataclass(frozen=True, slots=True, eq=False)
class _Turn:
    """
    A trajectory that is running or waiting.

    :param controllers: names of those that it needs; empty where none can run it.
    :param begin_ns: when it began to run [ns].
    """

    execution: Execution
    trajectory: JointTrajectory
    controllers: frozenset[str]
    begin_ns: int = 0


class TrajectoryExecutionManager:
    """
    Starts and stops all executions.

    Those that need other controllers run at once, where what they sweep does not meet. Of those
    that share a controller a trajectory that begins where the robot is replaces the one that
    runs; any other waits until it has ended.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self.controllers = controller_manager(context)
        self._running: list[_Turn] = []
        self._waiting: deque[_Turn] = deque()
        self._stops = 0
        self._checker: CollisionChecker | None = None

    @property
    def busy(self) -> bool:
        """Whether a trajectory is being executed."""
        return bool(self._running)

    def stop(self) -> bool:
        """Stop all motion of any client; False if nothing moves."""
        self._stops += 1
        for turn in self._running:
            turn.execution.stop()
        self._context.ticker.wake()
        return self.busy

    async def queued(
        self, trajectory: JointTrajectory, watch: ExecutionWatch, names: Sequence[str] = (),
        multi_dof: MultiDofTrajectory | None = None,
    ) -> ExecutionOutcome:
        """Run a trajectory in place of what runs, or after those that share a controller."""
        await self.controllers.refresh()
        turn, stops = self._turn(trajectory, watch, names, multi_dof), self._stops
        if self._takes_over(turn):
            return await self.run(trajectory, watch, names, multi_dof, takes_over=True)
        self._waiting.append(turn)
        try:
            while True:
                if watch.cancelled():
                    return ExecutionOutcome(
                        MoveItErrorCode.PREEMPTED, 'cancelled while it waited its turn')
                if self._stops != stops:
                    return ExecutionOutcome(
                        MoveItErrorCode.PREEMPTED, "stopped by a 'stop' event in the queue")
                if not (self._rivals(turn) or self._waits_behind(turn)):
                    break
                await self._context.ticker.next()
        finally:
            self._waiting.remove(turn)
        return await self.run(trajectory, watch, names, multi_dof)

    async def run(
        self, trajectory: JointTrajectory, watch: ExecutionWatch, names: Sequence[str] = (),
        multi_dof: MultiDofTrajectory | None = None, *, takes_over: bool = False
    ) -> ExecutionOutcome:
        """
        Run a trajectory now.

        :param trajectory: an empty trajectory moves nothing and is a success.
        :param names: of the controllers to use; empty for a choice by joints.
        :param multi_dof: what multi-DOF joints do at the same time.
        :param takes_over: whether it replaces those that share a controller; it begins where the
            robot is.
        :returns: CONTROL_FAILED while another runs that shares a controller with it, or that
            it would meet.
        """
        await self.controllers.refresh()
        turn = self._turn(trajectory, watch, names, multi_dof)
        rivals = self._rivals(turn)
        if rivals and not takes_over:
            return ExecutionOutcome(
                MoveItErrorCode.CONTROL_FAILED, 'another trajectory is being executed')
        others = tuple(other for other in self._running if other not in rivals)
        self._running.append(turn)
        try:
            if others and turn.controllers and len(trajectory):
                sentence = await self._meeting(turn, others)
                if sentence:
                    return ExecutionOutcome(MoveItErrorCode.CONTROL_FAILED, sentence)
            for rival in rivals:
                rival.execution.replace()
            return await turn.execution.run(
                turn.trajectory, names, multi_dof, start_checked=takes_over)
        finally:
            self._running.remove(turn)
            self._context.ticker.wake()

    def obstruction(
        self, trajectory: JointTrajectory, elapsed: float, scene: PlanningScene
    ) -> str:
        """
        Return what is in the way of a trajectory's rest, links unpadded; only for queries' thread.

        :param elapsed: [s] since its start.
        """
        contact = obstruction(
            self._checker_of(scene.unpadded()), scene.q, _rest(trajectory, elapsed))
        return '' if contact is None else (
            f"'{contact.body1}' and '{contact.body2}' would touch on the rest of the path")

    def _turn(
        self, trajectory: JointTrajectory, watch: ExecutionWatch, names: Sequence[str],
        multi_dof: MultiDofTrajectory | None,
    ) -> _Turn:
        context = self._context
        try:
            check_points(trajectory)
            trajectory = actuated(trajectory, context.robot)
            selected = selected_controllers(
                context, self.controllers, trajectory, names, multi_dof)
        except PlanningError:
            selected = ()  # the execution reports the error
        return _Turn(
            Execution(context, self.controllers, watch), trajectory,
            frozenset(controller.name for controller in selected), context.states.now_ns())

    def _rivals(self, turn: _Turn) -> list[_Turn]:
        """Return what runs and shares a controller."""
        return [other for other in self._running if turn.controllers & other.controllers]

    def _takes_over(self, turn: _Turn) -> bool:
        """Return whether a trajectory takes the place of what runs on its controllers."""
        rivals, tolerances = self._rivals(turn), start_tolerances(self._context).checked()
        if not rivals or self._waits_behind(turn):
            return False
        try:
            for rival in rivals:
                if continues(rival.trajectory, turn.trajectory, tolerances.common):
                    return False
            check_start(turn.trajectory, self._context.states.positions, self._context.robot,
                        tolerances)
        except PlanningError:
            return False  # it is refused when its turn comes, unless the robot is there by then
        return True

    def _waits_behind(self, turn: _Turn) -> bool:
        """Return whether an earlier trajectory waits for the same controller."""
        for other in self._waiting:
            if other is turn:
                return False
            if turn.controllers & other.controllers:
                return True
        return False

    async def _meeting(self, turn: _Turn, others: Sequence[_Turn]) -> str:
        """Return what running trajectory a trajectory would collide with, '' if none."""
        context = self._context
        now = context.states.now_ns()
        scene = context.scene.snapshot()
        rests = [_rest(other.trajectory, (now - other.begin_ns) * 1e-9) for other in others]

        def look() -> str:
            checker = self._checker_of(scene)
            for rest in rests:
                contact = meeting(checker, scene.q, rest, turn.trajectory)
                if contact is not None:
                    return (
                        'the trajectory would meet one that is being executed: '
                        f"'{contact.body1}' and '{contact.body2}'; execute them one after the "
                        'other')
            return ''

        return str(await context.queries.submit(look))

    def _checker_of(self, scene: PlanningScene) -> CollisionChecker:
        """Return the checker of another scene; only for the queries' thread."""
        if self._checker is None:
            self._checker = CollisionChecker(scene)
        self._checker.use(scene)
        return self._checker


def _rest(trajectory: JointTrajectory, elapsed: float) -> JointTrajectory:
    """Return what is left of a trajectory [s] after its start, from the last point before."""
    passed = int(np.sum(trajectory.times < elapsed - 0.5))
    return trajectory.since(max(passed - 1, 0))


class TrajectoryExecutionEvent:
    """Stops the robot when the message is "stop"."""

    def __init__(self, context: Context, execution: TrajectoryExecutionManager) -> None:
        self._context, self._execution = context, execution
        context.subscribe(String, 'trajectory_execution_event', self._receive)

    def _receive(self, message: String) -> None:
        if message.data != 'stop':
            self._context.logger.warning(
                f"trajectory_execution_event: '{message.data[:60]}' is not known; allowed: stop")
        elif self._execution.stop():
            self._context.logger.info("trajectory_execution_event: 'stop', the robot is stopped")
