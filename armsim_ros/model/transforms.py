# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Rotations and poses as plain numpy arrays.

Matrices are homogeneous (4, 4) or rotations (3, 3). Roll, pitch, yaw are URDF's: rotations
about the fixed x, y, z axes in that order. The order of a quaternion's parts is in the
name: ``xyzw`` as in ROS messages, ``wxyz`` as in MuJoCo.
"""

from __future__ import annotations

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import ArrayLike

from armsim_ros.arrays import Matrix


def matrix_from_rpy(rpy: ArrayLike) -> Matrix:
    """
    Return the rotation of URDF's roll, pitch, yaw.

    :param rpy: (3,) [rad].
    :returns: (3, 3).
    """
    roll, pitch, yaw = np.asarray(rpy, dtype=np.float64)
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ])


def matrix_from_quat_xyzw(quat_xyzw: ArrayLike) -> Matrix:
    """
    Return the rotation of a quaternion, which is normalized first.

    :param quat_xyzw: (4,); its length must not be 0.
    :returns: (3, 3).
    :raises ValueError: for a quaternion of length 0 or with a value that is not finite.
    """
    q = np.asarray(quat_xyzw, dtype=np.float64)
    norm = float(np.linalg.norm(q))
    if not math.isfinite(norm) or norm < 1e-12:
        raise ValueError(f'a quaternion needs finite values, not all 0; got {q.tolist()}')
    x, y, z, w = q / norm
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ])


def quat_xyzw_from_matrix(matrix: ArrayLike) -> Matrix:
    """
    Return the unit quaternion (4,) of a rotation, w not negative.

    The largest part is found first, so that no division is by a small number (Shepperd 1978).

    :param matrix: (3, 3) or (4, 4).
    """
    m = np.asarray(matrix, dtype=np.float64)[:3, :3]
    trace = float(np.trace(m))
    diagonal = [float(m[0, 0]), float(m[1, 1]), float(m[2, 2])]
    q = np.empty(4)
    biggest = int(np.argmax([*diagonal, trace]))
    if biggest == 3:
        q[3] = 1.0 + trace
        q[0] = m[2, 1] - m[1, 2]
        q[1] = m[0, 2] - m[2, 0]
        q[2] = m[1, 0] - m[0, 1]
    else:
        i, j, k = biggest, (biggest + 1) % 3, (biggest + 2) % 3
        q[i] = 1.0 - trace + 2.0 * diagonal[i]
        q[j] = m[j, i] + m[i, j]
        q[k] = m[k, i] + m[i, k]
        q[3] = m[k, j] - m[j, k]
    q /= float(np.linalg.norm(q))
    return -q if q[3] < 0.0 else q


def quat_xyzw_from_rpy(rpy: ArrayLike) -> Matrix:
    """Return the unit quaternion (4,) of URDF's roll, pitch, yaw (3,) [rad]."""
    return quat_xyzw_from_matrix(matrix_from_rpy(rpy))


def quat_wxyz_from_matrix(matrix: ArrayLike) -> Matrix:
    """Return the unit quaternion (4,) of a rotation (3, 3) or (4, 4), w first."""
    return quat_xyzw_from_matrix(matrix)[[3, 0, 1, 2]]


def matrix_from_quat_wxyz(quat_wxyz: ArrayLike) -> Matrix:
    """Return the rotation (3, 3) of a quaternion (4,) that has w first."""
    return matrix_from_quat_xyzw(np.asarray(quat_wxyz, dtype=np.float64)[[1, 2, 3, 0]])


def matrix_from_axis_angle(axis: ArrayLike, angle: float) -> Matrix:
    """
    Return the rotation about a unit axis (Rodrigues' formula).

    :param axis: (3,) unit vector.
    :param angle: [rad].
    :returns: (3, 3).
    """
    x, y, z = np.asarray(axis, dtype=np.float64)
    c, s = math.cos(angle), math.sin(angle)
    t = 1.0 - c
    return np.array(
        [
            [t * x * x + c, t * x * y - s * z, t * x * z + s * y],
            [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
            [t * x * z - s * y, t * y * z + s * x, t * z * z + c],
        ])


def pose_from_parts(xyz: ArrayLike, rotation: ArrayLike) -> Matrix:
    """Return the pose (4, 4) with position xyz (3,) [m] and rotation (3, 3)."""
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = xyz
    return pose


def pose_matrix(xyz: ArrayLike = (0.0, 0.0, 0.0), rpy: ArrayLike = (0.0, 0.0, 0.0)) -> Matrix:
    """
    Return the pose of URDF's ``<origin xyz rpy>``.

    :param xyz: (3,) [m].
    :param rpy: (3,) [rad].
    :returns: (4, 4).
    """
    return pose_from_parts(xyz, matrix_from_rpy(rpy))


def pose_from_quat_xyzw(xyz: ArrayLike, quat_xyzw: ArrayLike) -> Matrix:
    """Return the pose (4, 4) of a position (3,) [m] and a quaternion (4,)."""
    return pose_from_parts(xyz, matrix_from_quat_xyzw(quat_xyzw))


def inverse_pose(pose: ArrayLike) -> Matrix:
    """Return the inverse of a pose (4, 4) without a general matrix inversion."""
    m = np.asarray(pose, dtype=np.float64)
    rotation = m[:3, :3].T
    return pose_from_parts(-rotation @ m[:3, 3], rotation)


def rotation_angle(first: ArrayLike, second: ArrayLike) -> float:
    """
    Return the angle between two orientations [rad] in 0..pi.

    :param first: (3, 3) or (4, 4).
    :param second: (3, 3) or (4, 4).
    """
    a = np.asarray(first, dtype=np.float64)[:3, :3]
    b = np.asarray(second, dtype=np.float64)[:3, :3]
    # For an angle t the difference has the Frobenius norm sqrt(8) sin(t / 2).
    apart = (a - b).ravel()
    return 2.0 * math.asin(min(1.0, math.sqrt(float(apart @ apart) / 8.0)))


def skew(vector: Sequence[float] | Matrix) -> Matrix:
    """Return the matrix (3, 3) whose product with v is the cross product with v."""
    x, y, z = (float(part) for part in vector)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation_vector(rotation: Matrix) -> Matrix:
    """Return axis * angle (3,) [rad] of a rotation (3, 3)."""
    quat = quat_xyzw_from_matrix(rotation)
    sine = float(np.linalg.norm(quat[:3]))
    if sine < 1e-12:
        return np.zeros(3)
    result: Matrix = quat[:3] / sine * (2.0 * math.atan2(sine, float(quat[3])))
    return result


def euler_xyz(rotation: Matrix) -> Matrix:
    """
    Return the angles (3,) [rad] of the rotations about x, then the new y, then the new z.

    Where y is a right angle only the sum or difference of the others is known: z is 0 then.
    """
    cosine = math.hypot(rotation[0, 0], rotation[0, 1])
    y = math.atan2(rotation[0, 2], cosine)
    if cosine < 1e-9:
        return np.array([math.atan2(rotation[2, 1], rotation[1, 1]), y, 0.0])
    return np.array([
        math.atan2(-rotation[1, 2], rotation[2, 2]), y,
        math.atan2(-rotation[0, 1], rotation[0, 0]),
    ])


def rpy_from_matrix(rotation: Matrix) -> Matrix:
    """Return URDF's roll, pitch, yaw (3,) [rad] of a rotation (3, 3)."""
    return -euler_xyz(rotation.T)
