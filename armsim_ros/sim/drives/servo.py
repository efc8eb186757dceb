# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The drives of the joints: commands in, inputs of the physics' own actuators out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.control.hardware_interface import JointArrays
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.sim.drives.drive_modes import count_moving, DriveGains, Followed, TUNING_STEPS
from armsim_ros.sim.drives.inverse_dynamics import InverseDynamics, PeriodBasis, product, stride_of
from armsim_ros.sim.drives.reference import CommandInterpolator, DrivenLimits, fingers_driven
from armsim_ros.sim.physics.saved_state import Restorable

#: From a cubic's factors to Bernstein's coefficients of its velocity, then of itself.
_BERNSTEIN = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0], [0.0, 1.0, 2.0, 3.0],
                       [1.0, 1 / 3, 0.0, 0.0], [1.0, 2 / 3, 1 / 3, 0.0], [1.0, 1.0, 1.0, 1.0]])


class Servo(Restorable):
    """
    A drive per joint: inverse dynamics of the reference plus PID on the error.

    The physics' actuators make p and d themselves (``u - p*q - d*v``, clamped to the effort
    limit); ``u`` is what this class gives them: the inverse dynamics, and p and d of the
    reference. The reference is a position for each physics step; its velocity and acceleration
    are the differences that the integrator itself makes of it, so that in free motion the plant
    lands on every reference. All arrays hold the active joints in the model's order.

    A velocity command moves the reference on; an effort command is the torque itself (a vendor's
    driver, unlike a simulator's, compensates gravity). An effort beside a position is added to the
    drive's own torque. A joint that is unclaimed or has no given effort holds its position.

    :param model: the robot.
    :param settings: timestep, servo.
    :param gains: joint -> gains of its controller; a block without any gain counts as none.
    :param tune: takes p and d of the actuators (n,) whenever they change.
    :param weights: (n,) the robot's greatest weight on each joint [N*m or N].
    """

    unchanging = frozenset({
        'joint_names', 'limits', 'dynamics', 'gains', 'compensated', '_tune', '_weightless',
        '_basis', '_period_bounds'})

    def __init__(
        self,
        model: RobotModel,
        settings: SimulationSettings,
        gains: Mapping[str, PidGains],
        tune: Callable[[Vector, Vector], None],
        weights: Vector,
    ) -> None:
        self.joint_names = model.active_joints
        self.limits = DrivenLimits.of(model)
        self._fingers = fingers_driven(model)
        self.dynamics = InverseDynamics(model, settings)
        self.gains = DriveGains(self.joint_names, settings, gains, weights)
        self._feedforward = settings.servo.feedforward
        given = settings.servo.gravity_compensation
        self.compensated = (model.externally_driven_joints if given is None
                            else frozenset(self.joint_names if given else ()))
        self._weightless = [name in self.compensated for name in self.joint_names]
        self._timestep = settings.timestep
        self._tune = tune
        self._basis: PeriodBasis | None = None
        self._period_bounds: tuple[int, Matrix, Matrix] | None = None
        count = len(self.joint_names)
        self._followed = Followed.of(self.joint_names, {})
        self._follows_effort: Mask = np.zeros(count, dtype=np.bool_)
        self._unknown = np.full(count, np.nan)
        self._velocity_command = np.zeros(count)
        self._effort_command = np.zeros(count)
        self._integral = np.zeros(count)
        self._interpolator = CommandInterpolator(np.zeros(count))
        self._sort_modes()
        self.restart(np.zeros(count))

    @property
    def resting(self) -> bool:
        """Whether the inputs stay as they are as long as the commands do."""
        return self._resting

    @property
    def reference(self) -> Vector:
        """Where the drives want the joints to be now (n,) [rad or m]."""
        reference: Vector = self._references[self._row]
        return reference

    def restart(self, position: Vector) -> None:
        """Rest at a position (n,) [rad or m]; commands and integrals are forgotten."""
        zero = np.zeros_like(position)
        self._target = position.copy()
        self._measured = position.copy()
        self._wanted = np.empty((0, len(position)))
        self._velocity_command, self._effort_command = zero.copy(), zero.copy()
        self._integral = zero.copy()
        self._interpolator.restart(position, np.ones(len(position), dtype=np.bool_))
        self._references, self._velocities, self._row = position[None].copy(), zero[None], 0
        self._stride, self._counts, self._counted = 1, [0], 0
        self._commands, self._steps = self._references[:0], 1
        self._tunings: dict[int, Vector] = {}
        self._inertias = self.dynamics.at_rest(self._references)[1]
        self._follow_inertia()

    def set_gains(self, gains: Mapping[str, PidGains]) -> None:
        """Work with other gains of some joints from the next step on."""
        self.gains.change(gains)
        self._sort_modes()
        self._follow_inertia()

    def set_payload(self, body: str, mass: float, centre: Sequence[float]) -> None:
        """Compensate a load from the next step on, see ``InverseDynamics.set_payload``."""
        self.dynamics.set_payload(body, mass, centre)
        self._drop_plan()

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
            self._follow_effort(self._followed.effort & given)
            acting = self._follows_effort | (self._followed.effort_added & given)
            self._effort_command = np.where(acting, command.effort * self._fingers, 0.0)
        requested = command.position
        if self._only_positions and float(requested.dot(requested)) < np.inf:
            self._target = requested.copy()
            follows = self._followed.position
        else:
            follows = self._followed.position & np.isfinite(requested)
            self._target = np.where(follows, requested, self._target)
        velocity = acceleration = self._unknown
        if steps > 1 and self._only_references and follows is self._followed.position:
            velocity, acceleration = feedforward.velocity, feedforward.acceleration
        elif steps > 1:
            given = self._followed.velocity_given
            velocity = np.where(given, command.velocity, feedforward.velocity)
            acceleration = np.where(given, command.acceleration, feedforward.acceleration)
            velocity = np.where(follows, velocity, np.nan)
            acceleration = np.where(follows, acceleration, np.nan)
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
        if not (self._only_references and self._feedforward) or self._needs_state:
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
            self._basis = basis = PeriodBasis(steps, self._timestep, implicit=self.gains.implicit)
        start, velocity = self.reference, self._velocities[self._row]
        features = self._interpolator.cubic(target, start, velocity, steps * self._timestep)
        references, velocities = basis.motion(features)
        if not self._allows(features, references, velocities, steps):
            # A straight line is slower than the curve.
            features[1], features[2:4] = target - start, 0.0
            references, velocities = basis.motion(features)
            if not self._allows(features, references, velocities, steps):
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

    def _allows(
        self, features: Matrix, references: Matrix, velocities: Matrix, steps: int
    ) -> bool:
        """Return whether the motion of features (5, n) is within the limits."""
        limits = self.limits
        # Bernstein's coefficients bound a polynomial; that is enough mostly.
        bounds = product(_BERNSTEIN, features[:4])
        least, most = self._allowed(steps)
        if ((bounds >= least) & (bounds <= most)).all():
            return True
        return bool((np.abs(velocities[1:]) * self._timestep <= self._longest_step).all()
                    and (references >= limits.lower).all()
                    and (references <= limits.upper).all())

    def _allowed(self, steps: int) -> tuple[Matrix, Matrix]:
        """Return between which rows those of ``_BERNSTEIN`` are within the limits."""
        if self._period_bounds is None or self._period_bounds[0] != steps:
            farthest = steps * self._timestep * self.limits.velocity
            self._period_bounds = (
                steps, np.stack((*[-farthest] * 3, *[self.limits.lower] * 3)),
                np.stack((*[farthest] * 3, *[self.limits.upper] * 3)))
        return self._period_bounds[1:]

    def _tune_if_due(self) -> None:
        """Follow the inertias: they change slowly, and the actuators' d has to be the plan's."""
        if self._untuned >= TUNING_STEPS:
            self._follow_inertia()

    def can_plan(self, steps: int) -> bool:
        """Return whether ``plan`` takes commands of periods of so many steps."""
        known = self._only_references if steps > 1 else self._only_positions
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
        if self._untuned >= TUNING_STEPS:
            self._follow_inertia()
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

    @property
    def planned_steps(self) -> int:
        """Steps whose inputs are known."""
        return len(self._inputs) - self._row

    def planned(self, steps: int) -> tuple[Matrix, Mapping[int, Vector]]:
        """Return inputs (k, n) of the next steps, and d (n,) of the actuators from some on."""
        begin, end = self._row, self._row + steps
        tunings = {row - begin: d for row, d in self._tunings.items() if begin <= row < end}
        return self._inputs[begin:end], tunings

    def pass_steps(self, steps: int) -> None:
        """Take note of steps that were done as planned."""
        self._row += steps
        for row in [row for row in self._tunings if row < self._row]:
            self._damping, self._counted = self._tunings.pop(row), self._counts[row]

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

    def stiffness_warnings(self) -> list[str]:
        """Return a line for each joint whose gains are too high for the timestep."""
        inertias = self.dynamics.joint_inertias(self._inertias[[self._row // self._stride]])
        return self.gains.stiffness_warnings(inertias[0])

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
        self._resting = velocities.tobytes() == bytes(velocities.nbytes)

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

    def _set_plan(self, references: Matrix, velocities: Matrix, steps: int) -> None:
        """Find the inputs for references (k + 1, n), the first is where they are now."""
        before = references[:-1]
        accelerations = (velocities[1:] - velocities[:-1]) / self._timestep
        stride = stride_of(steps)
        if stride > 1:
            inputs, inertias = self.dynamics.torques_between(
                references, velocities, accelerations, stride)
        else:
            inputs, inertias = self.dynamics.torques(before, velocities[:-1], accelerations)
            # What is known after a step is the inertia before it.
            now = self._inertias[self._row // self._stride]
            inertias = np.concatenate((now[None], inertias))
        self._counts, tuned = count_moving(velocities[1:], self._untuned, steps)
        self._references, self._velocities, self._row = references, velocities, 0
        self._inertias, self._stride, self._steps = inertias, stride, steps
        self._tunings, self._counted = {}, 0
        damping = self._damping
        if tuned:
            dampings = np.concatenate((damping[None], self._damping_at(tuned)))
            self._tunings = dict(zip(tuned, dampings[1:], strict=True))
            lengths = [end - row for row, end in pairwise((0, *tuned, len(before)))]
            damping = np.repeat(dampings, lengths, axis=0)
        if not self._feedforward:
            inputs = np.zeros_like(before)
        inputs += self._stiffness * before
        inputs += damping * (velocities[1:] if self.gains.implicit else velocities[:-1])
        if self._any_effort:
            inputs[:, self._follows_effort] = 0.0
            if (weightless := self._follows_effort & self._weightless).any():
                inputs[:, weightless] = self.dynamics.at_rest(before)[0][:, weightless]
            inputs += self._effort_command
        self._inputs = inputs

    def _follow_inertia(self) -> None:
        """Give the actuators their gains, d for the inertias at the last reference."""
        self._drop_plan()
        self._stiffness = np.where(self._follows_effort, 0.0, self.gains.p)
        self._damping = self._damping_at([0])[0]
        self._tune(self._stiffness, self._damping)
        self._counts = [0]

    @property
    def _untuned(self) -> int:
        """Steps that moved a joint since the actuators' gains were set."""
        return self._counts[self._row] - self._counted

    def _damping_at(self, rows: Sequence[int]) -> Matrix:
        """Return d of the actuators (k, n) for the inertias known after so many steps."""
        own = self.dynamics.joint_inertias(self._inertias[[row // self._stride for row in rows]])
        damping = self.gains.damping(own)
        return np.where(self._follows_effort, 0.0, damping) if self._any_effort else damping

    def _drop_plan(self) -> None:
        """Plan anew from where the reference is now."""
        row = self._row
        self._references = self._references[row : row + 1]
        self._velocities = self._velocities[row : row + 1]
        self._inertias = self._inertias[row // self._stride :][:1]
        self._inputs, self._tunings = self._references[:0], {}
        self._counts, self._counted = [self._untuned], 0
        self._row, self._stride = 0, 1
        self._resting = False

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
        self._only_positions = bool(followed.position.all())
        # No claim but positions: what else is known of the reference comes as feed-forward.
        self._only_references = self._only_positions and not followed.velocity_given.any()
        self._any_velocity = bool(followed.velocity.any())
        self._any_effort = bool(followed.effort.any() or followed.effort_added.any())
        self._needs_state = bool(
            self._any_velocity or self._follows_effort.any() or self.gains.integrate)
        # A velocity command is bounded itself; its reference must keep up with a dragged joint.
        self._longest_step = np.where(
            followed.velocity, np.inf, self._timestep * self.limits.velocity)
        with np.errstate(divide='ignore', invalid='ignore'):
            self._step_weights = 1.0 / self._longest_step
            reach = self.limits.effort / self.gains.p
        self._reach = np.where(np.isfinite(reach), reach, np.inf)
