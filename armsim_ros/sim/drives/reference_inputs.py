# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The inputs of the physics' actuators along a reference, and the gains of the actuators."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.sim.drives.drive_modes import count_moving, DriveGains, TUNING_STEPS
from armsim_ros.sim.drives.inverse_dynamics import InverseDynamics, stride_of
from armsim_ros.sim.physics.saved_state import Restorable


class ReferenceInputs(Restorable):
    """
    Inputs of the next steps: the inverse dynamics, and p and d of the reference.

    The physics' actuators make p and d themselves (``u - p*q - d*v``, clamped to the effort
    limit); ``u`` is what this class gives them. The reference is a position for each physics step;
    its velocity and acceleration are the differences that the integrator itself makes of it, so
    that in free motion the plant lands on every reference. All arrays hold the active joints in
    the model's order.

    :param settings: timestep, servo.
    :param gains: joint -> gains of its controller; a block without any gain counts as none.
    :param tune: takes p and d of the actuators (n,) whenever they change.
    :param weights: (n,) the robot's greatest weight on each joint [N*m or N].
    """

    unchanging = frozenset({
        'joint_names', 'dynamics', 'gains', 'compensated', '_tune', '_weightless', '_unactuated'})

    def __init__(
        self, model: RobotModel, settings: SimulationSettings, gains: Mapping[str, PidGains],
        tune: Callable[[Vector, Vector], None], weights: Vector
    ) -> None:
        self.joint_names = model.active_joints
        self.dynamics = InverseDynamics(model, settings)
        self.gains = DriveGains(self.joint_names, settings, gains, weights)
        self._feedforward = settings.servo.feedforward
        given = settings.servo.gravity_compensation
        self.compensated = (model.externally_driven_joints if given is None else frozenset(
            self.joint_names if given else ())) - model.unactuated_joints
        self._unactuated: Mask = np.isin(self.joint_names, list(model.unactuated_joints))
        self._weightless = [name in self.compensated for name in self.joint_names]
        self._timestep = settings.timestep
        self._tune = tune
        count = len(self.joint_names)
        self._follows_effort = self._unactuated.copy()
        self._effort_command = np.zeros(count)
        self._any_effort = False

    def _rest_at(self, position: Vector) -> None:
        """Rest at a position (n,) [rad or m]."""
        self._references, self._velocities = position[None].copy(), np.zeros((1, len(position)))
        self._row, self._steps, self._stride, self._counts, self._counted = 0, 1, 1, [0], 0
        self._tunings: dict[int, Vector] = {}
        self._inertias = self.dynamics.at_rest(self._references)[1]
        self._follow_inertia()

    @property
    def reference(self) -> Vector:
        """Where the drives want the joints to be now (n,) [rad or m]."""
        reference: Vector = self._references[self._row]
        return reference

    def set_payload(self, body: str, mass: float, centre: Sequence[float]) -> None:
        """Compensate a load from the next step on, see ``InverseDynamics.set_payload``."""
        self.dynamics.set_payload(body, mass, centre)
        self._drop_plan()

    def _tune_if_due(self) -> None:
        """Follow the inertias: they change slowly, and the actuators' d has to be the plan's."""
        if self._untuned >= TUNING_STEPS:
            self._follow_inertia()

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

    def stiffness_warnings(self) -> list[str]:
        """Return a line for each joint whose gains are too high for the timestep."""
        inertias = self.dynamics.joint_inertias(self._inertias[[self._row // self._stride]])
        return self.gains.stiffness_warnings(inertias[0])

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
        self.resting = False
        """Whether the inputs stay as they are as long as the commands do."""
