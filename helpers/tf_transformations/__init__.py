# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Rotations and homogeneous matrices as tf_transformations has them.

Quaternions are x, y, z, w; matrices are 4 x 4; angles are in [rad].
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
#: x, y, z, w.
Quaternion = tuple[float, float, float, float]

_LETTERS = 'xyz'
_EPSILON = 4.0 * float(np.finfo(float).eps)
#: By how much a matrix may differ from one of the kind that is taken apart.
_TOLERANCE = 1e-8


def identity_matrix() -> Array:
    """Return the matrix that moves nothing."""
    return np.eye(4)


def translation_matrix(direction: Any) -> Array:
    """Return the matrix of a translation."""
    matrix = np.eye(4)
    matrix[:3, 3] = direction[:3]
    return matrix


def translation_from_matrix(matrix: Any) -> Array:
    """Return the translation of a matrix."""
    return np.array(matrix, float)[:3, 3]


def rotation_matrix(angle: float, direction: Any, point: Any = None) -> Array:
    """Return the matrix of a rotation about an axis, through a point (default: the origin)."""
    matrix = quaternion_matrix(quaternion_about_axis(angle, direction[:3]))
    if point is not None:
        centre = np.array(point[:3], float)
        matrix[:3, 3] = centre - matrix[:3, :3] @ centre
    return matrix


def rotation_from_matrix(matrix: Any) -> tuple[float, Array, Array]:
    """
    Return the angle, the axis (3,) and a point (4,) on it of a rotation.

    :raises ValueError: the matrix is not a rotation about a line.
    """
    x, y, z, w = quaternion_from_matrix(matrix)
    vector, sine = np.array([x, y, z]), math.hypot(x, y, z)
    angle = 2.0 * math.atan2(sine, w)
    axis = vector / sine if sine > _EPSILON else np.array([0.0, 0.0, 1.0])
    point = _fixed_point(matrix, rotation_matrix(angle, axis))
    return angle, axis, np.append(point, 1.0)


def scale_matrix(factor: float, origin: Any = None, direction: Any = None) -> Array:
    """Return the matrix of a scaling about a point, in all directions or in a single one."""
    matrix = np.eye(4)
    if direction is None:
        matrix[:3, :3] *= factor
    else:
        axis = unit_vector(direction[:3])
        matrix[:3, :3] -= (1.0 - factor) * np.outer(axis, axis)
    if origin is not None:
        centre = np.array(origin[:3], float)
        matrix[:3, 3] = centre - matrix[:3, :3] @ centre
    return matrix


def reflection_matrix(point: Any, normal: Any) -> Array:
    """Return the matrix of a reflection in a plane through a point."""
    return scale_matrix(-1.0, point, normal)


def scale_from_matrix(matrix: Any) -> tuple[float, Array, Array | None]:
    """
    Return the factor, the origin (3,) and the direction (3,) of a scaling.

    The direction is None where it scales in all directions alike.

    :raises ValueError: the matrix is not a scaling.
    """
    values, vectors = np.linalg.eigh(np.asarray(matrix, float)[:3, :3])
    factor, direction = float(values[0]), None
    if np.ptp(values) > _TOLERANCE:
        index = int(np.abs(values - 1.0).argmax())
        factor, direction = float(values[index]), vectors[:, index]
    return factor, _fixed_point(matrix, scale_matrix(factor, direction=direction)), direction


def reflection_from_matrix(matrix: Any) -> tuple[Array, Array]:
    """
    Return a point (3,) of the plane of a reflection, and its normal (3,).

    :raises ValueError: the matrix is not a reflection.
    """
    factor, point, normal = scale_from_matrix(matrix)
    if normal is None or abs(factor + 1.0) > _TOLERANCE:
        raise ValueError('the matrix is not a reflection')
    return point, normal


def _fixed_point(matrix: Any, linear: Array) -> Array:
    """
    Return the point (3,) nearest to the origin that a matrix does not move.

    :param linear: (4, 4) of the same directions, about the origin.
    """
    m = np.asarray(matrix, float)
    differences = np.eye(3) - m[:3, :3]
    point = np.linalg.lstsq(differences, m[:3, 3], rcond=_TOLERANCE)[0]
    left = np.abs(differences @ point - m[:3, 3]).max()
    if left > _TOLERANCE * (1.0 + np.abs(m[:3, 3]).max()) \
            or not np.allclose(m[:3, :3], linear[:3, :3], rtol=0.0, atol=_TOLERANCE):
        raise ValueError('the matrix is of another kind, or moves all points')
    return np.asarray(point)


def compose_matrix(scale: Any = None, shear: Any = None, angles: Any = None,
                   translate: Any = None, perspective: Any = None) -> Array:
    """
    Return the matrix of a shear, then a scaling, a rotation and a translation.

    :param scale: (3,) factors.
    :param shear: (3,) factors x-y, x-z, y-z.
    :param angles: (3,) about the static axes x, y, z.
    :param translate: (3,)
    :param perspective: not used, as upstream.
    """
    matrix = np.eye(4) if angles is None else euler_matrix(*angles)
    if scale is not None:
        matrix[:3, :3] *= np.asarray(scale, float)
    if shear is not None:
        sheared = np.eye(3)
        sheared[np.triu_indices(3, 1)] = shear
        matrix[:3, :3] = matrix[:3, :3] @ sheared
    if translate is not None:
        matrix[:3, 3] = translate
    return matrix


def decompose_matrix(
    matrix: Any
) -> tuple[Array, Array, tuple[float, float, float], Array, None]:
    """
    Return scale, shear, angles, translation and perspective as compose_matrix takes them.

    A matrix that mirrors has a negative first factor. The perspective is None, as upstream.

    :raises ValueError: the matrix is degenerate.
    """
    m = np.array(matrix, float)
    # The shear is upper triangular, so scaling times shear is a Cholesky factor.
    factor = np.linalg.cholesky(m[:3, :3].T @ m[:3, :3]).T
    scale = np.diag(factor).copy()
    shear = (factor / scale[:, np.newaxis])[np.triu_indices(3, 1)]
    if np.linalg.det(m[:3, :3]) < 0.0:
        scale[0], factor[0] = -scale[0], -factor[0]
    return scale, shear, euler_from_matrix(m[:3, :3] @ np.linalg.inv(factor)), m[:3, 3], None


def superimposition_matrix(
    v0: Any, v1: Any, scaling: bool = False, usesvd: bool = True
) -> Array:
    """
    Return the matrix that moves points closest to others, by least squares.

    :param v0: (3 or 4, n) points, at least three.
    :param v1: (3 or 4, n) where they shall be.
    :param scaling: also scale by the ratio of the extents.
    :param usesvd: upstream's choice between two methods with the same result; not used.
    :raises ValueError: the shapes are different or too small.
    """
    first, second = (np.asarray(each, float)[:3] for each in (v0, v1))
    if first.shape != second.shape or first.ndim != 2 or first.shape[1] < 3:
        raise ValueError('two arrays of the same shape with three points or more are needed')
    centres = first.mean(axis=1), second.mean(axis=1)
    first, second = first - centres[0][:, np.newaxis], second - centres[1][:, np.newaxis]
    left, _, right = np.linalg.svd(second @ first.T)
    handed = np.diag([1.0, 1.0, float(np.sign(np.linalg.det(left @ right)))])
    matrix = np.eye(4)
    matrix[:3, :3] = left @ handed @ right
    if scaling:
        matrix[:3, :3] *= np.linalg.norm(second) / np.linalg.norm(first)
    matrix[:3, 3] = centres[1] - matrix[:3, :3] @ centres[0]
    return matrix


def inverse_matrix(matrix: Any) -> Array:
    """Return the inverse of a matrix."""
    return np.asarray(np.linalg.inv(np.asarray(matrix, float)))


def concatenate_matrices(*matrices: Any) -> Array:
    """Return the product of matrices."""
    product = np.eye(4)
    for matrix in matrices:
        product = product @ np.asarray(matrix, float)
    return product


def is_same_transform(matrix0: Any, matrix1: Any) -> bool:
    """Return whether two matrices are the same but for their scale."""
    first, second = (np.asarray(each, float) for each in (matrix0, matrix1))
    return bool(np.allclose(first / first[3, 3], second / second[3, 3]))


def euler_matrix(ai: float, aj: float, ak: float, axes: str = 'sxyz') -> Array:
    """
    Return the matrix of three rotations.

    :param axes: s for fixed axes or r for axes that turn along, then their letters.
    """
    letters, angles = axes[1:], (ai, aj, ak)
    if axes[0] == 's':
        letters, angles = letters[::-1], (ak, aj, ai)
    return concatenate_matrices(*(
        rotation_matrix(angle, np.eye(3)[_LETTERS.index(letter)])
        for angle, letter in zip(angles, letters, strict=True)))


def euler_from_matrix(matrix: Any, axes: str = 'sxyz') -> tuple[float, float, float]:
    """Return the three angles of a matrix; axes as in euler_matrix."""
    m = np.asarray(matrix, float)
    i, j, k = (_LETTERS.index(letter) for letter in (axes[:0:-1] if axes[0] == 's' else axes[1:]))
    last = 3 - i - j
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    if i == k:
        sine = math.hypot(m[i, j], m[i, last])
        middle = math.atan2(sine, m[i, i])
        angles = (math.atan2(m[j, i], -sign * m[last, i]), middle,
                  math.atan2(m[i, j], sign * m[i, last]))
        free = (0.0, middle, math.atan2(-sign * m[j, last], m[j, j]))
    else:
        sine = math.hypot(m[i, i], m[i, j])
        middle = math.atan2(sign * m[i, k], sine)
        angles = (math.atan2(-sign * m[j, k], m[k, k]), middle,
                  math.atan2(-sign * m[i, j], m[i, i]))
        free = (0.0, middle, math.atan2(sign * m[j, i], m[j, j]))
    first, second, third = angles if sine > _EPSILON else free
    return (third, second, first) if axes[0] == 's' else (first, second, third)


def euler_from_quaternion(quaternion: Any, axes: str = 'sxyz') -> tuple[float, float, float]:
    """Return the three angles of a quaternion; axes as in euler_matrix."""
    return euler_from_matrix(quaternion_matrix(quaternion), axes)


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: str = 'sxyz') -> Quaternion:
    """Return the quaternion of three rotations; axes as in euler_matrix."""
    factors = [quaternion_about_axis(angle, np.eye(3)[_LETTERS.index(letter)])
               for angle, letter in zip((ai, aj, ak), axes[1:], strict=True)]
    if axes[0] == 's':
        factors.reverse()
    return quaternion_multiply(quaternion_multiply(factors[0], factors[1]), factors[2])


def quaternion_about_axis(angle: float, axis: Any) -> Quaternion:
    """Return the quaternion of a rotation about an axis."""
    x, y, z = (unit_vector(axis[:3]) * math.sin(angle / 2.0)).tolist()
    return x, y, z, math.cos(angle / 2.0)


def quaternion_matrix(quaternion: Any) -> Array:
    """Return the matrix of a quaternion, of any length."""
    x, y, z, w = (float(each) for each in quaternion)
    length = x * x + y * y + z * z + w * w
    if length < _EPSILON:
        return np.eye(4)
    s = 2.0 / length
    return np.array([
        [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w), 0.0],
        [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w), 0.0],
        [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y), 0.0],
        [0.0, 0.0, 0.0, 1.0]])


def quaternion_from_matrix(matrix: Any) -> Quaternion:
    """Return the quaternion of a matrix, with w not negative: the closest rotation's."""
    m = np.asarray(matrix, float)[:3, :3]
    vector = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    form = np.zeros((4, 4))
    form[:3, :3] = m + m.T - np.trace(m) * np.eye(3)
    form[:3, 3] = form[3, :3] = vector
    form[3, 3] = np.trace(m)
    x, y, z, w = np.linalg.eigh(form)[1][:, -1].tolist()
    return (x, y, z, w) if w >= 0.0 else (-x, -y, -z, -w)


def quaternion_multiply(quaternion1: Any, quaternion0: Any) -> Quaternion:
    """Return the product: first quaternion0 is applied, then quaternion1."""
    x, y, z, w = (float(each) for each in quaternion1)
    a, b, c, d = (float(each) for each in quaternion0)
    return (w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a,
            w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c)


def quaternion_conjugate(quaternion: Any) -> Array:
    """Return a quaternion with the opposite axis."""
    return np.array(quaternion, float) * (-1.0, -1.0, -1.0, 1.0)


def quaternion_inverse(quaternion: Any) -> Array:
    """Return the inverse of a quaternion, of any length."""
    return quaternion_conjugate(quaternion) / float(np.dot(quaternion, quaternion))


def quaternion_slerp(quat0: Any, quat1: Any, fraction: float, spin: int = 0,
                     shortestpath: bool = True) -> Array:
    """
    Return a quaternion between two others.

    :param fraction: 0 is the first, 1 the second.
    :param spin: half turns to be added.
    :param shortestpath: turn by less than half a turn.
    """
    start, end = unit_vector(quat0), unit_vector(quat1)
    if fraction in (0.0, 1.0):
        return end if fraction else start
    cosine = float(np.dot(start, end))
    if abs(abs(cosine) - 1.0) < _EPSILON:
        return start
    if shortestpath and cosine < 0.0:
        cosine, end = -cosine, -end
    angle = math.acos(cosine) + spin * math.pi
    if abs(angle) < _EPSILON:
        return start
    return (math.sin((1.0 - fraction) * angle) * start
            + math.sin(fraction * angle) * end) / math.sin(angle)


def random_quaternion(rand: Any = None) -> Array:
    """Return a random rotation, or that of three numbers between 0 and 1."""
    first, second, third = np.random.rand(3) if rand is None else rand
    inner, outer = math.sqrt(1.0 - first), math.sqrt(first)
    second, third = 2.0 * math.pi * second, 2.0 * math.pi * third
    return np.array([math.sin(second) * inner, math.cos(second) * inner,
                     math.sin(third) * outer, math.cos(third) * outer])


def random_rotation_matrix(rand: Any = None) -> Array:
    """Return the matrix of random_quaternion."""
    return quaternion_matrix(random_quaternion(rand))


def random_vector(size: Any) -> Array:
    """Return numbers between 0 and 1."""
    return np.asarray(np.random.random(size))


def vector_norm(data: Any, axis: int | None = None) -> Any:
    """Return the length of a vector, or lengths along an axis."""
    return np.linalg.norm(np.asarray(data, float), axis=axis)


def unit_vector(data: Any, axis: int | None = None) -> Array:
    """Return a vector, or vectors along an axis, with the length 1."""
    vector = np.asarray(data, float)
    return np.asarray(vector / np.linalg.norm(vector, axis=axis, keepdims=axis is not None))
