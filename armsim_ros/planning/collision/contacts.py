# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What touches what, and where."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from armsim_ros.arrays import Vector


class BodyType(IntEnum):
    """Constants of ``moveit_msgs/msg/ContactInformation``."""

    ROBOT_LINK = 0
    WORLD_OBJECT = 1
    ROBOT_ATTACHED = 2


_WORDS = {
    BodyType.ROBOT_LINK: 'link',
    BodyType.WORLD_OBJECT: 'object',
    BodyType.ROBOT_ATTACHED: 'attached object',
}


@dataclass(frozen=True, slots=True, eq=False)
class Contact:
    """
    The deepest contact of two bodies.

    :param position: (3,) [m] in the model frame.
    :param normal: (3,) unit vector from the first body to the second.
    :param depth: [m] how far they overlap, padding included.
    """

    body1: str
    body2: str
    type1: BodyType
    type2: BodyType
    position: Vector
    normal: Vector
    depth: float

    def __str__(self) -> str:
        """Return a phrase that names both bodies."""
        first = f"{_WORDS[self.type1]} '{self.body1}'"
        second = f"{_WORDS[self.type2]} '{self.body2}'"
        return f'{first} touches {second} (overlap {1000.0 * self.depth:.3g} mm)'


@dataclass(frozen=True, slots=True)
class PairDistance:
    """
    How far two shapes are apart.

    :param names: of their bodies, links first, objects of the world last.
    :param types: of their bodies.
    :param joints: Pinocchio's numbers of the joints that carry them.
    :param distance: [m], padding taken off; not positive where they touch.
    """

    names: tuple[str, str]
    types: tuple[BodyType, BodyType]
    joints: tuple[int, int]
    distance: float

    @property
    def phrase(self) -> str:
        """Both bodies in words."""
        first, second = (
            f"{_WORDS[kind]} '{name}'" for kind, name in zip(self.types, self.names, strict=True)
        )
        return f'{first} and {second}'
