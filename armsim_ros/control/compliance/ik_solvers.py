# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
How a net force at the end effector moves the joints: the solvers of FZI's cartesian_controllers.

The force moves an internal model with massless links but for the last, so that its inertia is
nearly that of a single body (arXiv 1908.06252).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.controllers.cartesian_controllers import NetForceParameters
from armsim_ros.control.arm_dynamics import ArmDynamics
from armsim_ros.control.compliance.impedance_law import JointBounds

#: Time of a step of the internal model, whatever the rate of the controller [s].
STEP_S = 0.02
_LEAST_INERTIA = 1e-6
_KEPT_SPEED = 0.9
#: Largest angle of a joint in a step of the selectively damped solver (Buss and Kim).
_LARGEST = math.pi / 4.0


class InternalModel:
    """
    Joints that a net force moves.

    :param arm: their kinematics.
    :param links: links right behind the joints, in whose origins the small masses are.
    :param bounds: of the joints.
    """

    def __init__(self, arm: ArmDynamics, links: Sequence[str], bounds: JointBounds) -> None:
        self.arm, self._links, self._bounds = arm, tuple(links), bounds
        self.positions: Vector = np.zeros(len(bounds.lower))
        self.velocities: Vector = np.zeros(len(bounds.lower))

    def place(self, positions: Vector) -> None:
        """Be at positions (n,) [rad]; velocities stay."""
        self.positions = positions
        self.arm.move(positions, self.velocities)

    def step(self, force: Vector, parameters: NetForceParameters) -> None:
        """
        Move for a step.

        :param force: (6,) at the end effector, in base axes.
        """
        before, solve = self.positions, _SOLVERS.get(parameters.ik_solver)
        if solve is None:
            rate = np.linalg.solve(self._inertia(parameters.link_mass),
                                   self.arm.jacobian().T @ force)
            positions = before + STEP_S * self.velocities
            self.velocities = _KEPT_SPEED * (self.velocities + STEP_S * rate)
        else:
            self.velocities = solve(self.arm.jacobian(), force, parameters)
            positions = before + 0.5 * STEP_S * self.velocities
        bounds = self._bounds
        self.place(np.where(bounds.bounded, np.clip(positions, bounds.lower, bounds.upper),
                            positions))

    def _inertia(self, link_mass: float) -> Matrix:
        found = np.zeros((len(self.positions), len(self.positions)))
        tip = self.arm.jacobian()
        for link in self._links:
            jacobian = self.arm.jacobian(link)
            linear, angular = jacobian[:3], jacobian[3:]
            found += link_mass * linear.T @ linear + _LEAST_INERTIA * angular.T @ angular
        found += tip.T @ tip
        return found


def _transposed(jacobian: Matrix, force: Vector, _: NetForceParameters) -> Vector:
    return np.asarray(0.5 * STEP_S * (jacobian.T @ force))


def _damped(jacobian: Matrix, force: Vector, parameters: NetForceParameters) -> Vector:
    square = jacobian.T @ jacobian + parameters.alpha**2 * np.eye(jacobian.shape[1])
    return np.asarray(np.linalg.solve(square, jacobian.T @ force))


def _selectively_damped(jacobian: Matrix, force: Vector, _: NetForceParameters) -> Vector:
    left, values, right = np.linalg.svd(jacobian, full_matrices=False)
    lengths = np.linalg.norm(jacobian[:3], axis=0)
    found = np.zeros(jacobian.shape[1])
    for direction, value, joints in zip(left.T, values, right, strict=True):
        if value < 1e-12:
            continue
        moved = float(np.abs(joints) @ lengths) / value
        reach = float(np.linalg.norm(direction[:3]))
        share = _LARGEST * (min(1.0, reach / moved) if moved > 0.0 else 1.0)
        found += _limited(joints * (direction @ force) / value, share)
    return _limited(found, _LARGEST)


def _limited(values: Vector, most: float) -> Vector:
    largest = float(np.abs(values).max())
    return values if largest <= most else values * (most / largest)


_SOLVERS: Mapping[str, Callable[[Matrix, Vector, NetForceParameters], Vector]] = {
    'jacobian_transpose': _transposed,
    'damped_least_squares': _damped,
    'selectively_damped_least_squares': _selectively_damped,
}
