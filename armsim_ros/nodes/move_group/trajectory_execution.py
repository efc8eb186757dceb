# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories sent to their controllers and watched until they end."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from rclpy.task import Future

from armsim_ros.config.moveit_controllers import MoveItControllerSettings
from armsim_ros.errors import PlanningError
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.controller_handles import ControllerRun, HANDLES
from armsim_ros.nodes.move_group.ticker import Ticker
from armsim_ros.planning.controller_selection import (
    controlled_joints,
    select_controllers,
    split_trajectory,
)
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.execution import (
    allowed_duration,
    check_sizes,
    check_start,
    settled,
    unwound,
)
from armsim_ros.trajectory import JointTrajectory

SOURCE = 'trajectory_execution'
CONNECT_TICKS = 50
LOST_TICKS = 100
STOP_TICKS = 50
SETTLE_TICKS = 50
ARRIVED = 0.02
LATE_RESULT = 2.0


@dataclass(frozen=True, slots=True)
class Outcome:
    """How an execution ended."""

    code: MoveItErrorCode
    message: str = ''

    @property
    def success(self) -> bool:
        """Whether the robot arrived."""
        return self.code == MoveItErrorCode.SUCCESS


@dataclass(slots=True)
class Watch:
    """
    What may end an execution before its time.

    :param cancelled: whether the client wants it to stop.
    :param invalid: [s] since the start -> why the rest of the path is no longer valid, or ''.
    :param observe: told [s] since the start, every 20 ms.
    """

    cancelled: Callable[[], bool] = lambda: False
    invalid: Callable[[float], str] = lambda elapsed: ''
    observe: Callable[[float], None] = lambda elapsed: None


class TrajectoryExecution:
    """
    Chooses controllers, sends each its part, waits for all of them.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        """Make an action client for each controller."""
        self._context = context
        self._ticker = Ticker(context.node)
        self._handles = {
            settings.name: HANDLES[settings.type](context.node, settings, self._ticker.wake)
            for settings in context.settings.moveit_controllers
        }
        self._running: list[ControllerRun] = []
        self._stops = 0
        self._busy = False
        self._queue: deque[Future] = deque()

    @property
    def busy(self) -> bool:
        """Whether a trajectory is being executed."""
        return self._busy

    @property
    def ticker(self) -> Ticker:
        """The pulse that executions wait for."""
        return self._ticker

    def stop(self) -> bool:
        """Stop all motion, whoever asked for it; False where nothing moves."""
        self._stops += 1
        self._ticker.wake()
        return self._busy

    async def queued(
        self, trajectory: JointTrajectory, watch: Watch, names: Sequence[str] = ()
    ) -> Outcome:
        """Run a trajectory as soon as those before it have ended."""
        while self._busy:
            turn = Future()
            self._queue.append(turn)
            await turn
            if watch.cancelled():
                self._next_in_queue()
                return Outcome(MoveItErrorCode.PREEMPTED, 'cancelled while it waited its turn')
        return await self.run(trajectory, watch, names)

    async def run(
        self, trajectory: JointTrajectory, watch: Watch, names: Sequence[str] = ()
    ) -> Outcome:
        """
        Run a trajectory now.

        :param trajectory: an empty one is a success at once.
        :param names: of the controllers to use; empty for a choice by joints.
        :returns: CONTROL_FAILED while another one runs.
        """
        if not trajectory.points:
            return Outcome(MoveItErrorCode.SUCCESS)
        if self._busy:
            return Outcome(
                MoveItErrorCode.CONTROL_FAILED, 'another trajectory is being executed'
            )
        self._busy = True
        stops = self._stops
        try:
            parts = await self._prepare(trajectory, names)
            runs = await self._start(parts)
            outcome = await self._until_done(trajectory, runs, watch, stops)
            if outcome.success:
                await self._come_to_rest()
            return outcome
        except PlanningError as error:
            return Outcome(MoveItErrorCode(error.code), str(error))
        finally:
            self._running = []
            self._busy = False
            self._next_in_queue()

    async def _prepare(
        self, trajectory: JointTrajectory, names: Sequence[str]
    ) -> list[tuple[MoveItControllerSettings, JointTrajectory]]:
        context, settings = self._context, self._context.execution_settings
        if not settings.allow_trajectory_execution:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                'trajectory execution is switched off: allow_trajectory_execution is false',
                SOURCE,
            )
        check_sizes(trajectory)
        selected = select_controllers(
            controlled_joints(trajectory.joint_names, context.robot),
            context.settings.moveit_controllers,
            names=tuple(names),
        )
        if settings.allowed_start_tolerance > 0.0:
            await context.states.newer_than(context.states.now_ns(), 1.0)
            check_start(
                trajectory,
                context.states.positions,
                context.robot,
                settings.allowed_start_tolerance,
                settings.allowed_start_tolerance_joints,
            )
        whole = unwound(trajectory, context.states.positions, context.robot)
        return list(split_trajectory(whole, selected))

    async def _start(
        self, parts: Sequence[tuple[MoveItControllerSettings, JointTrajectory]]
    ) -> list[ControllerRun]:
        for info, _ in parts:
            await self._connected(info.name)
        self._running = []
        for info, part in parts:
            run = await self._handles[info.name].send(part)
            if run is None:
                await self._cancel_all()
                raise PlanningError(
                    MoveItErrorCode.CONTROL_FAILED,
                    f"controller '{info.name}' rejected the trajectory; its log says why",
                    SOURCE,
                )
            self._running.append(run)
        return self._running

    async def _connected(self, name: str) -> None:
        handle = self._handles[name]
        for _ in range(CONNECT_TICKS):
            if handle.connected:
                return
            await self._ticker.next()
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED,
            f"action '{handle.settings.action_name}' of controller '{name}' is not connected; "
            'is the controller active?',
            SOURCE,
        )

    async def _until_done(
        self,
        trajectory: JointTrajectory,
        runs: Sequence[ControllerRun],
        watch: Watch,
        stops: int,
    ) -> Outcome:
        states = self._context.states
        start_ns = states.now_ns()
        limit = self._limit(trajectory, runs)
        lost = 0
        while not all(run.done for run in runs):
            await self._ticker.next()
            elapsed = (states.now_ns() - start_ns) * 1e-9
            watch.observe(elapsed)
            failed = next((run for run in runs if run.done and run.failure), None)
            if failed is not None:
                break
            connected = all(self._handles[run.name].connected for run in runs)
            lost = 0 if connected else lost + 1
            late = limit + LATE_RESULT if self._arrived(trajectory) else limit
            ending = self._ending(watch, stops, elapsed, late, lost)
            if ending is not None:
                await self._cancel_all()
                return ending
        failed = next((run for run in runs if run.done and run.failure), None)
        if failed is None:
            return Outcome(MoveItErrorCode.SUCCESS)
        await self._cancel_all()
        if failed.canceled:
            return Outcome(
                MoveItErrorCode.PREEMPTED, f"controller '{failed.name}': the goal was cancelled"
            )
        return Outcome(
            MoveItErrorCode.CONTROL_FAILED, f"controller '{failed.name}': {failed.failure}"
        )

    def _ending(
        self, watch: Watch, stops: int, elapsed: float, limit: float, lost: int
    ) -> Outcome | None:
        if watch.cancelled():
            return Outcome(MoveItErrorCode.PREEMPTED, 'cancelled by the client')
        if self._stops != stops:
            return Outcome(MoveItErrorCode.PREEMPTED, "stopped by a 'stop' event")
        if elapsed > limit:
            return Outcome(
                MoveItErrorCode.TIMED_OUT,
                f'the controllers took longer than the {limit:.2f} s that are allowed '
                '(duration * allowed_execution_duration_scaling + allowed_goal_duration_margin)',
            )
        if lost >= LOST_TICKS:
            return Outcome(MoveItErrorCode.CONTROL_FAILED, 'a controller is gone')
        invalid = watch.invalid(elapsed)
        if invalid:
            return Outcome(
                MoveItErrorCode.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE, invalid
            )
        return None

    def _limit(self, trajectory: JointTrajectory, runs: Sequence[ControllerRun]) -> float:
        """Return how long [s] the slowest part may take."""
        settings = self._context.execution_settings
        if not settings.execution_duration_monitoring:
            return float('inf')
        limits = []
        for run in runs:
            own = self._handles[run.name].settings
            scaling = own.allowed_execution_duration_scaling
            margin = own.allowed_goal_duration_margin
            limits.append(
                allowed_duration(
                    trajectory,
                    settings.allowed_execution_duration_scaling if scaling is None else scaling,
                    settings.allowed_goal_duration_margin if margin is None else margin,
                )
            )
        return max(limits)

    def _arrived(self, trajectory: JointTrajectory) -> bool:
        """Return whether the robot is where a trajectory ends: then only the result is late."""
        measured = self._context.states.positions
        ends = zip(trajectory.joint_names, trajectory.points[-1].positions, strict=True)
        return all(abs(measured.get(name, float('inf')) - end) < ARRIVED for name, end in ends)

    async def _cancel_all(self) -> None:
        """Cancel what runs and wait, a second at most, until it has ended."""
        for run in self._running:
            run.cancel()
        for _ in range(STOP_TICKS):
            if all(run.done for run in self._running):
                return
            await self._ticker.next()

    async def _come_to_rest(self) -> None:
        context, settings = self._context, self._context.execution_settings
        if not settings.wait_for_trajectory_completion:
            return
        tolerance = settings.allowed_start_tolerance or 0.01
        seen: deque[dict[str, float]] = deque(maxlen=3)
        count = context.states.count
        for _ in range(SETTLE_TICKS):
            if context.states.count != count:
                count = context.states.count
                seen.append(dict(context.states.positions))
                if len(seen) == seen.maxlen and settled(tuple(seen), tolerance):
                    return
            await self._ticker.next()
        context.logger.warning('the robot still moves 1 s after the trajectory has ended')

    def _next_in_queue(self) -> None:
        if self._queue and not self._busy:
            self._queue.popleft().set_result(None)
