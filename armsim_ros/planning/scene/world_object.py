# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects that stand in the world of a planning scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from armsim_ros.arrays import Matrix
from armsim_ros.model.geometry import Geometry


@dataclass(frozen=True, slots=True)
class ObjectType:
    """Content of ``object_recognition_msgs/msg/ObjectType``: a key in a data base."""

    key: str = ''
    db: str = ''

    @property
    def empty(self) -> bool:
        """Whether no type is given."""
        return not (self.key or self.db)


@dataclass(frozen=True, slots=True, eq=False)
class ObjectShape:
    """A shape and its pose (4, 4) in the frame of the object that it belongs to."""

    geometry: Geometry
    pose: Matrix


@dataclass(frozen=True, slots=True, eq=False)
class CollisionObject:
    """
    A rigid object; it never changes, an edit makes a new one.

    :param id: unique in the world.
    :param pose: (4, 4) in the model frame, or in a link's frame while attached.
    :param shapes: at least one.
    :param subframes: name -> pose (4, 4) in the object's frame.
    """

    id: str
    pose: Matrix
    shapes: tuple[ObjectShape, ...]
    subframes: Mapping[str, Matrix] = field(default_factory=lambda: MappingProxyType({}))
    type: ObjectType = field(default_factory=ObjectType)

    def at(self, pose: Matrix) -> CollisionObject:
        """Return the same object at another pose (4, 4)."""
        return replace(self, pose=pose)
