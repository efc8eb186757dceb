# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The execution of a trajectory, from choosing controllers until the robot is at rest."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.execution.controller_selection import MultiDofTrajectory, split_trajectory
from armsim_ros.execution.ros2_control import controllers_to_switch
from armsim_ros.execution.rules import (
    allowed_duration,
    begin,
    check_start,
    settled,
    STATES_AT_REST,
    unwound,
)
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.execution.controller_handles import (
    ControllerHandle,
    ControllerRun,
)
from armsim_ros.nodes.move_group.execution.controller_managers import (
    multi_dof_part,
    Part,
    selected_controllers,
    SimpleControllerManager,
    start_tolerances,
)
from armsim_ros.trajectory import JointTrajectory

SOURCE = 'trajectory_execution'
#: Waits [s] of wall time: for a state newer than the request, a controller's action, its answer
#: to a goal, the end of what was cancelled, and the robot at rest.
STATE_TIMEOUT, CONNECT_TIMEOUT, ANSWER_TIMEOUT, STOP_TIMEOUT, SETTLE_TIMEOUT = 1, 1, 5, 1, 1
#: A controller that has been out of sight for this long is gone [s].
LOST_TIMEOUT = 2.0
ARRIVED = 0.02
LATE_RESULT = 2.0
REPLACED = 'replaced by a newer trajectory for the same controller'
#: Wall time for a result that was sent when simulated time jumped [s]; in lockstep each request is
#: a jump.
LEAP_TIME, LOCKSTEP_LEAP_TIME = 0.5, 5.0


@dataclass(frozen=True, slots=True)
class ExecutionOutcome:
    """How an execution ended."""

    code: MoveItErrorCode
    message: str = ''

    @property
    def success(self) -> bool:
        """Whether the robot arrived."""
        return self.code == MoveItErrorCode.SUCCESS

    def of_plan(self, *, cancelled: bool) -> ExecutionOutcome:
        """
        Return the outcome of an action that has planned the motion too.

        :param cancelled: whether the client has cancelled; a motion that was stopped by anything
            else has failed.
        """
        if self.code == MoveItErrorCode.PREEMPTED and not cancelled:
            return ExecutionOutcome(MoveItErrorCode.CONTROL_FAILED, self.message)
        return self


@dataclass(slots=True)
class ExecutionWatch:
    """
    What may end an execution early.

    :param cancelled: whether the client wants it to stop.
    :param invalid: [s] since the start -> why the rest of the path is no longer valid, or ''.
    """

    cancelled: Callable[[], bool] = lambda: False
    invalid: Callable[[float], str] = lambda elapsed: ''


class _EndedError(Exception):
    """Ends an execution early."""

    def __init__(self, code: MoveItErrorCode, message: str) -> None:
        super().__init__(message)
        self.outcome = ExecutionOutcome(code, message)


class Execution:
    """Runs a trajectory; all waits are bounded, and every way out cancels what was started."""

    def __init__(
        self, context: Context, controllers: SimpleControllerManager, watch: ExecutionWatch
    ) -> None:
        self._context, self._controllers, self._watch = context, controllers, watch
        self._runs: list[ControllerRun] = []
        self._stopped = self._replaced = False

    def stop(self) -> None:
        """End it at its next check."""
        self._stopped = True

    def replace(self) -> None:
        """Let it end when its controllers take a newer goal."""
        self._replaced = True

    async def run(
        self, trajectory: JointTrajectory, names: Sequence[str] = (),
        multi_dof: MultiDofTrajectory | None = None, *, start_checked: bool = False
    ) -> ExecutionOutcome:
        """
        Run the trajectory and return the outcome.

        :param names: of the controllers to use; empty for a choice by joints.
        :param multi_dof: what multi-DOF joints do at the same time.
        :param start_checked: whether it is known to begin where the robot was when it came.
        """
        try:
            self._context.check_ending(SOURCE)
            parts = await self._prepared(trajectory, names, multi_dof, start_checked)
            await self._start(parts)
            outcome = await self._until_done(trajectory, multi_dof)
            if outcome.success:
                await self._come_to_rest(trajectory)
        except PlanningError as error:
            outcome = ExecutionOutcome(MoveItErrorCode(error.code), str(error))
        except _EndedError as ending:
            outcome = ending.outcome
        finally:
            for run in self._runs:
                run.cancel()
        await self._ended()
        return outcome

    async def _prepared(
        self, trajectory: JointTrajectory, names: Sequence[str],
        multi_dof: MultiDofTrajectory | None, start_checked: bool,
    ) -> list[Part]:
        context, settings = self._context, self._context.execution_settings
        if not settings.allow_trajectory_execution:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                'trajectory execution is switched off: allow_trajectory_execution is false',
                SOURCE)
        selected = selected_controllers(context, self._controllers, trajectory, names, multi_dof)
        tolerances = start_tolerances(context)
        if not (tolerances.unchecked or start_checked):
            if not await context.states.current(STATE_TIMEOUT):
                context.check_ending(SOURCE)
                raise PlanningError(
                    MoveItErrorCode.CONTROL_FAILED,
                    'the trajectory is not started: no joint state newer than the request within '
                    f'{STATE_TIMEOUT} s on {", ".join(context.states.topics)}; does the '
                    'joint_state_broadcaster publish, and do its clock and that of move_group '
                    'agree (use_sim_time)?', SOURCE)
            check_start(trajectory, context.states.positions, context.robot, tolerances)
        await self._activate([controller.name for controller in selected])
        whole = unwound(trajectory, context.states.positions, context.robot)
        return [
            (controller, part, multi_dof_part(controller, multi_dof, settings))
            for controller, part in split_trajectory(
                whole, selected, settings.execution_velocity_scaling)]

    async def _activate(self, needed: Sequence[str]) -> None:
        """Activate the controllers that are needed and inactive, where that is allowed."""
        controllers = self._controllers
        active = controllers.active
        if active is None or set(needed) <= active:
            return
        if not self._context.execution_settings.moveit_manage_controllers:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f'not active: {", ".join(name for name in needed if name not in active)}; '
                'activate them, or set moveit_manage_controllers to true', SOURCE)
        await controllers.switch(*controllers_to_switch(needed, controllers.controllers, active))

    async def _start(self, parts: Sequence[Part]) -> None:
        for info, _, _ in parts:
            handle = self._controllers.handle(info.name)
            if not await self._wait(partial(getattr, handle, 'connected'), CONNECT_TIMEOUT):
                raise PlanningError(
                    MoveItErrorCode.CONTROL_FAILED,
                    f"action '{info.action_name}' of controller '{info.name}' is not connected; "
                    'is the controller active?',
                    SOURCE)
        for info, part, multi_dof in parts:
            self._runs.append(self._controllers.handle(info.name).send(part, multi_dof))
        answered = await self._wait(
            lambda: all(run.answered for run in self._runs)
            or any(run.rejected for run in self._runs),
            ANSWER_TIMEOUT)
        for run in self._runs:
            if run.rejected:
                reason = await self._reason(self._controllers.handle(run.name))
                raise PlanningError(
                    MoveItErrorCode.CONTROL_FAILED,
                    f"controller '{run.name}' rejected the trajectory; {reason}", SOURCE)
        if not answered:
            silent = ', '.join(f"'{run.name}'" for run in self._runs if not run.answered)
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f'controller {silent} has not answered for {ANSWER_TIMEOUT} s whether it takes '
                'the trajectory; does its program hang? It is cancelled as soon as it does',
                SOURCE)

    async def _reason(self, handle: ControllerHandle) -> str:
        """Return why a controller has rejected a goal."""
        if handle.publishes_reasons:
            await self._wait(lambda: bool(handle.reason), ANSWER_TIMEOUT)
        return handle.reason or 'its log has the reason'

    async def _until_done(
        self, trajectory: JointTrajectory, multi_dof: MultiDofTrajectory | None
    ) -> ExecutionOutcome:
        states = self._context.states
        sent_ns = states.now_ns()
        start_ns = sent_ns + round(begin(trajectory, sent_ns) * 1e9)
        limit = max(self._limit(each, sent_ns) for each in (trajectory, multi_dof)
                    if each is not None)
        seen = self._context.clock()
        lockstep = self._context.settings.simulation.deterministic
        patience = LOCKSTEP_LEAP_TIME if lockstep else LEAP_TIME
        while not all(run.done for run in self._runs):
            await self._context.ticker.next()
            now_ns = states.now_ns()
            if any(run.failed for run in self._runs):
                break
            self._check_ending()
            late = limit + LATE_RESULT if self._arrived(trajectory) else limit
            is_late = (now_ns - sent_ns) * 1e-9 > late
            # Where time jumps, the controllers' answers are still on their way.
            if is_late and not await self._wait(self._has_ended, patience):
                return ExecutionOutcome(
                    MoveItErrorCode.TIMED_OUT,
                    f'the controllers took longer than the {late:.2f} s that are allowed '
                    '(duration * allowed_execution_duration_scaling + '
                    'allowed_goal_duration_margin)')
            if all(run.connected for run in self._runs):
                seen = self._context.clock()
            elif self._context.clock() - seen > LOST_TIMEOUT:
                return ExecutionOutcome(MoveItErrorCode.CONTROL_FAILED, 'a controller is gone')
            invalid = self._watch.invalid(max(now_ns - start_ns, 0) * 1e-9)
            if invalid:
                return ExecutionOutcome(
                    MoveItErrorCode.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE, invalid)
        failed = next((run for run in self._runs if run.failed), None)
        if failed is None:
            return ExecutionOutcome(MoveItErrorCode.SUCCESS)
        if self._replaced:
            return ExecutionOutcome(MoveItErrorCode.PREEMPTED, REPLACED)
        if failed.canceled:
            return ExecutionOutcome(
                MoveItErrorCode.PREEMPTED, f"controller '{failed.name}': the goal was cancelled")
        return ExecutionOutcome(
            MoveItErrorCode.CONTROL_FAILED, f"controller '{failed.name}': {failed.failure}")

    def _has_ended(self) -> bool:
        return all(run.done for run in self._runs) or any(run.failed for run in self._runs)

    # ---------------------------------------------------------------- waits

    async def _wait(self, ready: Callable[[], bool], seconds: float) -> bool:
        """
        Wait for a condition, [s] of wall time at most; return whether it holds.

        :raises _EndedError: the execution is to end.
        """
        deadline = self._context.clock() + seconds
        while not ready():
            self._check_ending()
            if self._context.clock() > deadline:
                return False
            await self._context.ticker.next()
        return True

    def _check_ending(self) -> None:
        if self._watch.cancelled():
            raise _EndedError(MoveItErrorCode.PREEMPTED, 'cancelled by the client')
        if self._context.ending:
            raise _EndedError(MoveItErrorCode.FAILURE, self._context.ending)
        if self._stopped:
            raise _EndedError(MoveItErrorCode.PREEMPTED, "stopped by a 'stop' event")
        if self._replaced and not self._runs:
            raise _EndedError(MoveItErrorCode.PREEMPTED, REPLACED)

    async def _ended(self) -> None:
        """Wait up to a second until everything that was cancelled has ended."""
        deadline = self._context.clock() + STOP_TIMEOUT
        while running := [run.name for run in self._runs if not run.done]:
            if self._context.ending:
                return  # the client is answered while there is time
            if self._context.clock() > deadline:
                self._context.logger.warning(
                    f"{SOURCE}: controller {', '.join(map(repr, running))} has not reported for "
                    f'{STOP_TIMEOUT} s that it has stopped; the robot may still move')
                return
            await self._context.ticker.next()

    async def _come_to_rest(self, trajectory: JointTrajectory) -> None:
        context = self._context
        tolerances = start_tolerances(context)
        if tolerances.unchecked or not context.execution_settings.wait_for_trajectory_completion:
            return
        seen = deque([dict(context.states.positions)], maxlen=STATES_AT_REST + 1)
        joints = [name for name in trajectory.joint_names if name in context.robot.joints]
        count = context.states.count

        def at_rest() -> bool:
            nonlocal count
            if context.states.count != count:
                count = context.states.count
                seen.append(dict(context.states.positions))
            return settled(tuple(seen), joints, context.robot, tolerances)

        if not await self._wait(at_rest, SETTLE_TIMEOUT):
            context.logger.warning('the robot still moves 1 s after the trajectory has ended')

    # ---------------------------------------------------------------- limits

    def _limit(self, trajectory: JointTrajectory | MultiDofTrajectory, now_ns: int) -> float:
        """Return how long [s] the slowest part may take from now on."""
        settings = self._context.execution_settings
        if not settings.execution_duration_monitoring:
            return float('inf')
        limits = []
        for run in self._runs:
            own = run.settings
            scaling = own.allowed_execution_duration_scaling
            margin = own.allowed_goal_duration_margin
            limits.append(
                allowed_duration(
                    trajectory,
                    settings.allowed_execution_duration_scaling if scaling is None else scaling,
                    settings.allowed_goal_duration_margin if margin is None else margin, now_ns))
        return max(limits, default=0.0)

    def _arrived(self, trajectory: JointTrajectory) -> bool:
        """Return whether the robot is at a trajectory's end: then only the result is late."""
        if not len(trajectory):
            return False
        measured = self._context.states.positions
        ends = zip(trajectory.joint_names, trajectory.positions[-1], strict=True)
        return all(abs(measured.get(name, float('inf')) - end) < ARRIVED for name, end in ends)
