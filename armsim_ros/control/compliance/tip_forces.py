# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What forces at the tip do to joints: torques of springs, and FZI's solvers for motions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
import math

import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.config.controllers.compliance import (
    CartesianAdmittanceControllerParameters,
    CartesianControllerParameters,
    MaxStiffnessSettings,
    NetForceParameters,
    TaskSettings,
)
from armsim_ros.control.arm_dynamics import ArmDynamics
from armsim_ros.model.transforms import rotation_vector

Parameters = CartesianControllerParameters | CartesianAdmittanceControllerParameters
_AXES = ('pos_x', 'pos_y', 'pos_z', 'rot_x', 'rot_y', 'rot_z')


@dataclass(eq=False)
class Gains:
    """
    Parameters as arrays.

    :param stiffness: (6,) of the tip, as far as it takes effect [N/m, N*m/rad].
    :param damping: (6,) [N*s/m, N*m*s/rad].
    :param clip: (6,) the largest error that counts [m, rad].
    :param posture_stiffness: (n,) [N*m/rad].
    :param posture_damping: (n,) [N*m*s/rad].
    """

    stiffness: Vector
    damping: Vector
    clip: Vector
    posture_stiffness: Vector
    posture_damping: Vector
    friction: Matrix = field(default_factory=lambda: np.zeros((3, 0)))

    @classmethod
    def of(cls, parameters: Parameters, stiffness: Vector | None = None) -> Gains:
        """
        Return the gains.

        :param stiffness: (6,) of the tip in place of the parameters'.
        """
        task, nullspace, count = parameters.task, parameters.nullspace, len(parameters.joints)
        own = _of_axes(task, 'k')
        given = _of_axes(task, 'd')
        weights = np.array([nullspace.weights[name].value for name in parameters.joints])
        spring = nullspace.stiffness * weights
        damper = (2.0 * np.sqrt(spring) if parameters.posture_is_critically_damped
                  else nullspace.damping * weights)
        clip = task.error_clip
        friction = np.zeros((3, count))
        if parameters.use_friction:
            friction[:] = [values[:count] for values in (
                parameters.friction.fp1, parameters.friction.fp2, parameters.friction.fp3)]
        return cls(
            bounded(own if stiffness is None else stiffness, parameters.most_stiffness),
            np.where(given > 0.0, given, 2.0 * np.sqrt(own)),
            np.array([clip.x, clip.y, clip.z, clip.rx, clip.ry, clip.rz]),
            spring, damper, friction)


@dataclass(eq=False)
class Targets:
    """
    What the law follows.

    :param pose: (4, 4) of the tip in the base frame.
    :param posture: (n,) [rad].
    :param posture_velocity: (n,) [rad/s].
    :param wrench: (6,) of the tip, in the axes of the gains [N, N*m].
    """

    pose: Matrix
    posture: Vector
    posture_velocity: Vector
    wrench: Vector


@dataclass(frozen=True, eq=False)
class JointBounds:
    """
    Bounds that joints are kept from.

    :param lower: (n,) [rad].
    :param upper: (n,) [rad].
    :param bounded: (n,) whether a joint has them.
    """

    lower: Vector
    upper: Vector
    bounded: Mask


def impedance_torques(
    parameters: Parameters, gains: Gains, targets: Targets, arm: ArmDynamics, bounds: JointBounds,
    positions: Vector, velocities: Vector,
) -> Vector:
    """
    Return the torques of all terms (n,) [N*m].

    :param arm: at the positions.
    :param positions: (n,) [rad].
    :param velocities: (n,) [rad/s].
    """
    pose, jacobian = arm.pose, arm.jacobian()
    error = pose_error(targets.pose, pose)
    if parameters.use_local_jacobian:
        turn = pose[:3, :3].T
        error = np.concatenate((turn @ error[:3], turn @ error[3:]))
        jacobian = np.concatenate((turn @ jacobian[:3], turn @ jacobian[3:]))
    if parameters.limit_error:
        error = np.clip(error, -gains.clip, gains.clip)
    force = gains.stiffness * error - gains.damping * (jacobian @ velocities)
    nullspace = parameters.nullspace
    inverse: Matrix = np.empty(0)
    tip_inertia: Matrix = np.empty(0)
    if parameters.use_operational_space or nullspace.projector_type == 'dynamic':
        inverse = np.asarray(np.linalg.inv(arm.inertia()), dtype=np.float64)
        tip_inertia = damped_inverse(jacobian @ inverse @ jacobian.T,
                                     parameters.operational_space_regularization)
    if parameters.use_operational_space:
        force = tip_inertia @ force
    posture = (gains.posture_stiffness * (targets.posture - positions)
               + gains.posture_damping * (targets.posture_velocity - velocities))
    if nullspace.projector_type == 'kinematic':
        posture -= damped_inverse(jacobian, nullspace.regularization) @ (jacobian @ posture)
    elif nullspace.projector_type == 'dynamic':
        posture -= jacobian.T @ (tip_inertia @ (jacobian @ (inverse @ posture)))
    torques: Vector = jacobian.T @ (force + targets.wrench)
    torques += np.clip(posture, -nullspace.max_tau, nullspace.max_tau)
    if parameters.use_friction:
        torques += friction_torques(gains.friction, velocities)
    if parameters.use_coriolis_compensation:
        torques += arm.coriolis()
    if parameters.use_gravity_compensation:
        torques += arm.gravity()
    repulsion = parameters.joint_limit_repulsion
    if repulsion.enabled:
        torques += _repulsion(positions, bounds, repulsion.safe_range, repulsion.max_torque)
    return torques


def pose_error(target: Matrix, pose: Matrix) -> Vector:
    """Return way and rotation vector from a pose to another (6,), in the axes of their frame."""
    turn = rotation_vector(target[:3, :3] @ pose[:3, :3].T)
    return np.concatenate((target[:3, 3] - pose[:3, 3], turn))


def damped_inverse(matrix: Matrix, damping: float) -> Matrix:
    """Return the pseudo-inverse with each singular value s as s / (s^2 + damping^2)."""
    left, values, right = np.linalg.svd(matrix, full_matrices=False)
    found: Matrix = (right.T * (values / (values**2 + damping**2))) @ left.T
    return found


def friction_torques(friction: Matrix, velocities: Vector) -> Vector:
    """
    Return what overcomes the friction (n,) [N*m].

    :param friction: (3, n) rows fp1, fp2, fp3.
    """
    most, slope, offset = friction
    found: Vector = most / (1.0 + np.exp(-slope * (velocities + offset))) - most / (
        1.0 + np.exp(-slope * offset))
    return found


def bounded(stiffness: Vector, most: MaxStiffnessSettings) -> Vector:
    """Return stiffnesses (6,) between 0 and the largest that take effect."""
    limits = np.repeat([most.translational, most.rotational], 3)
    found: Vector = np.clip(stiffness, 0.0, limits)
    return found


def _repulsion(positions: Vector, bounds: JointBounds, near: float, most: float) -> Vector:
    """Return torques (n,) that grow linearly towards the bounds [N*m]."""
    below = np.clip((near - (positions - bounds.lower)) / near, 0.0, 1.0)
    above = np.clip((near - (bounds.upper - positions)) / near, 0.0, 1.0)
    return np.where(bounds.bounded, most * (below - above), 0.0)


def _of_axes(task: TaskSettings, kind: str) -> Vector:
    return np.array([getattr(task, f'{kind}_{axis}') for axis in _AXES])


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
