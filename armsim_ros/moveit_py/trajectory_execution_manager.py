# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""TrajectoryExecutionManager: trajectories in a row, in the background, and their settings."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
import threading
import traceback
from typing import Any, overload

from moveit_msgs.msg import RobotTrajectory as RobotTrajectoryMessage
from pydantic import ValidationError
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.execution.controller_selection import (
    actuated_joints,
    MultiDofTrajectory,
    select_controllers,
)
from armsim_ros.execution.ros2_control import controllers_to_switch
from armsim_ros.moveit_py.answers import ExecutionStatus
from armsim_ros.moveit_py.moveit_cpp import interruptible, MoveItCpp
from armsim_ros.moveit_py.utils import logger
from armsim_ros.nodes.move_group.execution.controller_managers import selected_controllers
from armsim_ros.nodes.move_group.execution.execute_trajectory import robot_trajectory
from armsim_ros.nodes.move_group.execution.execution import ExecutionWatch
from armsim_ros.nodes.parameters import reason
from armsim_ros.trajectory import JointTrajectory

StatusCallback = Callable[[ExecutionStatus], object]
PartCallback = Callable[[int], object]
_Part = tuple[JointTrajectory, MultiDofTrajectory | None, tuple[str, ...]]


class TrajectoryExecutionManager:
    """
    Sends trajectories to controllers.

    :param cpp: the parts that plan and execute.
    """

    def __init__(self, cpp: MoveItCpp) -> None:
        self._cpp = cpp
        self._parts: list[_Part] = []
        self._stop = threading.Event()
        self._idle = threading.Event()
        self._idle.set()
        self._status = ExecutionStatus('SUCCEEDED')

    # ---------------------------------------------------------------- trajectories

    @overload
    def push(
        self, trajectory: RobotTrajectoryMessage | JointTrajectoryMessage, controller: str = '',
    ) -> bool: ...

    @overload
    def push(
        self, trajectory: RobotTrajectoryMessage | JointTrajectoryMessage,
        controllers: Sequence[str]) -> bool: ...

    def push(self, trajectory: Any, controller: Any = '', controllers: Any = None) -> bool:  # type: ignore[misc] # an argument has several names
        """
        Add a trajectory to those that are executed next.

        :param controller: to be used; '' for a choice by joints.
        :param controllers: that may be used, in place of a single one.
        :returns: False where it cannot be executed, which is the last status then, or another is
            being executed.
        """
        names = controller if controllers is None else controllers
        chosen = ((names,) if names else ()) if isinstance(names, str) else tuple(names)
        if not self._idle.is_set():
            logger().error('push: a trajectory is being executed; wait until it has ended')
            return False
        if isinstance(trajectory, JointTrajectoryMessage):
            trajectory = RobotTrajectoryMessage(joint_trajectory=trajectory)
        context, execution = self._cpp.context, self._cpp.execution

        async def check() -> _Part:
            joints, multi_dof = robot_trajectory(context, trajectory)
            await execution.controllers.refresh()
            selected_controllers(context, execution.controllers, joints, chosen, multi_dof)
            return joints, multi_dof, chosen

        try:
            self._parts.append(self._cpp.call(check))
        except PlanningError as error:
            logger().error(f'push: {error}')
            self._status = ExecutionStatus('ABORTED')
            return False
        return True

    def clear(self) -> None:
        """Drop the trajectories that were added and are not being executed."""
        if self._idle.is_set():
            self._parts.clear()
        else:
            logger().error('clear: a trajectory is being executed; stop it first')

    @overload
    def execute(self, callback: StatusCallback | None = None, auto_clear: bool = True) -> None: ...

    @overload
    def execute(
        self, callback: StatusCallback | None, part_callback: PartCallback | None,
        auto_clear: bool = True) -> None: ...

    def execute(  # type: ignore[misc] # an argument has several names
        self, callback: Any = None, part_callback: Any = None, auto_clear: bool = True
    ) -> None:
        """
        Execute the trajectories that were added, one after the other; do not wait.

        Nothing happens where none were added: the last status stays, and no callback is called.

        :param callback: gets the status at the end, in another thread.
        :param part_callback: gets the number of each trajectory that has succeeded; an exception
            in it ends the execution.
        :param auto_clear: whether they are dropped afterwards.
        """
        if isinstance(part_callback, bool):
            part_callback, auto_clear = None, part_callback
        self._cpp.check()
        if not self._parts:
            return
        self._begin()
        parts = tuple(self._parts)

        def run() -> None:
            status = self._run(parts, part_callback)
            if auto_clear:
                self._parts.clear()
            self._status = status
            self._idle.set()
            if callback is not None:
                callback(status)

        threading.Thread(target=run, name='moveit_py_execution', daemon=True).start()

    def execute_and_wait(self, auto_clear: bool = True) -> ExecutionStatus:
        """Execute the trajectories that were added and return the last status."""
        self.execute(None, None, auto_clear)
        return self.wait_for_execution()

    def wait_for_execution(self) -> ExecutionStatus:
        """Wait for the end of what is executed, and return its status; Ctrl-C stops it."""
        with interruptible():
            try:
                while not self._idle.wait(0.1):
                    pass
            except KeyboardInterrupt:
                self._stop.set()
                self._idle.wait(0.3)
                raise
        return self._status

    def stop_execution(self, auto_clear: bool = True) -> None:
        """
        Stop what is executed, and wait until it has ended; without an execution nothing happens.

        :param auto_clear: whether the trajectories that were added are dropped.
        """
        if self._idle.is_set():
            return
        self._stop.set()
        self.wait_for_execution()
        if auto_clear:
            self._parts.clear()

    def get_last_execution_status(self) -> ExecutionStatus:
        """Return the status of the last execution; RUNNING while it goes on."""
        return self._status

    def process_event(self, event: str) -> None:
        """Do what an event of ``trajectory_execution_event`` does: stop."""
        if event == 'stop':
            self.stop_execution()
        else:
            logger().warning(f"process_event: '{event}' is not known; allowed: stop")

    def _begin(self) -> None:
        """Stop what is executed; from now on there is an execution."""
        self.stop_execution(auto_clear=False)
        self._idle.clear()
        self._stop.clear()
        self._status = ExecutionStatus('RUNNING')

    def _run(self, parts: Sequence[_Part], done: PartCallback | None) -> ExecutionStatus:
        try:
            for place, (trajectory, multi_dof, names) in enumerate(parts):
                status = self._cpp.wait(self._cpp.submit(
                    lambda: self._outcome(trajectory, names, multi_dof)))  # noqa: B023 - waited for
                if not status:
                    return status
                if done is not None:
                    done(place)
        except (PlanningError, RuntimeError) as error:
            logger().error(f'execute: {error}')
        except Exception:  # noqa: BLE001 - the script waits for the status
            logger().error(f'execute: {traceback.format_exc()}')
        else:
            return ExecutionStatus('SUCCEEDED')
        return ExecutionStatus('ABORTED')

    def _execute_now(self, trajectory: JointTrajectory, names: Sequence[str]) -> ExecutionStatus:
        """Execute a trajectory at once and wait; Ctrl-C cancels it."""
        self._begin()
        try:
            self._status = self._cpp.call(
                lambda: self._outcome(trajectory, names, None), cancel=self._stop.set)
        except BaseException:
            self._status = ExecutionStatus('PREEMPTED')
            raise
        finally:
            self._idle.set()
        return self._status

    async def _outcome(
        self, trajectory: JointTrajectory, names: Sequence[str],
        multi_dof: MultiDofTrajectory | None
    ) -> ExecutionStatus:
        outcome = await self._cpp.execution.run(
            trajectory, ExecutionWatch(cancelled=self._stop.is_set), tuple(names), multi_dof)
        if not outcome.success:
            logger().error(f'execute: {outcome.message}')
        return ExecutionStatus._of(MoveItErrorCode(outcome.code))

    # ---------------------------------------------------------------- controllers

    def is_managing_controllers(self) -> bool:
        """Return whether controllers are activated where a trajectory needs them."""
        return self._cpp.context.execution_settings.moveit_manage_controllers

    def ensure_active_controllers_for_group(self, group: str) -> bool:
        """
        Activate controllers that move the joints of a group, where that is allowed.

        :raises PlanningError: there is no such group.
        """
        model = self._cpp.context.scene.kinematic_model
        model.group_indices(group)
        return self.ensure_active_controllers_for_joints(model.robot.semantic.groups[group].joints)

    def ensure_active_controllers_for_joints(self, joints: Sequence[str]) -> bool:
        """
        Activate controllers that move joints; return whether they are active.

        :param joints: fixed, passive and mimic joints, and unknown ones, are left out.
        """
        context, controllers = self._cpp.context, self._cpp.execution.controllers

        async def ensure() -> bool:
            await controllers.refresh()
            selected = select_controllers(
                actuated_joints(joints, context.robot), controllers.controllers,
                active=controllers.active,
                manages=context.execution_settings.moveit_manage_controllers)
            return await self._activated([each.name for each in selected])

        return self._ensured(ensure)

    def ensure_active_controller(self, controller: str) -> bool:
        """Activate a controller, where that is allowed; return whether it is active."""
        return self.ensure_active_controllers([controller])

    def ensure_active_controllers(self, controllers: Sequence[str]) -> bool:
        """Activate controllers, where that is allowed; return whether all are active."""
        async def ensure() -> bool:
            await self._cpp.execution.controllers.refresh()
            return await self._activated(list(controllers))

        return self._ensured(ensure)

    def is_controller_active(self, controller: str) -> bool:
        """Return whether a controller is active."""
        return self.are_controllers_active([controller])

    def are_controllers_active(self, controllers: Sequence[str]) -> bool:
        """Return whether all of these controllers are active."""
        known = self._cpp.execution.controllers

        async def active() -> bool:
            await known.refresh()
            running = known.active
            if running is None:  # no manager is asked: those of the configuration are
                running = frozenset(each.name for each in known.controllers)
            return running.issuperset(controllers)

        return self._cpp.call(active)

    async def _activated(self, names: list[str]) -> bool:
        known = self._cpp.execution.controllers
        listed = {each.name for each in known.controllers}
        unknown = [name for name in names if name not in listed]
        if unknown:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"controller '{unknown[0]}' is not known; known: {', '.join(sorted(listed))}")
        if known.active is None or known.active.issuperset(names):
            return True
        if not self.is_managing_controllers():
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                'moveit_manage_controllers is false; not active: '
                + ', '.join(name for name in names if name not in known.active))
        await known.switch(*controllers_to_switch(names, known.controllers, known.active))
        return known.active is None or known.active.issuperset(names)

    def _ensured(self, ensure: Callable[[], Awaitable[bool]]) -> bool:
        try:
            return self._cpp.call(ensure)
        except PlanningError as error:
            logger().error(f'controllers: {error}')
            return False

    # ---------------------------------------------------------------- settings

    def enable_execution_duration_monitoring(self, flag: bool) -> None:
        """Set whether a trajectory that takes longer than expected is cancelled."""
        self._set(execution_duration_monitoring=bool(flag))

    def execution_duration_monitoring(self) -> bool:
        """Return whether a trajectory that takes longer than expected is cancelled."""
        return self._cpp.context.execution_settings.execution_duration_monitoring

    def set_allowed_execution_duration_scaling(self, scaling: float) -> None:
        """Set how many times its duration a trajectory may take."""
        self._set(allowed_execution_duration_scaling=scaling)

    def allowed_execution_duration_scaling(self) -> float:
        """Return how many times its duration a trajectory may take."""
        return self._cpp.context.execution_settings.allowed_execution_duration_scaling

    def set_allowed_goal_duration_margin(self, margin: float) -> None:
        """Set how much longer a trajectory may take [s]."""
        self._set(allowed_goal_duration_margin=margin)

    def allowed_goal_duration_margin(self) -> float:
        """Return how much longer a trajectory may take [s]."""
        return self._cpp.context.execution_settings.allowed_goal_duration_margin

    def set_execution_velocity_scaling(self, scaling: float) -> None:
        """Set the factor of the velocities that are sent."""
        self._set(execution_velocity_scaling=scaling)

    def execution_velocity_scaling(self) -> float:
        """Return the factor of the velocities that are sent."""
        return self._cpp.context.execution_settings.execution_velocity_scaling

    def set_allowed_start_tolerance(self, tolerance: float) -> None:
        """Set how far a joint may be from a trajectory's start [rad or m]; 0: any distance."""
        self._set(allowed_start_tolerance=tolerance)

    def allowed_start_tolerance(self) -> float:
        """Return how far a joint may be from a trajectory's start [rad or m]."""
        return self._cpp.context.execution_settings.allowed_start_tolerance

    def set_wait_for_trajectory_completion(self, flag: bool) -> None:
        """Set whether an execution ends only when the robot is at rest."""
        self._set(wait_for_trajectory_completion=bool(flag))

    def wait_for_trajectory_completion(self) -> bool:
        """Return whether an execution ends only when the robot is at rest."""
        return self._cpp.context.execution_settings.wait_for_trajectory_completion

    def _set(self, **values: float | bool) -> None:
        context = self._cpp.context
        settings = context.execution_settings
        try:
            context.execution_settings = settings.model_validate(
                {**settings.model_dump(), **values})
        except ValidationError as error:
            raise ValueError(reason(error)) from None
