# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a planning scene holds at one moment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from armsim_ros.planning.allowed_collision_matrix import AllowedCollisionMatrix
from armsim_ros.planning.attached_object import AttachedObject
from armsim_ros.planning.scene_update import Color
from armsim_ros.planning.world_object import CollisionObject

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Value = TypeVar('Value')


def _nothing() -> Mapping[str, Value]:
    return MappingProxyType({})


@dataclass(frozen=True, slots=True, eq=False)
class SceneContent:
    """
    Robot state, world, attached objects and rules; nothing in it ever changes.

    Parts that an edit leaves alone are shared between contents, so a part that ``is`` the same
    holds the same.

    :param q: (n,) robot state, read-only.
    :param objects: id -> object in the world.
    :param attached: id -> object on the robot.
    :param link_padding: link -> [m] added around it against the world.
    :param link_scale: link -> factor of its size against the world.
    :param frames: further frames -> pose (4, 4) in the model frame.
    :param colors: object id -> rgba in 0..1.
    """

    q: Vector
    name: str = ''
    objects: Mapping[str, CollisionObject] = field(default_factory=_nothing)
    attached: Mapping[str, AttachedObject] = field(default_factory=_nothing)
    acm: AllowedCollisionMatrix = field(default_factory=AllowedCollisionMatrix)
    link_padding: Mapping[str, float] = field(default_factory=_nothing)
    link_scale: Mapping[str, float] = field(default_factory=_nothing)
    frames: Mapping[str, Matrix] = field(default_factory=_nothing)
    colors: Mapping[str, Color] = field(default_factory=_nothing)


def with_item(mapping: Mapping[str, Value], key: str, value: Value) -> Mapping[str, Value]:
    """Return a read-only copy with one item more, or another value in its old place."""
    return MappingProxyType({**mapping, key: value})


def without_items(mapping: Mapping[str, Value], *keys: str) -> Mapping[str, Value]:
    """Return a read-only copy without some keys; the mapping itself if it had none of them."""
    if not any(key in mapping for key in keys):
        return mapping
    return MappingProxyType({key: value for key, value in mapping.items() if key not in keys})
