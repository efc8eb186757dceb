# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Settings of what surrounds the robot (``worlds/<name>.yaml``).

A world is a floor, named objects and, optionally, gravity. An object has one or more
parts that hold together; with a mass it falls and can be pushed, without mass it stays where it
is::

    floor: true
    objects:
      table:
        parts:
          - {shape: {type: box, size: [1.5, 0.8, 0.03]}, xyz: [0, 0, 1.0]}
          - {shape: {type: cylinder, radius: 0.02, length: 1.0}, xyz: [0.7, 0.35, 0.5]}
      cube:
        xyz: [0.16, 0.25, 1.04]
        mass: 0.32
        parts: [{shape: {type: box, size: [0.08, 0.08, 0.025]}}]
        color: [0.8, 0.2, 0.1, 1]
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, field_validator, FiniteFloat

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.simulation import finite_triple, Triple

Positive = Annotated[float, Field(gt=0.0, le=1000.0)]
Unit = Annotated[float, Field(ge=0.0, le=1.0)]
Point = Annotated[list[float], Field(min_length=2, max_length=2)]


def convex_outline(corners: Sequence[Sequence[float]]) -> list[tuple[float, float]]:
    """
    Return the corners of a convex polygon in counter-clockwise order.

    :param corners: (n, 2) in order, either sense [m].
    :raises ValueError: the polygon is not convex or has no area.
    """
    outline = [(float(x), float(y)) for x, y in corners]
    turns = []
    for i, (x, y) in enumerate(outline):
        (x1, y1), (x2, y2) = outline[i - 2], outline[i - 1]
        turns.append((x1 - x2) * (y - y2) - (y1 - y2) * (x - x2))
    # A turn to the left makes the product negative: the first edge is taken backwards.
    if sum(turns) > 0.0:
        outline, turns = outline[::-1], [-turn for turn in turns]
    if not all(turn <= 1e-12 for turn in turns) or not min(turns) < -1e-12:
        raise ValueError(
            'the corners of a prism must form a convex polygon with an area; build other '
            'outlines from several convex parts')
    return outline


class BoxSettings(Settings):
    """A box centred at its frame."""

    type: Literal['box']
    size: tuple[Positive, Positive, Positive] = parameter(description='x, y, z [m]')


class SphereSettings(Settings):
    """A sphere centred at its frame."""

    type: Literal['sphere']
    radius: Positive = parameter(description='[m]')


class CylinderSettings(Settings):
    """A cylinder along z, centred at its frame."""

    type: Literal['cylinder']
    radius: Positive = parameter(description='[m]')
    length: Positive = parameter(description='[m]')


class CapsuleSettings(Settings):
    """A capsule along z, centred at its frame."""

    type: Literal['capsule']
    radius: Positive = parameter(description='[m]')
    length: Positive = parameter(description='length without the caps [m]')


class ConeSettings(Settings):
    """A cone along z, apex up, centred at half its height."""

    type: Literal['cone']
    radius: Positive = parameter(description='[m]')
    length: Positive = parameter(description='[m]')


class PrismSettings(Settings):
    """A convex polygon in x, y, extruded along z and centred at half its height."""

    type: Literal['prism']
    corners: Annotated[list[Point], Field(min_length=3, max_length=200)] = parameter(
        description='corners of the polygon in order, (x, y) [m]')
    length: Positive = parameter(description='height along z [m]')

    @field_validator('corners')
    @classmethod
    def _convex(cls, corners: list[list[float]]) -> list[list[float]]:
        convex_outline(corners)
        return corners


ShapeSettings = Annotated[
    BoxSettings
    | SphereSettings
    | CylinderSettings
    | CapsuleSettings
    | ConeSettings
    | PrismSettings,
    Field(discriminator='type'),
]


class PartSettings(Settings):
    """A shape of an object and its pose in the object's frame."""

    shape: ShapeSettings
    xyz: Triple = parameter((0.0, 0.0, 0.0), 'position in the object [m]')
    rpy: Triple = parameter((0.0, 0.0, 0.0), 'roll, pitch, yaw in the object [rad]')

    _all_finite = field_validator('xyz', 'rpy')(finite_triple)


class WorldObjectSettings(Settings):
    """An object of the world."""

    parts: Annotated[list[PartSettings], Field(min_length=1)]
    xyz: Triple = parameter((0.0, 0.0, 0.0), 'position in the world [m]')
    rpy: Triple = parameter((0.0, 0.0, 0.0), 'roll, pitch, yaw in the world [rad]')
    mass: float | None = parameter(
        None, 'mass [kg], spread evenly over the parts; none: the object never moves', gt=0.0)
    friction: float = parameter(0.8, 'coefficient of sliding friction', ge=0.0, le=10.0)
    color: tuple[Unit, Unit, Unit, Unit] = parameter((0.6, 0.6, 0.6, 1.0), 'r, g, b, a in 0..1')

    _all_finite = field_validator('xyz', 'rpy')(finite_triple)


#: Ends of the names of worlds that are not in our YAML: SDF and MJCF.
FOREIGN_WORLDS = ('.sdf', '.world', '.xml', '.mjcf')


def is_foreign_world(file: Path | None) -> bool:
    """Return whether a world's file is SDF or MJCF, which the simulation alone reads."""
    return file is not None and file.suffix in FOREIGN_WORLDS


class WorldSettings(Settings):
    """A world file."""

    floor: bool | FiniteFloat = parameter(
        True, 'true: a floor at z = 0; a number: at that height [m]')
    gravity: Triple | None = parameter(None, 'gravity [m/s^2]; none: that of simulation.yaml')
    objects: dict[str, WorldObjectSettings] = parameter({}, 'name -> object')

    @property
    def floor_height(self) -> float | None:
        """Height of the floor [m]; None where there is none."""
        if isinstance(self.floor, bool):
            return 0.0 if self.floor else None
        return self.floor

    @field_validator('gravity')
    @classmethod
    def _finite_gravity(cls, value: Triple | None) -> Triple | None:
        return None if value is None else finite_triple(value)
