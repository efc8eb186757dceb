# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The drives of the joints: commands in, inputs of the physics' own actuators out."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.control.hardware_interface import JointArrays
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.sim.drives.drive_modes import Followed, TUNING_STEPS
from armsim_ros.sim.drives.reference import (
    CommandInterpolator,
    DrivenLimits,
    fingers_driven,
    PeriodBasis,
)
from armsim_ros.sim.drives.reference_inputs import ReferenceInputs


class Servo(ReferenceInputs):
    """
    A drive per joint: inverse dynamics of the reference plus PID on the error.

    A velocity command moves the reference on; an effort command is the torque itself (a vendor's
    driver, unlike a simulator's, compensates gravity). An effort beside a position is added to the
    drive's own torque. A joint that is unclaimed or has no given effort holds its position, but
    an unactuated joint has no drive: it follows an effort of 0.

    The parameters are those of :class:`ReferenceInputs`.
    """

    unchanging = ReferenceInputs.unchanging | {'limits', '_basis'}

    def __init__(
        self, model: RobotModel, settings: SimulationSettings, gains: Mapping[str, PidGains],
        tune: Callable[[Vector, Vector], None], weights: Vector
    ) -> None:
        super().__init__(model, settings, gains, tune, weights)
        self.limits = DrivenLimits.of(model)
        self._fingers = fingers_driven(model)
        self._basis: PeriodBasis | None = None
        count = len(self.joint_names)
        self._followed = Followed.of(self.joint_names, {})
        self._velocity_command = np.zeros(count)
        self._integral = np.zeros(count)
        self._interpolator = CommandInterpolator(np.zeros(count))
        self._sort_modes()
        self.restart(np.zeros(count))

    def restart(self, position: Vector) -> None:
        """Rest at a position (n,) [rad or m]; commands and integrals are forgotten."""
        zero = np.zeros_like(position)
        self._target = position.copy()
        self._measured = position.copy()
        self._wanted = np.empty((0, len(position)))
        self._velocity_command, self._effort_command = zero.copy(), zero.copy()
        self._integral = zero.copy()
        self._interpolator.restart(position, np.ones(len(position), dtype=np.bool_))
        self._commands = position[None][:0]
        self._rest_at(position)

    def set_gains(self, gains: Mapping[str, PidGains]) -> None:
        """Work with other gains of some joints from the next step on."""
        self.gains.change(gains)
        self._sort_modes()
        self._follow_inertia()

    def scale_gains(self, factor: float) -> None:
        """Multiply p, i and d of all drives by a factor, from the next step on."""
        self.gains.scale(factor)
        self._sort_modes()
        self._follow_inertia()

    def switch(self, claimed: Mapping[str, frozenset[str]]) -> Vector:
        """
        Follow other interfaces from now on.

        :param claimed: joint -> claimed interfaces.
        :returns: (n,) where joints that followed velocities until now rest, NaN for the others.
        :raises SimulationError: interfaces that cannot be followed together; nothing changes.
        """
        followed = Followed.of(self.joint_names, claimed)
        changed = followed.changed(self._followed)
        positions = np.where(self._followed.velocity, self.reference, self._target)
        rest = np.where(self._follows_effort, self._measured, positions)
        left = np.where(changed & self._followed.velocity, self.reference, np.nan)
        self._target = np.where(changed, rest, self._target)
        self._interpolator.restart(self._target, changed)
        self._wanted = np.where(changed, rest, self._wanted)
        for values in (self._velocity_command, self._effort_command, self._integral):
            values[changed] = 0.0
        self._followed = followed
        self._follows_effort = self._follows_effort & ~changed
        self._sort_modes()
        self._follow_inertia()
        return left

    def write(self, command: JointArrays, feedforward: JointArrays, steps: int) -> None:
        """
        Take the commands of a control period.

        :param command: of the active joints; NaN leaves the joint where it is.
        :param feedforward: velocity and acceleration at the period's end, NaN where not known.
        :param steps: physics steps in the period.
        """
        if self._any_effort:
            given = np.isfinite(command.effort)
            self._follow_effort((self._followed.effort & given) | self._unactuated)
            acting = (self._followed.effort | self._followed.effort_added) & given
            self._effort_command = np.where(acting, command.effort * self._fingers, 0.0)
        self._target, velocity, acceleration = self._followed.references(
            command, feedforward, self._target, steps)
        self._wanted = self._interpolator.command(
            self._target, velocity, acceleration, steps, steps * self._timestep)
        if self._any_velocity:
            bounded = np.clip(command.velocity, -self.limits.velocity, self.limits.velocity)
            usable = self._followed.velocity & np.isfinite(bounded)
            self._velocity_command = np.where(usable, bounded, 0.0)
        self._drop_plan()

    def plan_written(self) -> bool:
        """
        Plan the steps of the commands that were written, unless they depend on what is measured.

        :returns: whether they are planned.
        """
        if self._needs_state:
            return False
        if self._row == len(self._inputs):
            self._tune_if_due()
            requested = self._wanted if len(self._wanted) else self._target[None]
            self._plan(requested, len(requested))
            self._wanted = self._wanted[:0]
        return True

    def plan_period(self, target: Vector, steps: int) -> bool:
        """
        Take the command of a period whose dynamics is computed at its two ends alone.

        :param target: (n,) where to be at its end [rad or m].
        :param steps: physics steps in it; their inputs are planned.
        :returns: False where ``write`` has to take it: the drives need what is measured, or the
            way is beyond the limits.
        """
        if not (self._followed.only_references and self._feedforward) or self._needs_state:
            return False
        if (untuned := self._untuned) >= TUNING_STEPS:
            # The gains follow the inertias; nothing follows an effort here.
            at = self._row // self._stride
            own = self.dynamics.joint_inertias(self._inertias[at:at + 1])
            self._damping = self.gains.damping(own)[0]
            self._tune(self._stiffness, self._damping)
            untuned, self._counted = 0, self._counts[self._row]
        basis = self._basis
        if basis is None or basis.steps != steps:
            self._basis = basis = PeriodBasis(
                steps, self._timestep, self.limits, implicit=self.gains.implicit)
        start, velocity = self.reference, self._velocities[self._row]
        features = self._interpolator.cubic(target, start, velocity, steps * self._timestep)
        references, velocities = basis.motion(features)
        if not basis.allows(features, references, velocities):
            # A straight line is slower than the curve.
            features[1], features[2:4] = target - start, 0.0
            references, velocities = basis.motion(features)
            if not basis.allows(features, references, velocities):
                self._drop_plan()
                return False
        references[-1] = target
        self._interpolator.go_on(1)
        first, change, bias, self._inertias = self.dynamics.loads_over(
            references[::steps], velocities[::steps], features[1:])
        inputs = basis.inputs(features, first, change, bias, self._stiffness, self._damping)
        if self.dynamics.has_friction:
            inputs += self.dynamics.friction(velocities[:-1], basis.accelerations(features))
        self._counts = list(range(untuned, untuned + steps + 1))
        self._references, self._velocities, self._row = references, velocities, 0
        self._stride, self._steps, self._tunings, self._counted = steps, steps, {}, 0
        self._target, self._inputs = target.copy(), inputs
        self._wanted = self._wanted[:0]
        return True

    def can_plan(self, steps: int) -> bool:
        """Return whether ``plan`` takes commands of periods of so many steps."""
        known = self._followed.only_references if steps > 1 else self._followed.only_positions
        return known and not self._needs_state

    def plan(
        self, commands: Matrix, velocities: Matrix, accelerations: Matrix, steps: int
    ) -> None:
        """
        Take the commands of some control periods, as if each were written before its period.

        :param commands: (k, n) positions, NaN leaves a joint where it is [rad or m].
        :param velocities: (k, n) at the periods' ends, NaN where not known [rad/s or m/s].
        :param accelerations: (k, n) at the same times [rad/s^2 or m/s^2].
        :param steps: physics steps in a period.
        """
        self._tune_if_due()
        finite = np.isfinite(commands)
        if not finite.all():
            # No command of these joints comes in any of the periods.
            commands = np.where(finite, commands, self._target)
            velocities = np.where(finite, velocities, np.nan)
            accelerations = np.where(finite, accelerations, np.nan)
        self._drop_plan()
        period = steps * self._timestep
        self._plan(
            self._interpolator.preview(commands, velocities, accelerations, steps, period), steps)
        self._commands, self._wanted = commands, self._wanted[:0]

    def end_plan(self) -> None:
        """Be where the steps that were done have led; forget those that were only planned."""
        if periods := self._row // self._steps:
            self._target = self._commands[periods - 1].copy()
            self._interpolator.go_on(periods)
        self._commands = self._commands[:0]
        if self._row < len(self._inputs):
            self._drop_plan()

    def next_inputs(self, position: Vector, velocity: Vector) -> Vector:
        """
        Return the actuators' inputs for the next physics step and move the reference on by it.

        :param position: (n,) measured [rad or m].
        :param velocity: (n,) measured [rad/s or m/s].
        :returns: (n,) [N*m or N].
        """
        if self._row == len(self._inputs):
            if self._needs_state:
                self._tune_if_due()
                self._plan_from_state(position, velocity)
            else:
                self.plan_written()
        inputs: Vector = self._inputs[self._row]
        self._row += 1
        return inputs

    def state_bytes(self) -> bytes:
        """Return all that the next inputs depend on besides the plant, for a digest."""
        parts = (self._references[self._row :], self._velocities[self._row], self._integral,
                 self._target, self._wanted, self._damping)
        return b''.join(part.tobytes() for part in parts)

    def _plan(self, requested: Matrix, steps: int) -> None:
        """
        Plan some steps at once, within the limits of position and velocity.

        :param requested: (k, n) where the reference is to be after each of them [rad or m].
        :param steps: in a control period; k holds a whole number of periods.
        """
        references = self.limits.bounded(
            self.reference, requested, self._longest_step, self._step_weights)
        velocities = np.empty_like(references)
        velocities[0] = self._velocities[self._row]
        np.subtract(references[1:], references[:-1], out=velocities[1:])
        velocities[1:] /= self._timestep
        self._set_plan(references, velocities, steps)
        self.resting = velocities.tobytes() == bytes(velocities.nbytes)

    def _plan_from_state(self, position: Vector, velocity: Vector) -> None:
        """Plan a step for drives that depend on what is measured."""
        h = self._timestep
        requested = self._wanted[0] if len(self._wanted) else self._target
        self._wanted = self._wanted[1:]
        self._measured = position.copy()
        if self._any_velocity:
            moved = self.reference + h * self._velocity_command
            # The reference waits for a joint that is blocked, within reach of its effort.
            moved = np.minimum(np.maximum(moved, position - self._reach), position + self._reach)
            requested = np.where(self._followed.velocity, moved, requested)
        references = self.limits.bounded(
            self.reference, requested[None], self._longest_step, self._step_weights)
        velocities = np.stack((self._velocities[self._row], references[1] - references[0]))
        velocities[1] /= h
        free = self._follows_effort
        if self._any_effort:
            references[:, free] = position[free], position[free] + h * velocity[free]
            velocities[:, free] = velocity[free]
        self._set_plan(references, velocities, 1)
        if self.gains.integrate:
            self._integral += self.gains.i * (references[0] - position) * h
            np.clip(self._integral, self.gains.integral_low, self.gains.integral_high,
                    out=self._integral)
            self._inputs[0] += np.where(free, 0.0, self._integral)

    def _follow_effort(self, following: Mask) -> None:
        """Follow the effort of these joints (n,); those that have none any more hold."""
        if not (following ^ self._follows_effort).any():
            return
        left = self._follows_effort & ~following
        if left.any():
            self._target = np.where(left, self._measured, self._target)
            self._interpolator.restart(self._target, left)
        self._follows_effort = following
        self._sort_modes()
        self._follow_inertia()

    def _sort_modes(self) -> None:
        followed = self._followed
        self._any_velocity = bool(followed.velocity.any())
        self._any_effort = bool(
            followed.effort.any() or followed.effort_added.any() or self._unactuated.any())
        self._needs_state = bool(
            self._any_velocity or self._follows_effort.any() or self.gains.integrate)
        # A velocity command is bounded itself; its reference must keep up with a dragged joint.
        self._longest_step = np.where(
            followed.velocity, np.inf, self._timestep * self.limits.velocity)
        with np.errstate(divide='ignore', invalid='ignore'):
            self._step_weights = 1.0 / self._longest_step
            reach = self.limits.effort / self.gains.p
        self._reach = np.where(np.isfinite(reach), reach, np.inf)
