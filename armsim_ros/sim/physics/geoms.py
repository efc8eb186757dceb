# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes as MuJoCo geoms, and what touches them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import SimulationError
from armsim_ros.model.geometry import Box, Capsule, Cone, Cylinder, Geometry, Mesh, Plane, Sphere
from armsim_ros.model.robot_model import Inertial, LinkGeometry
from armsim_ros.model.transforms import (
    matrix_from_axis_angle,
    matrix_from_quat_wxyz,
    pose_from_parts,
    quat_wxyz_from_matrix,
)
from armsim_ros.sim.physics.compiler import compile_model

#: Geom groups, as MuJoCo's viewers show and hide them.
WORLD_GROUP, VISUAL_GROUP, COLLISION_GROUP = 0, 2, 3
#: Robot and objects touch each other; MuJoCo wants bits for it.
TOUCHING, SEEN_ONLY = {'contype': 1, 'conaffinity': 1}, {'contype': 0, 'conaffinity': 0}
#: Corners of the circle that represents a cone's base.
CONE_CORNERS = 24
#: Thickness that a flat mesh gets [m]; MuJoCo refuses meshes without volume.
LEAST_THICKNESS = 1e-5
#: Half size of a plane as it is drawn [m]; its contact has no end.
PLANE_HALF_SIZE = 10.0


def add_geom(
    spec: Any, body: Any, geometry: Geometry, pose: Matrix, *, mesh_name: str, **fields: Any
) -> Any:
    """
    Add a shape to a body.

    :param spec: the ``MjSpec`` that takes the mesh, if any.
    :param body: an ``MjsBody``.
    :param pose: (4, 4) in the body's frame.
    :param mesh_name: unique in the specification; used for meshes and cones only.
    :param fields: further fields of the geom.
    :returns: the ``MjsGeom``.
    """
    kind, size = _primitive(geometry)
    if isinstance(geometry, Plane):
        pose = pose @ _plane_pose(geometry)
    geom = body.add_geom(
        type=kind, pos=pose[:3, 3], quat=quat_wxyz_from_matrix(pose), size=size, **fields)
    if isinstance(geometry, Cone):
        geometry = _cone_mesh(geometry)
    if isinstance(geometry, Mesh):
        geometry = _thickened(geometry)
        mesh = spec.add_mesh(name=mesh_name)
        mesh.uservert = np.asarray(geometry.vertices, dtype=np.float64).ravel()
        mesh.userface = np.asarray(geometry.triangles, dtype=np.int32).ravel()
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        geom.meshname = mesh_name
    return geom


def volume(geometry: Geometry) -> float:
    """
    Return the volume of a shape [m^3].

    A mesh counts with the volume it encloses; where it is a mere sheet, with that of its hull.

    :raises SimulationError: a plane, or a mesh without area.
    """
    if isinstance(geometry, Box):
        return math.prod(geometry.size)
    if isinstance(geometry, Sphere):
        return 4.0 / 3.0 * math.pi * geometry.radius**3
    if isinstance(geometry, Cylinder):
        return math.pi * geometry.radius**2 * geometry.length
    if isinstance(geometry, Capsule):
        return math.pi * geometry.radius**2 * (geometry.length + 4.0 / 3.0 * geometry.radius)
    if isinstance(geometry, Cone):
        return math.pi * geometry.radius**2 * geometry.length / 3.0
    if isinstance(geometry, Mesh):
        corners = geometry.vertices - geometry.vertices.mean(axis=0)
        a, b, c = (corners[geometry.triangles[:, i]] for i in range(3))
        enclosed = abs(float(np.einsum('ij,ij->', a, np.cross(b, c)))) / 6.0
        area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
        return enclosed if enclosed > LEAST_THICKNESS * area else _hull_volume(geometry)
    raise SimulationError('a plane has no volume, so it cannot be part of an object with mass')


def solid_inertial(parts: Sequence[LinkGeometry], masses: Sequence[float]) -> Inertial:
    """
    Return the mass properties of shapes that are filled evenly, as MuJoCo has them.

    :param parts: at least one, in the frame that they share.
    :param masses: of each [kg].
    :raises SimulationError: MuJoCo refuses a shape.
    """
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body()
    for number, (part, mass) in enumerate(zip(parts, masses, strict=True)):
        add_geom(spec, body, part.geometry, part.origin, mesh_name=str(number), mass=mass)
    model = compile_model(spec)
    pose = pose_from_parts(model.body_ipos[1], matrix_from_quat_wxyz(model.body_iquat[1]))
    return Inertial(float(model.body_mass[1]), pose, np.diag(model.body_inertia[1]))


def _primitive(geometry: Geometry) -> tuple[Any, list[float]]:
    kinds = mujoco.mjtGeom
    if isinstance(geometry, Box):
        return kinds.mjGEOM_BOX, [0.5 * side for side in geometry.size]
    if isinstance(geometry, Sphere):
        return kinds.mjGEOM_SPHERE, [geometry.radius, 0.0, 0.0]
    if isinstance(geometry, Cylinder):
        return kinds.mjGEOM_CYLINDER, [geometry.radius, 0.5 * geometry.length, 0.0]
    if isinstance(geometry, Capsule):
        return kinds.mjGEOM_CAPSULE, [geometry.radius, 0.5 * geometry.length, 0.0]
    if isinstance(geometry, Plane):
        return kinds.mjGEOM_PLANE, [PLANE_HALF_SIZE, PLANE_HALF_SIZE, 0.1]
    return kinds.mjGEOM_MESH, [0.0, 0.0, 0.0]


def _plane_pose(plane: Plane) -> Matrix:
    """Return the pose whose z axis is the plane's normal and whose origin lies on it."""
    normal = np.array([plane.a, plane.b, plane.c], dtype=np.float64)
    length = float(np.linalg.norm(normal))
    normal /= length
    axis = np.cross([0.0, 0.0, 1.0], normal)
    sine = float(np.linalg.norm(axis))
    axis = axis / sine if sine > 1e-9 else np.array([1.0, 0.0, 0.0])
    rotation = matrix_from_axis_angle(axis, math.atan2(sine, float(normal[2])))
    return pose_from_parts(-plane.d / length * normal, rotation)


def _cone_mesh(cone: Cone) -> Mesh:
    angles = np.linspace(0.0, 2.0 * math.pi, CONE_CORNERS, endpoint=False)
    half = 0.5 * cone.length
    base = np.column_stack(
        [cone.radius * np.cos(angles), cone.radius * np.sin(angles), np.full(CONE_CORNERS, -half)])
    apex, centre = CONE_CORNERS, CONE_CORNERS + 1
    vertices = np.vstack([base, [0.0, 0.0, half], [0.0, 0.0, -half]])
    triangles = []
    for i in range(CONE_CORNERS):
        j = (i + 1) % CONE_CORNERS
        triangles += [(i, j, apex), (j, i, centre)]
    return Mesh(vertices, np.array(triangles, dtype=np.int64))


def _thickened(mesh: Mesh) -> Mesh:
    """Return a mesh that is flat, such as a sheet, with some thickness; others as they are."""
    arms = mesh.vertices - mesh.vertices.mean(axis=0)
    normal = np.linalg.eigh(arms.T @ arms)[1][:, 0]
    if np.ptp(arms @ normal) >= LEAST_THICKNESS:
        return mesh
    half = 0.5 * LEAST_THICKNESS * normal
    sides = np.vstack([mesh.vertices - half, mesh.vertices + half])
    other = mesh.triangles[:, ::-1] + len(mesh.vertices)
    return Mesh(sides, np.vstack([mesh.triangles, other]), mesh.uri)


def _hull_volume(mesh: Mesh) -> float:
    """Return the volume that MuJoCo finds for a mesh [m^3]."""
    spec = mujoco.MjSpec()
    add_geom(spec, spec.worldbody.add_body(), mesh, np.eye(4), mesh_name='mesh', density=1.0)
    return float(compile_model(spec).body_mass[1])


_NOTHING = np.empty((0, 2), dtype=np.int32), np.empty(0)


@dataclass(frozen=True, slots=True)
class BodyContact:
    """
    Two bodies that touch.

    :param bodies: ``robot/link``, ``object/name`` or ``world``.
    :param depth: how far they overlap [m]; negative where there is still a gap.
    """

    bodies: tuple[str, str]
    depth: float


def contacts(model: Any, data: Any) -> tuple[BodyContact, ...]:
    """Return the contacts of the last step, the deepest first."""
    bodies, depths = touching(model, data)
    found = [
        BodyContact((model.body(first).name, model.body(second).name), depth)
        for (first, second), depth in zip(bodies.tolist(), depths.tolist(), strict=True)]
    return tuple(sorted(found, key=lambda contact: -contact.depth))


def touching(model: Any, data: Any) -> tuple[NDArray[np.int32], Vector]:
    """Return bodies (n, 2) and overlaps (n,) [m] of the contacts of the last step."""
    if not data.ncon:
        return _NOTHING
    found = data.contact
    return model.geom_bodyid[found.geom[: data.ncon]], -found.dist[: data.ncon]
