# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Shapes of links and of objects in the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Box:
    """A box centred at its frame; ``size`` (x, y, z) [m]."""

    size: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere centred at its frame; ``radius`` [m]."""

    radius: float


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along z, centred at its frame; ``radius``, ``length`` [m]."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Cone:
    """A cone along z, apex up, centred at half its height; ``radius``, ``length`` [m]."""

    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Plane:
    """The half space below ``a*x + b*y + c*z + d = 0``; (a, b, c) is the normal."""

    a: float
    b: float
    c: float
    d: float


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """
    Triangles.

    :param vertices: (v, 3) [m], scale already applied.
    :param triangles: (t, 3) indices.
    :param uri: where it came from, '' for a mesh given by value.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    uri: str = ''


@dataclass(frozen=True, slots=True)
class Capsule:
    """A capsule along z, centred at its frame; ``length`` without the caps [m]."""

    radius: float
    length: float


Geometry = Box | Sphere | Cylinder | Cone | Plane | Mesh | Capsule

__all__ = ['Box', 'Capsule', 'Cone', 'Cylinder', 'Geometry', 'Mesh', 'Plane', 'Sphere']
