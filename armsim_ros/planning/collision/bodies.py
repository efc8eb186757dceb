# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Bodies of a scene and their shapes, as coal checks them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from armsim_ros.arrays import Mask, Matrix
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.coal_shapes import exact_shape, hull_shape
from armsim_ros.model.geometry import corner_points, Geometry, Mesh, scaled
from armsim_ros.planning.collision.contacts import BodyType
from armsim_ros.planning.collision.octree_shapes import octree_shapes
from armsim_ros.planning.scene.allowed_collision_matrix import AllowedCollisionMatrix
from armsim_ros.planning.scene.content import SceneContent
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, OCTOMAP_ID
from armsim_ros.planning.scene.octomap import Octomap

BodyKey = tuple[BodyType, str]


class Against(Enum):
    """What a shape is checked against; a scaled link and its loads have a shape for each."""

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
    :param hull: coal shape for the search; the exact shape unless that is a mesh of the robot.
    """

    body: Body
    joint: int
    pose: Matrix
    exact: Any
    hull: Any
    against: Against = Against.ALL


def link_shapes(kinematics: KinematicModel, link: str, scale: float) -> list[PlacedShape]:
    """Return the placed shapes of a link; with a scale, separate ones for robot and world."""
    body = Body(BodyType.ROBOT_LINK, link, link)
    joint, offset = kinematics.link_joint(link)
    return [
        shape for item in kinematics.robot.links[link].collisions
        for shape in _carried(body, joint, offset @ item.origin, item.geometry, scale)
    ]


def object_shapes(
    kinematics: KinematicModel, item: CollisionObject | AttachedObject, poses: Iterable[Matrix],
    scale: float,
) -> list[PlacedShape]:
    """
    Return the placed shapes of an object in the world or on a link.

    :param poses: (4, 4) each, as :func:`shape_poses` gives them.
    :param scale: of the link that carries it; with a scale, there are shapes for robot and world.
    """
    if isinstance(item, AttachedObject):
        body = Body(BodyType.ROBOT_ATTACHED, item.id, item.link_name, frozenset(item.touch_links))
        joint = kinematics.link_joint(item.link_name)[0]
        return [
            placed for shape, pose in zip(item.object.shapes, poses, strict=True)
            for placed in _carried(body, joint, pose, shape.geometry, scale)
        ]
    body = Body(BodyType.WORLD_OBJECT, item.id)
    exact = (exact_shape(shape.geometry) for shape in item.shapes)
    return [PlacedShape(body, 0, pose, shape, shape)
            for shape, pose in zip(exact, poses, strict=True)]


def octomap_shapes(octomap: Octomap) -> list[PlacedShape]:
    """Return the placed shapes of a map, one for each size of its leaves."""
    body = Body(BodyType.WORLD_OBJECT, OCTOMAP_ID)
    return [PlacedShape(body, 0, octomap.pose @ pose, tree, tree)
            for tree, pose in octree_shapes(octomap)]


def shape_poses(
    kinematics: KinematicModel, item: CollisionObject | AttachedObject
) -> Iterator[Matrix]:
    """Yield the poses (4, 4) of an object's shapes on its joint, that of the world is 0."""
    if isinstance(item, AttachedObject):
        on_joint = kinematics.link_joint(item.link_name)[1] @ item.object.pose
        return (on_joint @ shape.pose for shape in item.object.shapes)
    return (item.pose @ shape.pose for shape in item.shapes)


def points_beside_links(kinematics: KinematicModel, content: SceneContent) -> dict[int, Matrix]:
    """
    Return Pinocchio's joint number -> points (k, 3) [m] around what it carries in a scene.

    That are attached objects and shapes that are scaled; the links as they are do not count.
    """
    points: dict[int, list[Matrix]] = {}
    for link, scale in content.link_scale.items():
        joint, offset = kinematics.link_joint(link)
        points.setdefault(joint, []).extend(
            corner_points(scaled(item.geometry, scale), offset @ item.origin)
            for item in kinematics.robot.links[link].collisions)
    for load in content.attached.values():
        larger = max(1.0, content.link_scale.get(load.link_name, 1.0))
        points.setdefault(kinematics.link_joint(load.link_name)[0], []).extend(
            corner_points(scaled(shape.geometry, larger), pose) for shape, pose in
            zip(load.object.shapes, shape_poses(kinematics, load), strict=True))
    return {joint: np.vstack(parts) for joint, parts in points.items() if parts}


def only_moved(
    before: CollisionObject | AttachedObject, after: CollisionObject | AttachedObject
) -> bool:
    """Return whether an object differs from what it was by poses at most."""
    def parts(item: CollisionObject | AttachedObject) -> tuple[object, ...]:
        if isinstance(item, AttachedObject):
            return item.link_name, item.touch_links, *parts(item.object)
        return tuple(id(shape.geometry) for shape in item.shapes)

    return parts(before) == parts(after)


def _carried(
    body: Body, joint: int, pose: Matrix, geometry: Geometry, scale: float
) -> Iterator[PlacedShape]:
    """Yield a shape of the robot or its load, or two where the world sees it scaled."""
    if scale == 1.0:
        yield _placed(body, joint, pose, geometry, Against.ALL)
    else:
        yield _placed(body, joint, pose, geometry, Against.ROBOT)
        yield _placed(body, joint, pose, scaled(geometry, scale), Against.WORLD)


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
    # A world object that bears a link's name is not a link: it is not exempt.
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
    for k, (body, numbers) in enumerate(robot):
        for other, others in (*(robot[k + 1:] if among else ()), *world):
            if must_check(body, other, acm):
                for i in numbers:
                    for j in others:
                        required[i, j] = not scaled or fits(shapes[i], shapes[j])
    return required


def _by_body(shapes: Sequence[PlacedShape], first: int) -> list[tuple[Body, list[int]]]:
    """Return the numbers of the shapes of each body, contiguous; they begin at ``first``."""
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


def margins(shapes: Sequence[PlacedShape], content: SceneContent) -> Matrix:
    """Return the padding (g, g) [m] of all pairs; that of a link holds for what it carries."""
    of_link = np.array([content.link_padding.get(shape.body.link, 0.0) for shape in shapes])
    world = np.array([not shape.body.link for shape in shapes])
    result: Matrix = np.outer(of_link, world) + np.outer(world, of_link)
    return result
