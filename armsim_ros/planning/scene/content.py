# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a planning scene holds at one moment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TypeVar

from armsim_ros.arrays import Vector
from armsim_ros.planning.scene.allowed_collision_matrix import AllowedCollisionMatrix
from armsim_ros.planning.scene.attached_object import AttachedObject
from armsim_ros.planning.scene.update import Color, FixedFrame
from armsim_ros.planning.scene.world_object import CollisionObject

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
    :param frames: further frames, each fixed to another one.
    :param colors: object id -> rgba in 0..1.
    """

    q: Vector
    name: str = ''
    objects: Mapping[str, CollisionObject] = field(default_factory=_nothing)
    attached: Mapping[str, AttachedObject] = field(default_factory=_nothing)
    acm: AllowedCollisionMatrix = field(default_factory=AllowedCollisionMatrix)
    link_padding: Mapping[str, float] = field(default_factory=_nothing)
    link_scale: Mapping[str, float] = field(default_factory=_nothing)
    frames: Mapping[str, FixedFrame] = field(default_factory=_nothing)
    colors: Mapping[str, Color] = field(default_factory=_nothing)

