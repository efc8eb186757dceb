# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A hand with two fingers and a drive of its own, beside the controllers of its arm.

It moves to a width, closes with a force, and holds what it has grasped until the next command.
What it has grasped at another width it lets go of, as Franka's hand does.
"""

from __future__ import annotations

from collections.abc import Sequence
import math

from armsim_ros.config.controllers.gripper_action_controller import (
    ParallelGripperActionControllerParameters,
)
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.control.command_controllers.gripper_controller import (
    GripperGoal,
    ParallelGripperController,
)
from armsim_ros.control.controller import ControllerContext, NEVER_NS
from armsim_ros.control.mailbox import GoalStatus

#: Stiff enough to press something thin with the whole force [N/m].
STIFFNESS = 20_000.0
#: A width that is missed by less is reached [m].
TOLERANCE = 0.001
#: Fingers that rest for so long have come to their end [s].
REST = 0.2


class HandGoal(GripperGoal):
    """
    Widths to move to, one after the other.

    :param widths: of the opening [m].
    :param speed: of the width [m/s].
    :param force: that each finger presses with, 0 for the drive's own [N].
    :param accepted: smallest and largest width that is a success once the fingers rest, and to
        which they are closed; None where the last width has to be reached [m].
    """

    def __init__(self, widths: Sequence[float], speed: float, force: float = 0.0,
                 accepted: tuple[float, float] | None = None) -> None:
        super().__init__(0.0 if accepted else 0.5 * widths[0], force, 0.5 * speed)
        self.widths = tuple(widths)
        self.later = list(widths[1:])
        self.accepted = accepted
        #: Why it failed, '' where the fingers came to another width.
        self.error = ''


class HandDrive(ParallelGripperController):
    """Drives the joint of a finger, whose sister mimics it; a device of a controller manager."""

    @classmethod
    def of(cls, name: str, joint: str, context: ControllerContext) -> HandDrive:
        """Return the configured drive of a finger's joint."""
        drive = cls(name, cls.__name__, ParallelGripperActionControllerParameters(
            joint=joint, goal_tolerance=0.5 * TOLERANCE, stall_timeout=REST), context)
        drive.configure()
        context.hardware.set_gains({joint: PidGains(p=STIFFNESS)})
        return drive

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """None: a device claims nothing."""
        return ()

    @property
    def width(self) -> float:
        """Measured width of the opening [m]."""
        return 2.0 * float(self.context.hardware.state.position[self._index])

    @property
    def widest(self) -> float:
        """Width of the open hand [m]."""
        model = self.context.model
        return 0.0 if model is None else 2.0 * model.joints[self.joints[0]].limits.upper

    def send(self, goal: HandGoal) -> HandGoal:
        """Take a goal, which replaces the running goal; a goal that cannot be has failed then."""
        low, high = -1e-6, self.widest + 1e-6
        if not all(low <= width <= high for width in goal.widths):
            self._fail(goal, f'the width {goal.widths[-1]:g} m is not allowed; allowed: 0 to '
                             f'{self.widest:g} m')
        elif not (0.0 < goal.velocity < math.inf and 0.0 <= goal.effort < math.inf):
            self._fail(goal, f'speed {2.0 * goal.velocity:g} m/s or force {goal.effort:g} N is '
                             'not allowed; allowed: above 0')
        else:
            self._inbox.post((goal, False))
        return goal

    def pass_over(self, goal: HandGoal) -> HandGoal:
        """End a goal that asks for nothing."""
        goal.finish(GoalStatus.SUCCEEDED, self._result(reached=True))
        return goal

    def halt(self) -> None:
        """End the goal, and the force of a grasp; in the control loop's thread."""
        self.process_requests(self.time_ns)
        self._fail(self._goal, 'the motion was stopped')
        self._rest()

    def process_requests(self, time_ns: int) -> None:
        """Take goals and cancels up."""
        for goal, cancels in self._inbox.take_all():
            if not cancels:
                self._fail(self._goal, 'another command replaced it')
                goal.execute()
                self._goal, self._bound = goal, goal.effort
                self._begin(goal.position, time_ns)
            elif goal is self._goal:
                self._stop('', GoalStatus.CANCELED)

    def update(self, time_ns: int, period: float) -> None:
        """Command the fingers, unless a controller does."""
        if not self.holder:
            super().update(time_ns, period)
            return
        self.time_ns = time_ns
        self.process_requests(time_ns)
        self._stop(f"controller '{self.holder}' commands the fingers; deactivate it")
        self.activate(time_ns)

    def next_update(self, time_ns: int) -> int:
        """Return from when on an update matters [ns]."""
        if self.holder and not self._inbox:
            return NEVER_NS
        return super().next_update(time_ns)

    def _begin(self, position: float, time_ns: int) -> None:
        self._target, self._last_movement_ns = position, time_ns

    def _stop(self, error: str, status: GoalStatus = GoalStatus.ABORTED) -> None:
        if self._goal is not None:
            self._rest()
            self._fail(self._goal, error, status)

    def _rest(self) -> None:
        """Stay where the fingers are, without a force."""
        position = float(self.context.hardware.state.position[self._index])
        self._target = self._reference = self._way_to = position
        self._calm = False
        self.context.wake()

    def _fail(self, goal: GripperGoal | None, error: str,
              status: GoalStatus = GoalStatus.ABORTED) -> None:
        if isinstance(goal, HandGoal):
            goal.error = error
            goal.finish(status, self._result())
        if goal is self._goal:
            self._goal = None

    def _check_end(self, time_ns: int) -> None:
        goal, state, i = self._goal, self.context.hardware.state, self._index
        assert isinstance(goal, HandGoal)
        position, tolerance = float(state.position[i]), self.parameters.goal_tolerance
        arrived = self._reference == self._target and abs(self._target - position) < tolerance
        if not (arrived and goal.accepted is None):
            follows = self._reference != self._target and (
                abs(self._reference - position) < tolerance)
            if follows or abs(state.velocity[i]) > self.parameters.stall_velocity_threshold:
                self._last_movement_ns = time_ns
            if (time_ns - self._last_movement_ns) * 1e-9 < self.parameters.stall_timeout:
                return
        if goal.later:
            self._begin(0.5 * goal.later.pop(0), time_ns)
            return
        low, high = goal.accepted or (-math.inf, math.inf if arrived else -math.inf)
        reached = low < 2.0 * position < high
        if not reached:
            self._rest()
        self._end(GoalStatus.SUCCEEDED if reached else GoalStatus.ABORTED,
                  reached=reached, stalled=not arrived)

    def _speed_bound(self, velocity: float) -> float:
        return abs(velocity) or math.inf

    @property
    def _default_bound(self) -> float:
        return 0.0
