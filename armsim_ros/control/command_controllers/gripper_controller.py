# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The gripper action controllers: position, effort and parallel."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import ClassVar, TypeVar

from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.gripper_action_controller import (
    GripperActionControllerParameters,
    GripperParameters,
    ParallelGripperActionControllerParameters,
)
from armsim_ros.control.command_writer import Pid
from armsim_ros.control.controller import Controller, NEVER_NS
from armsim_ros.control.hardware_interface import EFFORT, POSITION
from armsim_ros.control.mailbox import ActionGoal, GoalStatus, Mailbox
from armsim_ros.errors import ControllerError


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
        super().__init__()
        self.position, self.effort, self.velocity = position, effort, velocity


@dataclass(frozen=True, slots=True)
class GripperResponse:
    """The answer to a gripper goal; with the reason of a refusal."""

    accepted: bool
    reason: str = ''
    goal: GripperGoal | None = None


ParametersT = TypeVar('ParametersT', bound=GripperParameters)


class GripperBase(Controller[ParametersT]):
    """One joint, one goal at a time."""

    _goal: GripperGoal | None = None
    _target = 0.0
    _last_movement_ns = 0
    #: The drive gives no more, also while it holds what it has grasped; 0 is its own limit.
    _bound = 0.0
    #: Whether the last update wrote what the next would write, too.
    _calm = False

    @property
    def joints(self) -> tuple[str, ...]:
        """The joint."""
        return (self.parameters.joint,)

    @property
    def moves_arm(self) -> bool:
        """False: a gripper has drives of its own, and keeps what it holds."""
        return False

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """Position and velocity of the joint."""
        return tuple(f'{self.parameters.joint}/{kind}' for kind in ('position', 'velocity'))

    def configure(self) -> None:
        """Find the joint."""
        hardware, joint = self.context.hardware, self.parameters.joint
        if joint not in hardware.index:
            known = ', '.join(hardware.joint_names)
            raise ControllerError(f"joint '{joint}' is not a joint of the hardware ({known})")
        self._index = hardware.index[joint]
        self._inbox: Mailbox[tuple[GripperGoal, bool]] = Mailbox(self.context.wake)

    def activate(self, time_ns: int) -> None:
        """Hold the joint where it is."""
        self._abort_pending()
        self._calm = False
        self._target = float(self.context.hardware.state.position[self._index])
        self._bound = self._default_bound

    def deactivate(self, time_ns: int) -> None:
        """Abort the goal."""
        self._end(GoalStatus.ABORTED)
        self._abort_pending()
        self.context.hardware.effort_bound[self._index] = math.inf
        self._release()

    def update(self, time_ns: int, period: float) -> None:
        """Command the joint and look whether it has arrived."""
        self.time_ns = time_ns
        if self._inbox:
            self.process_requests(time_ns)
        self._calm = self._goal is None
        self.context.hardware.effort_bound[self._index] = self._bound or math.inf
        self._command(period)
        if self._goal is not None:
            self._check_end(time_ns)

    def next_update(self, time_ns: int) -> int:
        """Return from when on an update matters [ns]: never without a goal."""
        return NEVER_NS if self._calm and not self._inbox else time_ns

    def process_requests(self, time_ns: int) -> None:
        """Take goals and cancels up."""
        for goal, cancels in self._inbox.take_all():
            if cancels:
                if goal is self._goal:
                    self._target = float(self.context.hardware.state.position[self._index])
                    self._bound = self._default_bound
                    self._end(GoalStatus.CANCELED)
                continue
            self._end(GoalStatus.CANCELED)
            goal.execute()
            self._goal, self._target = goal, goal.position
            self._bound = abs(goal.effort)
            self._last_movement_ns = time_ns

    @abstractmethod
    def close_to(self, position: float, effort: float) -> GripperResponse:
        """
        Take a goal, which replaces a running goal, or refuse it.

        :param position: [rad or m].
        :param effort: not to be exceeded [N*m or N]; 0 leaves it to the parameters.
        """

    def cancel(self, goal: GripperGoal) -> bool:
        """Cancel a goal and hold; False where it has ended already."""
        if not goal.request_cancel():
            return False
        self._inbox.post((goal, True))
        return True

    def _accept(self, goal: GripperGoal) -> GripperResponse:
        reason = ''
        if not self.active:
            reason = f"controller '{self.name}' is {self.state.value}; only active ones move"
        for value in (goal.position, goal.effort, goal.velocity):
            if not math.isfinite(value):
                reason = f'{value} in the command; allowed: finite numbers'
        if reason:
            return self._refuse(reason)
        self._inbox.post((goal, False))
        if not self.active:
            self._abort_pending()
        return GripperResponse(True, goal=goal)

    def _refuse(self, reason: str) -> GripperResponse:
        self.events.add(self.time_ns, 'error', 'goal_rejected', f'goal rejected: {reason}')
        return GripperResponse(False, reason)

    def _check_end(self, time_ns: int) -> None:
        parameters, state = self.parameters, self.context.hardware.state
        if abs(self._target - state.position[self._index]) < parameters.goal_tolerance:
            self._end(GoalStatus.SUCCEEDED, reached=True)
        elif abs(state.velocity[self._index]) > parameters.stall_velocity_threshold:
            self._last_movement_ns = time_ns
        elif (time_ns - self._last_movement_ns) * 1e-9 > parameters.stall_timeout:
            allowed = parameters.allow_stalling
            self._end(GoalStatus.SUCCEEDED if allowed else GoalStatus.ABORTED, stalled=True)

    def _end(self, status: GoalStatus, *, reached: bool = False, stalled: bool = False) -> None:
        goal, self._goal = self._goal, None
        if goal is not None:
            goal.finish(status, self._result(reached=reached, stalled=stalled))

    def _result(self, *, reached: bool = False, stalled: bool = False) -> GripperResult:
        state, i = self.context.hardware.state, self._index
        return GripperResult(
            float(state.position[i]), float(state.velocity[i]), self._effort(), stalled, reached)

    def _abort_pending(self) -> None:
        for goal, cancels in self._inbox.take_all():
            if not cancels:
                goal.finish(GoalStatus.ABORTED, self._result())

    @property
    @abstractmethod
    def _default_bound(self) -> float:
        """Effort of a goal that names none [N*m or N]; 0 is the drive's own limit."""

    @abstractmethod
    def _command(self, period: float) -> None:
        """Write the command of an update."""

    @abstractmethod
    def _release(self) -> None:
        """Stop all but positions."""

    def _effort(self) -> float:
        """Return the effort for the result [N*m or N]."""
        return self._bound


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
        self._adopted = self.parameters
        effort = self.type.startswith('effort')
        self._pid = Pid(self._adopted.gains[self._adopted.joint]) if effort else None

    def activate(self, time_ns: int) -> None:
        """Hold the joint where it is."""
        super().activate(time_ns)
        if self._pid is not None:
            self._pid.reset()

    def next_update(self, time_ns: int) -> int:
        """Return from when on an update matters [ns]: always where an effort holds the joint."""
        return super().next_update(time_ns) if self._pid is None else time_ns

    def send_goal(self, position: float, max_effort: float = 0.0) -> GripperResponse:
        """
        Take a goal, which replaces a running goal, or refuse it.

        :param position: [rad or m].
        :param max_effort: 0 takes the parameter's [N*m or N].
        """
        return self._accept(GripperGoal(position, max_effort or self._default_bound))

    def close_to(self, position: float, effort: float) -> GripperResponse:
        """Take a goal of a position and an effort."""
        return self.send_goal(position, effort)

    def _command(self, period: float) -> None:
        hardware, i = self.context.hardware, self._index
        if self._pid is None:
            hardware.command.position[i] = self._target
            return
        if self.parameters is not self._adopted:
            self._adopted = self.parameters
            self._pid.set_gains(self._adopted.gains[self._adopted.joint])
        error = self._target - float(hardware.state.position[i])
        output = self._pid.compute(error, -float(hardware.state.velocity[i]), period)
        self._output = max(-self._bound, min(self._bound, output))
        hardware.command.effort[i] = self._output

    def _release(self) -> None:
        if self._pid is not None:
            self.context.hardware.command.effort[self._index] = 0.0

    @property
    def _default_bound(self) -> float:
        """The parameter's effort."""
        return self.parameters.max_effort

    def _effort(self) -> float:
        return self._output if self._pid is not None else super()._effort()


class ParallelGripperController(GripperBase[ParallelGripperActionControllerParameters]):
    """``parallel_gripper_action_controller/GripperActionController``."""

    parameters_class: ClassVar[type[Settings]] = ParallelGripperActionControllerParameters
    kind = 'parallel_gripper_command'
    #: The present command of the drive, on the way to the target [rad or m].
    _reference = 0.0
    #: The target that it is on the way to [rad or m].
    _way_to = 0.0
    #: The joint's speed is not to exceed it [rad/s or m/s].
    _fastest = math.inf

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """Position, and the interfaces for effort and velocity where they are named."""
        parameters = self.parameters
        bounds = (parameters.max_effort_interface, parameters.max_velocity_interface)
        return (f'{parameters.joint}/{POSITION}', *(name for name in bounds if name))

    def send_goal(
        self, positions: Sequence[float], velocities: Sequence[float] = (),
        efforts: Sequence[float] = ()
    ) -> GripperResponse:
        """
        Take a goal, which replaces a running goal, or refuse it.

        :param positions: exactly one [rad or m].
        :param velocities: at most one, not to be exceeded; used where max_velocity_interface is
            set, and 0 is no bound [rad/s or m/s].
        :param efforts: at most one, not to be exceeded [N*m or N].
        """
        if len(positions) != 1:
            return self._refuse(f'the command has {len(positions)} positions; allowed: 1')
        effort = efforts[0] if efforts else self._default_bound
        velocity = velocities[0] if velocities else self.parameters.max_velocity
        return self._accept(GripperGoal(positions[0], effort, velocity))

    def close_to(self, position: float, effort: float) -> GripperResponse:
        """Take a goal of a position and an effort."""
        return self.send_goal([position], [], [effort] if effort else [])

    def activate(self, time_ns: int) -> None:
        """Hold the joint where it is."""
        super().activate(time_ns)
        self._reference = self._way_to = self._target
        self._fastest = self._speed_bound(self.parameters.max_velocity)

    def next_update(self, time_ns: int) -> int:
        """Return from when on an update matters [ns]: never at the target without a goal."""
        return super().next_update(time_ns) if self._reference == self._target else time_ns

    def _command(self, period: float) -> None:
        hardware, i = self.context.hardware, self._index
        if self._goal is not None:
            self._fastest = self._speed_bound(self._goal.velocity)
        if self._way_to != self._target:
            # A grip is neither let go of to grip harder, nor has it to be undone before opening.
            near, far = sorted((self._reference, float(hardware.state.position[i])))
            self._reference = max(near, min(far, self._target))
            self._way_to = self._target
        step = self._fastest * period
        left = self._target - self._reference
        self._reference = (
            self._target if abs(left) <= step else self._reference + math.copysign(step, left))
        hardware.command.position[i] = self._reference

    def _release(self) -> None:
        """Do nothing: positions are all that is commanded."""

    def _speed_bound(self, velocity: float) -> float:
        """Return a velocity as a bound, inf where there is none but the drive's own."""
        return abs(velocity) or math.inf if self.parameters.max_velocity_interface else math.inf

    @property
    def _default_bound(self) -> float:
        """Effort of a goal that names none: the parameter's, where an interface is named."""
        return self.parameters.max_effort if self.parameters.max_effort_interface else 0.0
