# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The query to coal that finds every contact.

coal measures the distance of convex shapes with GJK, which ends when the distance found is within
a tolerance of the true distance, and reports contact where the distance found is not positive. For
shapes that overlap GJK may return any distance up to the tolerance, most often where they are
parallel to each other. Where contacts are requested EPA corrects that, at up to twice the time.
Here everything found within the tolerance counts as contact: that is cheaper and finds every
contact, and gaps of up to two micrometres are contacts as well.
"""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import Any

import coal
import numpy as np

from armsim_ros.arrays import Matrix

#: Error of the distances found, in [m] and as a share of the distance of the shapes' cores: a
#: sphere's is its centre, a capsule's its axis.
GJK_TOLERANCE = 1e-6
#: coal treats the axes of two capsules as parallel where their cross product is below the root
#: of a hundred times the machine's precision [m^2]; an angle is at most pi / 2 times its sine.
_TAKEN_FOR_PARALLEL = 0.5 * np.pi * 1.5e-7
#: Safety factors: of distances, and of the distances of shapes that overlap. Of two cylinders that
#: overlapped by less than 0.1 um GJK found 1.6 times the tolerance.
_MORE, _MORE_IN_CONTACT = 1.1, 2.0
#: Rounding error of GJK as a share of the shapes' size: 2e-8 was measured with slivers of 50 m.
_ROUNDING = 1e-7
_NOTHING_ELSE = coal.CollisionRequestFlag.NO_REQUEST


def contact_request(between_boxes: bool) -> Any:
    """
    Return a request that asks only whether two shapes touch.

    :param between_boxes: start GJK with the vector between the shapes' bounding boxes, which is
        faster; not for planes, meshes and octrees.
    """
    request = coal.CollisionRequest(_NOTHING_ELSE, 1)
    request.gjk_tolerance = GJK_TOLERANCE
    if between_boxes:
        request.gjk_initial_guess = coal.GJKInitialGuess.BoundingVolumeGuess
    return request


class ContactDistances:
    """
    The distances found that count as contact of shapes.

    :param shapes: of coal, numbered.
    """

    def __init__(self, shapes: Sequence[Any]) -> None:
        radii = np.array([shape.radius if isinstance(shape, (coal.Sphere, coal.Capsule)) else 0.0
                          for shape in shapes])
        sizes = np.array([_size(shape) for shape in shapes])
        #: (g, g) [m] where the margin is 0.
        self.least: Matrix = (
            _MORE_IN_CONTACT * GJK_TOLERANCE * (1.0 + radii[:, None] + radii)
            + _ROUNDING * (sizes[:, None] + sizes) + _capsule_errors(shapes))

    def within(self, margins: Matrix) -> Matrix:
        """Return the distances (g, g) [m] for shapes within margins (g, g) [m]."""
        return within_margins(margins, self.least)


def within_margins(margins: Matrix, least: Matrix) -> Matrix:
    """
    Return the distances found [m] that count as contact within margins [m].

    :param least: those without margins, see :class:`ContactDistances`.
    """
    distances: Matrix = margins * (1.0 + _MORE * GJK_TOLERANCE) + least
    return distances


def _size(shape: Any) -> float:
    """Return the radius [m] around a shape; 0 for a plane, which is checked without GJK."""
    if isinstance(shape, coal.Plane):
        return 0.0
    if isinstance(shape, coal.OcTree):  # it is checked leaf by leaf
        return 0.5 * math.sqrt(3.0) * float(shape.getResolution())
    if not isinstance(shape, coal.BVHModelBase):
        shape.computeLocalAABB()
    return float(shape.aabb_radius)


def _capsule_errors(shapes: Sequence[Any]) -> Matrix:
    """Return the most (g, g) [m] by which coal errs in the distance of two capsules."""
    lengths = np.array([2.0 * shape.halfLength if isinstance(shape, coal.Capsule) else np.inf
                        for shape in shapes])
    shorter = np.minimum(lengths[:, None], lengths)
    longer = np.where(np.isfinite(lengths[:, None] + lengths),
                      np.maximum(lengths[:, None], lengths), 0.0)
    errors: Matrix = np.minimum(longer, _TAKEN_FOR_PARALLEL / shorter)
    return errors


class PlaneDistance:
    """
    The distance of a mesh and a plane; coal computes a wrong distance for some of them.

    :param mesh: of coal, as is the plane.
    """

    def __init__(self, mesh: Any, plane: Any) -> None:
        corners = (mesh.tri_indices(number) for number in range(mesh.num_tris))
        self._corners = np.array([[corner[0], corner[1], corner[2]] for corner in corners])
        self._vertices = mesh.vertices()
        self._plane = plane

    def between(self, mesh_pose: Matrix, plane_pose: Matrix) -> float:
        """Return the distance [m] at poses (4, 4); not positive where a triangle crosses."""
        normal = plane_pose[:3, :3] @ self._plane.n
        origin = normal @ (mesh_pose[:3, 3] - plane_pose[:3, 3]) - self._plane.d
        heights = (self._vertices @ (mesh_pose[:3, :3].T @ normal) + origin)[self._corners]
        return float(np.maximum(heights.min(axis=1), -heights.max(axis=1)).min())
