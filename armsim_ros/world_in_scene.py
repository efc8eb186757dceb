# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulated world in a planning scene of the same process, by the rules of move_group's."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
import logging
from typing import TYPE_CHECKING

from armsim_ros.arrays import Matrix
from armsim_ros.model.grippers import Gripper
from armsim_ros.model.tree import standing_links
from armsim_ros.model.world_objects import WORLD_TYPE
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    ObjectOperation,
    ObjectType,
)
from armsim_ros.planning.scene.update import SceneUpdate, StartState
from armsim_ros.scene_sources.simulated_world import collision_object, WorldOwnership
from armsim_ros.sim.simulation import Simulation
from armsim_ros.sim.world.world_mirror import Holder, WorldMirror, WorldNews, WorldWatch

if TYPE_CHECKING:
    from armsim_ros.planning.scene.planning_scene import PlanningScene


class WorldInScene:
    """
    Lets a scene follow a simulated world; the user's own objects are left alone.

    :param simulation: has the world.
    :param scene: follows.
    :param root: (4, 4) pose of the world in the scene's root link.
    :param fingers: returns what fingers hold.
    """

    def __init__(
        self,
        simulation: Simulation,
        scene: PlanningScene,
        root: Matrix,
        fingers: Callable[[], Mapping[str, Gripper]],
    ) -> None:
        self._root = root
        self._watch = WorldWatch(simulation.world, simulation.vacuum_grippers.values(), fingers)
        self._mirror = WorldMirror()
        self._ownership = WorldOwnership(
            scene, standing_links(simulation.model), logging.getLogger('armsim_ros.stack').info)

    def follow(self, names: frozenset[str] | None = None) -> None:
        """
        Bring the scene to what the world is now.

        :param names: objects that the scene shall know; None for all, and the floor.
        :raises PlanningError: the scene cannot take an object; it has the others.
        """
        now = self._watch.look()
        if names is not None:
            now = replace(
                now, objects={name: item for name, item in now.objects.items() if name in names},
                held={name: holder for name, holder in now.held.items() if name in names})
        for update in self._updates(self._mirror.news(now)):
            self._ownership.apply(update)

    def _updates(self, news: WorldNews) -> Iterator[SceneUpdate]:
        """Yield the updates that have to be applied in sequence."""
        kind = ObjectType(WORLD_TYPE)
        if news.released:
            yield _grasps(news.released, ObjectOperation.REMOVE)
        objects = [CollisionObject(name, ObjectOperation.REMOVE, type=kind)
                   for name in news.removed]
        objects += [replace(collision_object(replace(item, pose=pose), self._root), type=kind)
                    for item, pose in news.added]
        objects += [CollisionObject(name, ObjectOperation.MOVE, pose=self._root @ pose, type=kind)
                    for name, pose in news.moved]
        if objects:
            yield SceneUpdate(objects=tuple(objects))
        if news.grasped:
            yield _grasps(news.grasped, ObjectOperation.ADD)


def _grasps(pairs: tuple[tuple[str, Holder], ...], operation: ObjectOperation) -> SceneUpdate:
    return SceneUpdate(robot_state=StartState(attached_objects=tuple(
        AttachedObject(attached.link, CollisionObject(name, operation), attached.touch_links)
        for name, attached in pairs)))
