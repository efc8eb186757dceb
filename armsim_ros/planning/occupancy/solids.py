# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which points are inside of grown bodies: the robot, its loads, known objects."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
import math
from typing import Any

import coal
import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.coal_shapes import exact_shape, hull_shape
from armsim_ros.model.geometry import (
    bounding_box,
    Box,
    Capsule,
    Cone,
    Cylinder,
    Geometry,
    Mesh,
    Plane,
    scaled,
    Sphere,
)
from armsim_ros.planning.collision.bodies import shape_poses
from armsim_ros.planning.scene.content import SceneContent

#: Solids that are kept prepared.
_KEPT = 4096
#: Growth that depends on the depth is a multiple of this [m].
_STEP = 0.005


class Solid:
    """
    A shape that is scaled about its centre and then grown by an offset.

    A plane has no inside.

    :param geometry: the shape.
    :param scale: factor of its size, above 0.
    :param offset: [m], at least 0.
    """

    def __init__(self, geometry: Geometry, scale: float, offset: float) -> None:
        self._shape = scaled(geometry, scale)
        self._offset = offset
        self._planes: tuple[Matrix, Vector] | None = None
        self._hollow: HollowMesh | None = None
        self.centre, half = bounding_box(self._shape)
        if isinstance(self._shape, Mesh):
            self._planes = _planes(self._shape)
            if is_hollow(self._shape):
                self._hollow = HollowMesh(self._shape, offset)
        #: Of the sphere about the centre that holds it [m]; below 0 for a plane.
        self.radius = -1.0 if isinstance(self._shape, Plane) else float(
            np.linalg.norm(half)) + math.sqrt(3.0) * offset

    def holds(self, points: Matrix) -> Mask:
        """Return which points (k, 3) [m] in the shape's frame are inside."""
        shape, grown = self._shape, self._offset
        inside: Any
        if isinstance(shape, Box):
            inside = (np.abs(points) <= 0.5 * np.array(shape.size) + grown).all(axis=1)
        elif isinstance(shape, Sphere):
            inside = np.einsum('ij,ij->i', points, points) <= (shape.radius + grown) ** 2
        elif isinstance(shape, (Cylinder, Cone, Capsule)):
            inside = _in_round(shape, points, grown)
        elif self._planes is not None:
            normals, offsets = self._planes
            inside = (points @ normals.T <= offsets + grown).all(axis=1)
            if self._hollow is not None:
                inside[inside] = self._hollow.holds(points[inside])
        else:
            inside = np.zeros(len(points))
        return np.asarray(inside, dtype=bool)


def _in_round(shape: Cylinder | Cone | Capsule, points: Matrix, grown: float) -> Mask:
    half = 0.5 * shape.length
    around = np.hypot(points[:, 0], points[:, 1])
    height = points[:, 2]
    inside: Mask
    if isinstance(shape, Capsule):
        beyond = np.maximum(np.abs(height) - half, 0.0)
        inside = np.hypot(around, beyond) <= shape.radius + grown
    elif isinstance(shape, Cylinder):
        inside = (around <= shape.radius + grown) & (np.abs(height) <= half + grown)
    else:  # the slope is moved outwards along its normal
        slope = np.hypot(shape.radius, shape.length)
        outside = (around * shape.length + (height - half) * shape.radius) / slope
        inside = (outside <= grown) & (height >= -half - grown)
    return inside


def _planes(mesh: Mesh) -> tuple[Matrix, Vector]:
    """Return normals (k, 3) and offsets (k,) of the faces of a mesh's hull."""
    hull: Any = hull_shape(mesh)
    if not hasattr(hull, 'polygons'):  # flat: a box without thickness
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        return np.vstack([np.eye(3), -np.eye(3)]), np.concatenate([high, -low])
    corners = np.asarray(hull.points())
    faces = [hull.polygons(k) for k in range(hull.num_polygons)]
    a, b, c = (corners[[face[k] for face in faces]] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 0] / lengths[lengths > 0, None]
    outwards = np.sign(np.einsum('ij,ij->i', normals, a[lengths > 0] - corners.mean(axis=0)))
    normals = normals * np.where(outwards < 0, -1.0, 1.0)[:, None]
    # Neighbouring triangles of a flat face have the same plane.
    normals = np.unique(np.round(normals, 9), axis=0)
    return normals, (corners @ normals.T).max(axis=0)


PlacedSolid = tuple[Solid, Matrix]
"""A solid and its pose (4, 4)."""


@lru_cache(_KEPT)
def _solid(geometry: Geometry, scale: float, offset: float) -> Solid:
    return Solid(geometry, scale, offset)


def known_bodies(
    kinematics: KinematicModel, content: SceneContent, q: Vector, scale: float, offset: float,
    spread: float = 0.0, sensor: Matrix | None = None,
) -> list[PlacedSolid]:
    """
    Return all that a scene knows: links, what they carry, and objects of the world.

    :param q: (n,) robot state.
    :param scale: factor of the size of all.
    :param offset: [m] by which all are grown.
    :param spread: further growth [m/m^2] by the square of a body's depth before the sensor.
    :param sensor: (4, 4) pose of the sensor, which looks along z.
    """
    def growth(solid: Solid, pose: Matrix) -> float:
        if sensor is None or not spread:
            return offset
        centre = pose[:3, :3] @ solid.centre + pose[:3, 3] - sensor[:3, 3]
        depth = max(0.0, float(sensor[:3, 2] @ centre))
        return offset + _STEP * math.ceil(spread * depth * depth / _STEP)

    return [(_solid(geometry, scale, growth(_solid(geometry, scale, offset), pose)), pose)
            for geometry, pose in _known_shapes(kinematics, content, q)]


def changed_bodies(
    kinematics: KinematicModel, before: SceneContent, after: SceneContent, offset: float
) -> list[PlacedSolid]:
    """
    Return the objects, in the world and on links, that are new or elsewhere after an edit.

    :param offset: [m] by which they are grown.
    """
    def changed(part: str) -> dict[str, Any]:
        held = getattr(before, part)
        return {name: item for name, item in getattr(after, part).items()
                if held.get(name) is not item}

    only = replace(after, objects=changed('objects'), attached=changed('attached'))
    return [(_solid(geometry, 1.0, offset), pose)
            for geometry, pose in _object_shapes(kinematics, only, after.q)]


def _known_shapes(
    kinematics: KinematicModel, content: SceneContent, q: Vector
) -> Iterator[tuple[Geometry, Matrix]]:
    for link in kinematics.robot.links.values():
        if link.collisions:
            at = kinematics.link_pose(q, link.name)
            yield from ((item.geometry, at @ item.origin) for item in link.collisions)
    yield from _object_shapes(kinematics, content, q)


def _object_shapes(
    kinematics: KinematicModel, content: SceneContent, q: Vector
) -> Iterator[tuple[Geometry, Matrix]]:
    for load in content.attached.values():
        at = kinematics.link_pose(q, load.link_name) @ load.object.pose
        yield from ((shape.geometry, at @ shape.pose) for shape in load.object.shapes)
    for item in content.objects.values():
        for shape, pose in zip(item.shapes, shape_poses(kinematics, item), strict=True):
            yield shape.geometry, pose


def inside_any(points: Matrix, bodies: Sequence[PlacedSolid]) -> Mask:
    """Return which points (k, 3) [m] are inside of a body."""
    found = np.zeros(len(points), dtype=bool)
    for solid, pose in bodies:
        apart = points - (pose[:3, :3] @ solid.centre + pose[:3, 3])
        near = np.flatnonzero(
            (np.einsum('ij,ij->i', apart, apart) <= solid.radius * abs(solid.radius)) & ~found)
        if len(near):
            local = (points[near] - pose[:3, 3]) @ pose[:3, :3]
            found[near] = solid.holds(local)
    return found


def near_any(points: Matrix, reach: float, bodies: Sequence[PlacedSolid]) -> Mask:
    """Return which points (k, 3) [m] are within reach [m] of the sphere around a body."""
    found = np.zeros(len(points), dtype=bool)
    for solid, pose in bodies:
        if solid.radius < 0.0:
            continue
        apart = points - (pose[:3, :3] @ solid.centre + pose[:3, 3])
        found |= np.einsum('ij,ij->i', apart, apart) <= (solid.radius + reach) ** 2
    return found


#: Edge of a voxel [m], and most of them along an axis.
_VOXEL, _MOST_VOXELS = 0.005, 96
#: Share of its hull that a mesh fills where it counts as convex.
_CONVEX = 0.99
_UNKNOWN, _OUTSIDE, _INSIDE = range(3)


def is_hollow(mesh: Mesh) -> bool:
    """Return whether the hull of a mesh holds more than the mesh."""
    hull: Any = hull_shape(mesh)
    return hasattr(hull, 'polygons') and not (
        _closed(mesh) and abs(_volume(mesh)) >= _CONVEX * hull.computeVolume())


def _closed(mesh: Mesh) -> bool:
    """Return whether each edge has two triangles, or more where closed parts touch."""
    _, corner = np.unique(np.round(mesh.vertices, 9), axis=0, return_inverse=True)
    triangles = corner.reshape(-1)[mesh.triangles]
    edges = np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] % 2 == 0).all())


def _volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    return float(np.einsum('ij,ij->', a, np.cross(b, c))) / 6.0


class HollowMesh:
    """
    A mesh whose voxels are classified by their centres when they are first asked for.

    A point is inside where its voxel's centre is within an offset of a triangle, or, in a closed
    mesh, behind the nearest one.

    :param mesh: the shape.
    :param offset: [m] by which it is grown.
    """

    def __init__(self, mesh: Mesh, offset: float) -> None:
        self._shape, self._offset = exact_shape(mesh), offset
        self._low = mesh.vertices.min(axis=0) - offset
        size = mesh.vertices.max(axis=0) + offset - self._low
        self._edge = max(_VOXEL, float(size.max()) / _MOST_VOXELS)
        self._voxels = np.full(
            np.floor(size / self._edge).astype(np.int64) + 1, _UNKNOWN, dtype=np.uint8)
        a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
        outwards = np.sign(_volume(mesh)) if _closed(mesh) else 0.0
        self._normals: Matrix = outwards * np.cross(b - a, c - a)

    def holds(self, points: Matrix) -> Mask:
        """Return which points (k, 3) [m] in the mesh's frame are inside, to within a voxel."""
        places = np.floor((points - self._low) / self._edge).astype(np.int64)
        inside: Mask = ((places >= 0) & (places < self._voxels.shape)).all(axis=1)
        asked = tuple(places[inside].T)
        new = np.unique(places[inside][self._voxels[asked] == _UNKNOWN], axis=0)
        for place in new:
            self._voxels[tuple(place)] = self._classified(
                self._low + (place + 0.5) * self._edge)
        inside[inside] = self._voxels[asked] == _INSIDE
        return inside

    def _classified(self, centre: Matrix) -> int:
        result = coal.DistanceResult()
        distance = coal.distance(
            self._shape, coal.Transform3s(np.eye(3), np.zeros(3)), _POINT,
            coal.Transform3s(np.eye(3), centre), coal.DistanceRequest(), result)
        behind = self._normals[result.b1] @ (centre - result.getNearestPoint1()) < 0.0
        return _INSIDE if distance <= self._offset or behind else _OUTSIDE


_POINT = coal.Sphere(1e-9)
