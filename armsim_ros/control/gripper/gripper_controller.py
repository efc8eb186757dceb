# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The gripper action controllers: position, effort and parallel."""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import ClassVar

from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.gripper_action_controller import (
    GripperActionControllerParameters,
    ParallelGripperActionControllerParameters,
)
from armsim_ros.control.gripper.base import GripperBase, GripperGoal, GripperResponse
from armsim_ros.control.hardware_interface import EFFORT, POSITION
from armsim_ros.control.pid import Pid


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
        self,
        positions: Sequence[float],
        velocities: Sequence[float] = (),
        efforts: Sequence[float] = (),
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
            self._target if abs(left) <= step else self._reference + math.copysign(step, left)
        )
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
