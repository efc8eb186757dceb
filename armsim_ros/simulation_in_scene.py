# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulated world and what its cameras see, in a planning scene of the same process."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
import logging
from typing import Any

from armsim_ros.arrays import Matrix
from armsim_ros.config.sensors_3d import OctomapSettings, PointCloudSensor, with_cameras
from armsim_ros.errors import nearest, SimulationError
from armsim_ros.model.grippers import Gripper
from armsim_ros.model.tree import standing_links
from armsim_ros.model.world_objects import WORLD_TYPE
from armsim_ros.planning.occupancy.scene_map import SceneMap, Sight
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    ObjectOperation,
    ObjectType,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import SceneUpdate, StartState
from armsim_ros.scene_sources.simulated_world import collision_object, WorldOwnership
from armsim_ros.sim.camera import Camera, cameras_of, take_snapshot
from armsim_ros.sim.physics.compiler import model_to_bytes
from armsim_ros.sim.scene_renderer import PlantCopy, ray_picture
from armsim_ros.sim.simulation import Simulation
from armsim_ros.sim.world.world_mirror import Holder, WorldMirror, WorldNews, WorldWatch


class WorldInScene:
    """
    Lets a scene follow a simulated world; the user's own objects are left alone.

    :param simulation: has the world.
    :param scene: follows.
    :param root: (4, 4) pose of the world in the scene's root link.
    :param fingers: returns what fingers hold.
    """

    def __init__(
        self, simulation: Simulation, scene: PlanningScene, root: Matrix,
        fingers: Callable[[], Mapping[str, Gripper]]
    ) -> None:
        self._root = root
        self._watch = WorldWatch(simulation.world, simulation.vacuum_grippers.values(), fingers)
        self._mirror = WorldMirror()
        self._ownership = WorldOwnership(
            scene, standing_links(simulation.model), logging.getLogger('armsim_ros.stack').info,
            lambda: simulation.time_ns * 1e-9)

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


#: Every n-th row and column is measured: at 640 pixels a centimetre apart at 1.5 m.
EVERY = 4


class CameraInScene:
    """
    Adds what cameras see to the octomap of a scene.

    :param simulation: has the world.
    :param scene: gets the map.
    :param settings: of the map; without sensors those of ``octomap:=true``.
    :param root: (4, 4) pose of the world in the scene's root link.
    """

    def __init__(
        self, simulation: Simulation, scene: PlanningScene, settings: OctomapSettings,
        root: Matrix,
    ) -> None:
        self._simulation, self._scene, self._root = simulation, scene, root
        cameras = simulation.settings.cameras
        self._cameras = {camera.name: camera for camera in cameras_of(cameras, simulation.model)}
        self._sensors = with_cameras(OctomapSettings(), cameras).sensors
        resolution = (settings if settings.sensors else with_cameras(
            settings, cameras or {'none': None})).octomap_resolution
        self._map = SceneMap(scene, resolution, max(
            (sensor.padding_offset for sensor in self._sensors.values()), default=0.0))
        self._plant: tuple[Any, PlantCopy] | None = None

    def look(self, name: str) -> None:
        """
        Add what a camera sees now.

        :raises SimulationError: there is no such camera.
        """
        camera, sensor = self._camera(name), self._sensors[name]
        assert isinstance(sensor, PointCloudSensor)
        model, data = self._simulation.mujoco_model, self._simulation.mujoco_data
        if self._plant is None or self._plant[0] is not model:
            self._plant = model, PlantCopy(model_to_bytes(model))
        plant = self._plant[1]
        plant.show(take_snapshot(0, self._simulation.time_ns, model, data))
        picture = ray_picture(camera, plant.model, plant.data, EVERY)
        scene = self._scene
        root = scene.frame_pose(scene.robot.root_link) @ self._root
        self._map.add(Sight(
            picture.points, sensor.max_range, picture.beyond, root @ picture.pose, scene.content,
            scene.q, sensor.padding_scale, sensor.padding_offset))

    def _camera(self, name: str) -> Camera:
        if name not in self._cameras:
            hint = nearest(name, tuple(self._cameras))
            known = ', '.join(self._cameras) or 'simulation.yaml has none'
            raise SimulationError(f"no camera '{name}'; {hint or f'cameras: {known}'}")
        return self._cameras[name]
