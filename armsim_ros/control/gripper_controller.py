# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The gripper action controllers: one joint moved to a position, with the word on stalling.

Goals and cancels come from any thread through a mailbox; goals end in the control loop's thread.
A goal has succeeded when the joint is nearer than ``goal_tolerance``; when it has been slower
than ``stall_velocity_threshold`` for ``stall_timeout`` it has stalled, which is a success only
where ``allow_stalling`` is set.
"""

from __future__ import annotations

from abc import abstractmethod
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import ClassVar, TypeVar

from armsim_ros.config.base import Settings
from armsim_ros.config.gripper_action_controller import (
    GripperActionControllerParameters,
    GripperParameters,
    ParallelGripperActionControllerParameters,
)
from armsim_ros.control.controller import Controller
from armsim_ros.control.hardware_interface import COMMAND_INTERFACES, EFFORT, POSITION
from armsim_ros.control.pid import Pid
from armsim_ros.control.trajectory_goal import ActionGoal, GoalStatus
from armsim_ros.errors import ControllerError

ParametersT = TypeVar('ParametersT', bound=GripperParameters)


@dataclass(frozen=True, slots=True)
class GripperResult:
    """
    How a gripper goal ended.

    :param position: measured [rad or m].
    :param velocity: measured [rad/s or m/s].
    :param effort: commanded, or the bound where a position is commanded [N*m or N].
    """

    position: float
    velocity: float
    effort: float
    stalled: bool
    reached_goal: bool


class GripperGoal(ActionGoal[GripperResult]):
    """
    A position to move to.

    :param position: [rad or m].
    :param effort: not to be exceeded, 0 for no bound [N*m or N].
    :param velocity: not to be exceeded, 0 for no bound [rad/s or m/s].
    """

    def __init__(self, position: float, effort: float, velocity: float = 0.0) -> None:
        """Keep what was asked for."""
        super().__init__()
        self.position = position
        self.effort = effort
        self.velocity = velocity


@dataclass(frozen=True, slots=True)
class GripperResponse:
    """The answer to a gripper goal; the reason says why it was refused."""

    accepted: bool
    reason: str = ''
    goal: GripperGoal | None = None


class GripperBase(Controller[ParametersT]):
    """What both kinds share: one joint, one goal at a time."""

    _goal: GripperGoal | None = None
    _target = 0.0
    _last_movement_ns = 0

    @property
    def joints(self) -> tuple[str, ...]:
        """The one joint."""
        return (self.parameters.joint,)

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """Position and velocity of the joint."""
        return tuple(f'{self.parameters.joint}/{kind}' for kind in ('position', 'velocity'))

    def configure(self) -> None:
        """Find the joint."""
        hardware, joint = self.context.hardware, self.parameters.joint
        if joint not in hardware.index:
            known = ', '.join(hardware.joint_names)
            raise ControllerError(f"joint '{joint}' is no joint of the hardware ({known})")
        self._index = hardware.index[joint]
        self._inbox: deque[tuple[GripperGoal, bool]] = deque()

    def activate(self, time_ns: int) -> None:
        """Hold the joint where it is."""
        self._abort_pending()
        self._target = float(self.context.hardware.state.position[self._index])

    def deactivate(self, time_ns: int) -> None:
        """Abort the goal."""
        self._end(GoalStatus.ABORTED)
        self._abort_pending()
        self._release()

    def update(self, time_ns: int, period: float) -> None:
        """Command the joint and look whether it has arrived."""
        self.time_ns = time_ns
        if self._inbox:
            self.process_requests(time_ns)
        self._command(period)
        if self._goal is not None:
            self._judge(time_ns)

    def process_requests(self, time_ns: int) -> None:
        """Take goals and cancels up."""
        while self._inbox:
            goal, cancels = self._inbox.popleft()
            if cancels:
                if goal is self._goal:
                    self._target = float(self.context.hardware.state.position[self._index])
                    self._end(GoalStatus.CANCELED)
                continue
            self._end(GoalStatus.CANCELED)
            goal.execute()
            self._goal, self._target = goal, goal.position
            self._last_movement_ns = time_ns

    def cancel(self, goal: GripperGoal) -> bool:
        """Cancel a goal and hold; False where it has ended already."""
        if not goal.request_cancel():
            return False
        self._inbox.append((goal, True))
        return True

    def _accept(self, goal: GripperGoal) -> GripperResponse:
        reason = ''
        if not self.active:
            reason = f"controller '{self.name}' is {self.state.value}, only an active one moves"
        for value in (goal.position, goal.effort, goal.velocity):
            if not math.isfinite(value):
                reason = f'{value} in the command; allowed: finite numbers'
        if reason:
            return self._refuse(reason)
        self._inbox.append((goal, False))
        if not self.active:
            self._abort_pending()
        return GripperResponse(True, goal=goal)

    def _refuse(self, reason: str) -> GripperResponse:
        self.events.add(self.time_ns, 'error', 'goal_rejected', f'goal rejected: {reason}')
        return GripperResponse(False, reason)

    def _judge(self, time_ns: int) -> None:
        parameters, state = self.parameters, self.context.hardware.state
        if abs(self._target - state.position[self._index]) < parameters.goal_tolerance:
            self._end(GoalStatus.SUCCEEDED, reached=True)
        elif abs(state.velocity[self._index]) > parameters.stall_velocity_threshold:
            self._last_movement_ns = time_ns
        elif (time_ns - self._last_movement_ns) * 1e-9 >= parameters.stall_timeout:
            allowed = parameters.allow_stalling
            self._end(GoalStatus.SUCCEEDED if allowed else GoalStatus.ABORTED, stalled=True)

    def _end(self, status: GoalStatus, *, reached: bool = False, stalled: bool = False) -> None:
        goal, self._goal = self._goal, None
        if goal is not None:
            goal.finish(status, self._result(reached=reached, stalled=stalled))

    def _result(self, *, reached: bool = False, stalled: bool = False) -> GripperResult:
        state, i = self.context.hardware.state, self._index
        return GripperResult(
            float(state.position[i]), float(state.velocity[i]), self._effort(), stalled, reached
        )

    def _abort_pending(self) -> None:
        while self._inbox:
            goal, cancels = self._inbox.popleft()
            if not cancels:
                goal.finish(GoalStatus.ABORTED, self._result())

    @abstractmethod
    def _command(self, period: float) -> None:
        """Write the command of one update."""

    @abstractmethod
    def _release(self) -> None:
        """Stop all but positions."""

    @abstractmethod
    def _effort(self) -> float:
        """Return the effort for the result [N*m or N]."""


class GripperController(GripperBase[GripperActionControllerParameters]):
    """``position_controllers/`` and ``effort_controllers/GripperActionController``."""

    parameters_class: ClassVar[type[Settings]] = GripperActionControllerParameters
    kind = 'gripper_command'
    _pid: Pid | None = None
    _output = 0.0

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """Effort for the effort kind, else position."""
        effort = self.type.startswith('effort')
        return (f'{self.parameters.joint}/{EFFORT if effort else POSITION}',)

    def configure(self) -> None:
        """Find the joint, and make the PID of the effort kind."""
        super().configure()
        parameters = self.parameters
        effort = self.type.startswith('effort')
        self._pid = Pid(parameters.gains[parameters.joint]) if effort else None

    def activate(self, time_ns: int) -> None:
        """Hold the joint where it is."""
        super().activate(time_ns)
        self._bound = self.parameters.max_effort
        if self._pid is not None:
            self._pid.reset()

    def send_goal(self, position: float, max_effort: float = 0.0) -> GripperResponse:
        """
        Take a goal, which replaces a running one, or refuse it.

        :param position: [rad or m].
        :param max_effort: 0 takes the parameter's [N*m or N].
        """
        return self._accept(GripperGoal(position, max_effort or self.parameters.max_effort))

    def _command(self, period: float) -> None:
        hardware, i = self.context.hardware, self._index
        if self._goal is not None:
            self._bound = abs(self._goal.effort)
        if self._pid is None:
            hardware.command.position[i] = self._target
            return
        error = self._target - float(hardware.state.position[i])
        output = self._pid.compute(error, -float(hardware.state.velocity[i]), period)
        self._output = max(-self._bound, min(self._bound, output))
        hardware.command.effort[i] = self._output

    def _release(self) -> None:
        if self._pid is not None:
            self.context.hardware.command.effort[self._index] = 0.0

    def _effort(self) -> float:
        return self._output if self._pid is not None else self._bound


class ParallelGripperController(GripperBase[ParallelGripperActionControllerParameters]):
    """``parallel_gripper_action_controller/GripperActionController``."""

    parameters_class: ClassVar[type[Settings]] = ParallelGripperActionControllerParameters
    kind = 'parallel_gripper_command'

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """Position, and the interfaces for effort and velocity where they are named."""
        parameters = self.parameters
        bounds = (parameters.max_effort_interface, parameters.max_velocity_interface)
        return (f'{parameters.joint}/{POSITION}', *(name for name in bounds if name))

    def send_goal(
        self,
        positions: Sequence[float],
        velocities: Sequence[float] = (),
        efforts: Sequence[float] = (),
    ) -> GripperResponse:
        """
        Take a goal, which replaces a running one, or refuse it.

        :param positions: exactly one [rad or m].
        :param velocities: at most one, used where max_velocity_interface is set [rad/s or m/s].
        :param efforts: at most one, used where max_effort_interface is set [N*m or N].
        """
        if len(positions) != 1:
            return self._refuse(f'the command has {len(positions)} positions; allowed: 1')
        effort = efforts[0] if efforts else self.parameters.max_effort
        velocity = velocities[0] if velocities else self.parameters.max_velocity
        return self._accept(GripperGoal(positions[0], effort, velocity))

    def _command(self, period: float) -> None:
        self.context.hardware.command.position[self._index] = self._target
        goal, parameters = self._goal, self.parameters
        self._write(parameters.max_effort_interface,
                    goal.effort if goal is not None else parameters.max_effort)  # fmt: skip
        self._write(parameters.max_velocity_interface,
                    goal.velocity if goal is not None else parameters.max_velocity)  # fmt: skip

    def _write(self, interface: str, value: float) -> None:
        joint, _, kind = interface.rpartition('/')
        if kind in COMMAND_INTERFACES:
            hardware = self.context.hardware
            hardware.command.of(kind)[hardware.index[joint]] = value

    def _release(self) -> None:
        for name in (self.parameters.max_effort_interface, self.parameters.max_velocity_interface):
            self._write(name, 0.0)

    def _effort(self) -> float:
        return self._goal.effort if self._goal is not None else self.parameters.max_effort
