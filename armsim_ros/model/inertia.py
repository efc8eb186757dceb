# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Mass properties: whether they can be true, and those of shapes."""

from __future__ import annotations

from collections.abc import Sequence
import math

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.model.geometry import Box, Capsule, Cone, Cylinder, Geometry, Mesh, Sphere
from armsim_ros.model.robot_model import Inertial, LinkGeometry
from armsim_ros.model.transforms import pose_matrix, skew

#: Density of a shape whose mass is not known [kg/m^3]: hollow links of light metal and motors.
DENSITY = 1000.0
#: Mass and radius of a link that has neither mass nor shape [kg], [m].
POINT_MASS, POINT_RADIUS = 0.01, 0.01
#: Smaller masses [kg] and principal inertias [kg*m^2] are placeholders: of a grain of sand.
LEAST_MASS, LEAST_INERTIA = 1e-6, 1e-12
#: Larger masses [kg] are placeholders, too: the heaviest industrial arms weigh 13 t as a whole.
MOST_MASS = 2e4
#: Above this mean density [kg/m^3] a mass was written in grams; no metal has a quarter of it.
GRAMS_DENSITY = 1e5
#: A centre of mass further from its shapes than so many times their reach was written in mm.
MOST_OFFSET = 20.0

_TOLERANCE = 1e-3
#: How far the smaller principal inertias of a flat body exceed the largest, beyond rounding.
_MARGIN = 1e-6


def implausible(inertial: Inertial, shapes: Sequence[LinkGeometry] = ()) -> str:
    """
    Return why mass properties cannot be true, '' where they can.

    A rigid body has a positive mass, a positive definite inertia whose principal values keep the
    triangle inequality, and none above mass * reach^2. Its centre of mass is near its shapes.

    :param shapes: of the link.
    """
    if not math.isfinite(inertial.mass) or inertial.mass < LEAST_MASS:
        return f'the mass {inertial.mass:g} kg is not above {LEAST_MASS:g} kg'
    if inertial.mass > MOST_MASS:
        return f'the mass {inertial.mass:g} kg is above {MOST_MASS:g} kg'
    if not np.isfinite(inertial.inertia).all():
        return 'the inertia is not finite'
    low, middle, high = (float(value) for value in np.linalg.eigvalsh(inertial.inertia))
    if low < LEAST_INERTIA:
        return f'the inertia is not positive definite (least principal value {low:.3g} kg*m^2)'
    if high > (low + middle) * (1.0 + _TOLERANCE):
        return (f'no body has the principal inertias {low:.3g}, {middle:.3g}, {high:.3g} kg*m^2: '
                'the largest is above the sum of the others')
    if reason := misplaced(inertial, shapes):
        return reason
    reach = reach_of(shapes, inertial.origin[:3, 3])
    if reach is not None:
        most = 2.0 * inertial.mass * max(reach, POINT_RADIUS) ** 2
        if high > most:
            return (f'the inertia {high:.3g} kg*m^2 is too large for {inertial.mass:g} kg within '
                    f'{reach:.3g} m of the centre of mass')
    return ''


def misplaced(inertial: Inertial, shapes: Sequence[LinkGeometry]) -> str:
    """Return why a centre of mass cannot be that of a link with these shapes, '' if it can."""
    reach = reach_of(shapes, inertial.origin[:3, 3])
    if reach is None:
        return ''
    own = max(reach_of(shapes, inertial_of(shapes).origin[:3, 3]) or 0.0, POINT_RADIUS)
    if reach <= MOST_OFFSET * own:
        return ''
    return f'the centre of mass is {reach:.3g} m away from shapes of {own:.3g} m'


def with_plausible_inertia(inertial: Inertial, shapes: Sequence[LinkGeometry]) -> Inertial:
    """
    Return mass properties whose inertia is that of the shapes.

    The mass is kept, and the centre of mass unless it is misplaced. Without shapes the principal
    inertias are raised to the smallest values that a rigid body can have.
    """
    made = inertial_of(shapes, inertial.mass)
    if misplaced(inertial, shapes):
        return made
    inertia = made.inertia
    if not shapes and np.isfinite(inertial.inertia).all():
        rotation = inertial.origin[:3, :3]
        values, axes = np.linalg.eigh(rotation @ inertial.inertia @ rotation.T)
        values = np.maximum(values, made.inertia[0, 0])
        inertia = rigid_inertia(axes * values @ axes.T)
    return Inertial(inertial.mass, pose_matrix(inertial.origin[:3, 3]), inertia)


def rigid_inertia(inertia: Matrix) -> Matrix:
    """
    Return an inertia (3, 3) that keeps the triangle inequality, whatever is rounded.

    The least principal value is raised if the two smaller ones do not add up to the largest.
    """
    values, axes = np.linalg.eigh(inertia)
    least = (1.0 + _MARGIN) * values[2] - values[1]
    if values[0] >= least:
        return inertia
    values[0] = least
    raised: Matrix = axes * values @ axes.T
    return raised


def too_dense(mass: float, *kinds: Sequence[LinkGeometry]) -> bool:
    """Whether a mass above 1 kg is too large for a link's shapes."""
    size = max(sum(volume(shape.geometry) for shape in shapes) for shapes in kinds)
    return 1.0 < mass < math.inf and 0.0 < size < mass / GRAMS_DENSITY


def reach_of(shapes: Sequence[LinkGeometry], centre: Matrix) -> float | None:
    """Return the largest distance of the shapes' bounds from a point (3,) [m]."""
    distances = [float(np.linalg.norm(shape.origin[:3, 3] - centre)) + bounding_radius(
        shape.geometry) for shape in shapes]
    return max(distances, default=None)


def inertial_of(shapes: Sequence[LinkGeometry], mass: float | None = None) -> Inertial:
    """
    Return the mass properties of shapes filled evenly.

    :param mass: [kg]; None takes DENSITY. Without shapes it is a small ball at the origin.
    """
    solids = [(shape, volume(shape.geometry)) for shape in shapes]
    solids = [(shape, size) for shape, size in solids if size > 0.0]
    total = sum(size for _, size in solids)
    if not solids:
        ball = mass if mass is not None else POINT_MASS
        return Inertial(ball, np.eye(4), np.eye(3) * 0.4 * ball * POINT_RADIUS**2)
    weight = mass if mass is not None else DENSITY * total
    parts = [(weight * size / total, shape) for shape, size in solids]
    centre = sum((part * _centre(shape) for part, shape in parts), np.zeros(3)) / weight
    inertia = np.zeros((3, 3))
    for part, shape in parts:
        rotation = shape.origin[:3, :3]
        offset = skew(_centre(shape) - centre)
        inertia += rotation @ unit_inertia(shape.geometry) @ rotation.T * part
        inertia -= part * offset @ offset
    return Inertial(float(weight), pose_matrix(centre), inertia)


def combined(parts: Sequence[Inertial]) -> Inertial:
    """
    Return the mass properties of bodies that hold together, at least one.

    :param parts: each in the frame that they share.
    """
    mass = sum(part.mass for part in parts)
    centre = sum((part.mass * part.origin[:3, 3] for part in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        rotation = part.origin[:3, :3]
        offset = skew(part.origin[:3, 3] - centre)
        inertia += rotation @ part.inertia @ rotation.T - part.mass * offset @ offset
    return Inertial(mass, pose_matrix(centre), inertia)


def _centre(shape: LinkGeometry) -> Matrix:
    """Return the centre of mass (3,) of a shape in the link frame [m]."""
    local = np.zeros(3)
    if isinstance(shape.geometry, Cone):
        local[2] = -0.25 * shape.geometry.length
    elif isinstance(shape.geometry, Mesh):
        low, high = shape.geometry.vertices.min(axis=0), shape.geometry.vertices.max(axis=0)
        local = 0.5 * (low + high)
    centre: Matrix = shape.origin[:3, :3] @ local + shape.origin[:3, 3]
    return centre


def volume(geometry: Geometry) -> float:
    """Return the volume of a shape [m^3]; a mesh counts as its bounding box, a plane as 0."""
    if isinstance(geometry, Box):
        return geometry.size[0] * geometry.size[1] * geometry.size[2]
    if isinstance(geometry, Sphere):
        return 4.0 / 3.0 * math.pi * geometry.radius**3
    if isinstance(geometry, Cylinder):
        return math.pi * geometry.radius**2 * geometry.length
    if isinstance(geometry, Cone):
        return math.pi * geometry.radius**2 * geometry.length / 3.0
    if isinstance(geometry, Capsule):
        return math.pi * geometry.radius**2 * (geometry.length + 4.0 / 3.0 * geometry.radius)
    if isinstance(geometry, Mesh):
        return float(np.prod(_extent(geometry)))
    return 0.0


def unit_inertia(geometry: Geometry) -> Matrix:
    """
    Return the inertia (3, 3) of a solid of 1 kg about its centre of mass [m^2].

    :param geometry: a mesh counts as its bounding box.
    """
    if isinstance(geometry, Sphere):
        return np.eye(3) * 0.4 * geometry.radius**2
    if isinstance(geometry, Cylinder):
        across = (3.0 * geometry.radius**2 + geometry.length**2) / 12.0
        return np.diag([across, across, 0.5 * geometry.radius**2])
    if isinstance(geometry, Cone):
        across = 0.15 * geometry.radius**2 + 0.0375 * geometry.length**2
        return np.diag([across, across, 0.3 * geometry.radius**2])
    if isinstance(geometry, Capsule):
        return _capsule_inertia(geometry.radius, geometry.length)
    x, y, z = (geometry.size if isinstance(geometry, Box)
               else _extent(geometry) if isinstance(geometry, Mesh) else (0.0, 0.0, 0.0))
    return np.diag([y * y + z * z, x * x + z * z, x * x + y * y]) / 12.0


def bounding_radius(geometry: Geometry) -> float:
    """Return the largest distance of a shape from its origin [m]; 0 for a plane."""
    if isinstance(geometry, Box):
        return 0.5 * math.hypot(*geometry.size)
    if isinstance(geometry, Sphere):
        return geometry.radius
    if isinstance(geometry, (Cylinder, Cone)):
        return math.hypot(geometry.radius, 0.5 * geometry.length)
    if isinstance(geometry, Capsule):
        return geometry.radius + 0.5 * geometry.length
    if isinstance(geometry, Mesh):
        return float(np.linalg.norm(geometry.vertices, axis=1).max())
    return 0.0


def _extent(mesh: Mesh) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in mesh.vertices.max(axis=0) - mesh.vertices.min(axis=0))
    return x, y, z


def _capsule_inertia(radius: float, length: float) -> Matrix:
    """Return the unit inertia of a cylinder between two half balls, by the parallel axes."""
    ball = 4.0 / 3.0 * radius / (length + 4.0 / 3.0 * radius)
    rod = 1.0 - ball
    along = rod * 0.5 * radius**2 + ball * 0.4 * radius**2
    across = rod * (3.0 * radius**2 + length**2) / 12.0
    across += ball * (0.4 * radius**2 + 0.375 * radius * length + 0.25 * length**2)
    return np.diag([across, across, along])
