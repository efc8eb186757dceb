# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The bodies of a scene as placed shapes, and which of them have to be checked."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from armsim_ros.arrays import Mask, Matrix
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Geometry, Mesh
from armsim_ros.planning.collision.contacts import BodyType
from armsim_ros.planning.collision.geometry import exact_shape, hull_shape, scaled
from armsim_ros.planning.scene.allowed_collision_matrix import AllowedCollisionMatrix
from armsim_ros.planning.scene.attached_object import AttachedObject
from armsim_ros.planning.scene.content import SceneContent
from armsim_ros.planning.scene.world_object import CollisionObject

BodyKey = tuple[BodyType, str]


class Against(Enum):
    """What a link's shape is checked against; a scaled link has a shape for each."""

    ALL = 'all'
    ROBOT = 'robot'
    WORLD = 'world'


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """
    A link, world object or attached object.

    :param link: the link that carries it; '' in the world.
    :param touch_links: names that an attached object may touch.
    """

    type: BodyType
    name: str
    link: str = ''
    touch_links: frozenset[str] = frozenset()

    @property
    def key(self) -> BodyKey:
        """Type and name, unique in a scene."""
        return self.type, self.name


@dataclass(frozen=True, slots=True, eq=False)
class PlacedShape:
    """
    A shape of a body.

    :param joint: Pinocchio's joint number.
    :param pose: (4, 4) on the joint.
    :param hull: coal shape for the search; the exact one unless that is a mesh of the robot.
    """

    body: Body
    joint: int
    pose: Matrix
    exact: Any
    hull: Any
    against: Against = Against.ALL


def link_shapes(kinematics: KinematicModel, link: str, scale: float) -> list[PlacedShape]:
    """Return the placed shapes of a link; with a scale, one for the robot, one for the world."""
    body = Body(BodyType.ROBOT_LINK, link, link)
    joint, offset = kinematics.link_joint(link)
    shapes = []
    for item in kinematics.robot.links[link].collisions:
        pose = offset @ item.origin
        plain = item.geometry
        if scale == 1.0:
            shapes.append(_placed(body, joint, pose, plain, Against.ALL))
        else:
            larger = scaled(plain, scale)
            shapes.append(_placed(body, joint, pose, plain, Against.ROBOT))
            shapes.append(_placed(body, joint, pose, larger, Against.WORLD))
    return shapes


def world_shapes(item: CollisionObject) -> list[PlacedShape]:
    """Return the placed shapes of a world object."""
    body = Body(BodyType.WORLD_OBJECT, item.id)
    return [
        PlacedShape(body, 0, pose, exact, exact)
        for pose, exact in zip(
            world_poses(item), (exact_shape(s.geometry) for s in item.shapes), strict=True
        )
    ]


def world_poses(item: CollisionObject) -> Iterator[Matrix]:
    """Yield the poses (4, 4) of an object's shapes in the model frame."""
    return (item.pose @ shape.pose for shape in item.shapes)


def attached_shapes(kinematics: KinematicModel, item: AttachedObject) -> list[PlacedShape]:
    """Return the placed shapes of an attached object."""
    body = Body(BodyType.ROBOT_ATTACHED, item.id, item.link_name, frozenset(item.touch_links))
    joint = kinematics.link_joint(item.link_name)[0]
    return [
        _placed(body, joint, pose, shape.geometry, Against.ALL)
        for pose, shape in zip(
            attached_poses(kinematics, item), item.object.shapes, strict=True
        )
    ]


def attached_poses(kinematics: KinematicModel, item: AttachedObject) -> Iterator[Matrix]:
    """Yield the poses (4, 4) of an attached object's shapes on its link's joint."""
    on_joint = kinematics.link_joint(item.link_name)[1] @ item.object.pose
    return (on_joint @ shape.pose for shape in item.object.shapes)


def _placed(
    body: Body, joint: int, pose: Matrix, geometry: Geometry, against: Against
) -> PlacedShape:
    exact = exact_shape(geometry)
    hull = hull_shape(geometry) if isinstance(geometry, Mesh) else exact
    return PlacedShape(body, joint, pose, exact, hull, against)


def must_check(first: Body, second: Body, acm: AllowedCollisionMatrix) -> bool:
    """
    Return whether two bodies may not touch.

    Two world objects are never checked. An attached object may touch what its touch links
    name, and what else its link carries, but not its own link unless that is named.
    """
    if first.key == second.key or not (first.link or second.link):
        return False
    carried_1 = first.type is BodyType.ROBOT_ATTACHED
    carried_2 = second.type is BodyType.ROBOT_ATTACHED
    if carried_1 and carried_2 and first.link == second.link:
        return False
    # A world object that bears a link's name is no link: it is not exempt.
    if first.link and second.link and (
        (carried_1 and second.name in first.touch_links)
        or (carried_2 and first.name in second.touch_links)
    ):
        return False
    return not acm.allowed(first.name, second.name)


def required_pairs(
    carried: Sequence[PlacedShape], standing: Sequence[PlacedShape],
    acm: AllowedCollisionMatrix, *, among: bool,
) -> Mask:
    """
    Return which pairs (g, g) have to be checked, upper triangle.

    :param carried: shapes of the robot and of what it carries, numbered first.
    :param standing: shapes of the world.
    :param among: whether to check the carried shapes against each other.
    """
    shapes = [*carried, *standing]
    required = np.zeros((len(shapes), len(shapes)), dtype=bool)
    robot, world = _by_body(carried, 0), _by_body(standing, len(carried))
    scaled = any(shape.against is not Against.ALL for shape in carried)
    for k, (one, mine) in enumerate(robot):
        for other, theirs in (*(robot[k + 1:] if among else ()), *world):
            if must_check(one, other, acm):
                for i in mine:
                    for j in theirs:
                        required[i, j] = not scaled or fits(shapes[i], shapes[j])
    return required


def _by_body(shapes: Sequence[PlacedShape], first: int) -> list[tuple[Body, list[int]]]:
    """Return the numbers of the shapes of each body, in one piece; they begin at ``first``."""
    bodies: list[tuple[Body, list[int]]] = []
    for number, shape in enumerate(shapes, first):
        if not bodies or bodies[-1][0] is not shape.body:
            bodies.append((shape.body, []))
        bodies[-1][1].append(number)
    return bodies


def fits(first: PlacedShape, second: PlacedShape) -> bool:
    """Return whether the two shapes are those that the two bodies show to each other."""
    world = not (first.body.link and second.body.link)
    unfit = Against.ROBOT if world else Against.WORLD
    return first.against is not unfit and second.against is not unfit


def padding(first: PlacedShape, second: PlacedShape, content: SceneContent) -> float:
    """Return the distance [m] that counts as contact: the link's padding against the world."""
    for one, other in ((first, second), (second, first)):
        if one.body.type is BodyType.ROBOT_LINK and not other.body.link:
            return content.link_padding.get(one.body.name, 0.0)
    return 0.0


def margins(shapes: Sequence[PlacedShape], content: SceneContent) -> Matrix:
    """Return the padding (g, g) [m] of all pairs."""
    of_link = np.array(
        [
            content.link_padding.get(shape.body.name, 0.0)
            if shape.body.type is BodyType.ROBOT_LINK
            else 0.0
            for shape in shapes
        ]
    )
    world = np.array([not shape.body.link for shape in shapes])
    result: Matrix = np.outer(of_link, world) + np.outer(world, of_link)
    return result
