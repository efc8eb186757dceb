# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planning scene as a client of move_group sees it."""

from __future__ import annotations

from collections.abc import Callable
import time
from typing import Any

from moveit_msgs.msg import CollisionObject, PlanningScene, PlanningSceneComponents
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene
from shape_msgs.msg import SolidPrimitive
from world_user import pose, WorldUser


class Planner:
    """The planning scene as move_group tells it."""

    def __init__(self, world: WorldUser) -> None:
        self._client = world.client

    def objects(self) -> dict[str, Any]:
        """Return the objects in the world by id."""
        wanted = (PlanningSceneComponents.WORLD_OBJECT_GEOMETRY
                  | PlanningSceneComponents.WORLD_OBJECT_NAMES
                  | PlanningSceneComponents.OBJECT_COLORS)
        request = GetPlanningScene.Request(
            components=PlanningSceneComponents(components=wanted))
        self.scene = self._client.call('/get_planning_scene', GetPlanningScene, request).scene
        return {one.id: one for one in self.scene.world.collision_objects}

    def attached(self) -> dict[str, Any]:
        """Return the objects on the robot by id."""
        wanted = PlanningSceneComponents.ROBOT_STATE_ATTACHED_OBJECTS
        request = GetPlanningScene.Request(
            components=PlanningSceneComponents(components=wanted))
        scene = self._client.call('/get_planning_scene', GetPlanningScene, request).scene
        return {one.object.id: one for one in scene.robot_state.attached_collision_objects}

    def wait(self, holds: Callable[[dict[str, Any]], bool], timeout: float = 30.0) -> float:
        """Ask until it holds; return how long that took [s]."""
        begin = time.monotonic()
        while not holds(self.objects()):
            assert time.monotonic() < begin + timeout, self.objects().keys()
        return time.monotonic() - begin

    def edit(self, name: str, operation: bytes, place: Any = (3.0, 3.0, 1.0)) -> None:
        """Add or remove an object as a user does."""
        message = CollisionObject(id=name, operation=operation)
        message.header.frame_id = 'world'
        message.pose = pose(place)
        if operation == CollisionObject.ADD:
            message.primitives.append(SolidPrimitive(type=1, dimensions=[0.1, 0.1, 0.1]))
        scene = PlanningScene(is_diff=True)
        scene.robot_state.is_diff = True
        scene.world.collision_objects.append(message)
        request = ApplyPlanningScene.Request(scene=scene)
        assert self._client.call('/apply_planning_scene', ApplyPlanningScene, request).success
