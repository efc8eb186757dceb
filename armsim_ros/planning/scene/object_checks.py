# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether shapes and poses that a client gave can be used."""

from __future__ import annotations

from collections.abc import Iterable
import math

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.geometry import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    Geometry,
    Mesh,
    Plane,
    Sphere,
)

#: By how much the axes of a rotation may fail to be of length 1 and square to each other.
ROTATION_TOLERANCE = 1e-4
#: Lengths and distances beyond this [m] are taken for mistakes.
LARGEST = 1e5

_IDENTITY = np.eye(3)


def object_error(message: str) -> PlanningError:
    """Return the error for an object that the scene cannot take."""
    return PlanningError(MoveItErrorCode.INVALID_OBJECT_NAME, message, 'planning scene')


def check_pose(pose: Matrix, what: str) -> Matrix:
    """
    Return a pose (4, 4) of its own, or refuse it.

    :param what: names the pose in the error.
    :raises PlanningError: INVALID_OBJECT_NAME.
    """
    matrix = np.array(pose, dtype=np.float64)
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        raise object_error(f'{what} is not a pose of finite numbers')
    rotation = matrix[:3, :3]
    off = np.abs(rotation @ rotation.T - _IDENTITY).max()
    if off > ROTATION_TOLERANCE or _triple_product(rotation) < 0.0:
        raise object_error(f'{what} has a part that is no rotation')
    if np.abs(matrix[:3, 3]).max() > LARGEST:
        far = ', '.join(f'{value:g}' for value in matrix[:3, 3])
        raise object_error(f'{what} lies too far away: ({far}) m; allowed: {LARGEST:g} m')
    return matrix


def _triple_product(rotation: Matrix) -> float:
    """Return the determinant; numpy's own takes ten times as long."""
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    return float(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g))


def check_geometry(geometry: Geometry, what: str) -> None:
    """
    Refuse a shape that has no extent, or numbers that are none.

    :param what: names the shape in the error.
    :raises PlanningError: INVALID_OBJECT_NAME.
    """
    if isinstance(geometry, Mesh):
        _check_mesh(geometry, what)
    elif isinstance(geometry, Plane):
        normal = math.hypot(geometry.a, geometry.b, geometry.c)
        if not math.isfinite(normal) or not math.isfinite(geometry.d) or normal < 1e-9:
            raise object_error(
                f'{what}: a plane needs finite coefficients and a normal (a, b, c) other than 0'
            )
        if abs(geometry.d) / normal > LARGEST:
            raise object_error(f'{what}: the plane lies more than {LARGEST:g} m away')
    elif isinstance(geometry, Box):
        _check_dimensions('box', geometry.size, what)
    elif isinstance(geometry, Sphere):
        _check_dimensions('sphere', (geometry.radius,), what)
    elif isinstance(geometry, (Cylinder, Cone, Capsule)):
        kind = type(geometry).__name__.lower()
        _check_dimensions(kind, (geometry.length, geometry.radius), what)
    else:
        raise object_error(f'{what}: shapes of kind {type(geometry).__name__} are not supported')


def _check_dimensions(kind: str, dimensions: Iterable[float], what: str) -> None:
    values = [float(value) for value in dimensions]
    if not all(math.isfinite(value) and 0.0 < value <= LARGEST for value in values):
        raise object_error(
            f'{what}: a {kind} cannot have the dimensions {values} m; '
            f'allowed: above 0, up to {LARGEST:g} m'
        )


def _check_mesh(mesh: Mesh, what: str) -> None:
    vertices, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    if triangles.ndim != 2 or triangles.shape[1:] != (3,) or not len(triangles):
        raise object_error(f'{what}: a mesh needs at least one triangle of three vertices')
    if vertices.ndim != 2 or vertices.shape[1:] != (3,):
        raise object_error(f'{what}: the vertices of a mesh need three coordinates each')
    if not np.isfinite(vertices).all() or np.abs(vertices).max(initial=0.0) > LARGEST:
        raise object_error(f'{what}: the mesh has a vertex that is not finite or too far away')
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise object_error(
            f'{what}: a triangle of the mesh names vertex {int(triangles.max())}, '
            f'but there are {len(vertices)} vertices'
        )
