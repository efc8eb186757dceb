# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The torques of a spring and damper at the tip, and of a weaker spring that holds the posture.

The law is that of crisp_controllers (src/cartesian_controller.cpp): ``tau = J'(K e - D J v) +
N (Kn (q_ref - q) + Dn (v_ref - v)) + J' w`` and what compensates the arm's own forces.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.config.controllers.compliance import (
    CartesianAdmittanceControllerParameters,
    CartesianControllerParameters,
    MaxStiffnessSettings,
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
        damper = (nullspace.damping * weights if nullspace.damping >= 0.0
                  else 2.0 * np.sqrt(spring))
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
