# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services of the scene: contents, edits, files, frames of objects, the octomap."""

from __future__ import annotations

from collections.abc import Callable
import os
from pathlib import Path
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from moveit_msgs.srv import ApplyPlanningScene as ApplyPlanningSceneSrv
from moveit_msgs.srv import GetPlanningScene as GetPlanningSceneSrv
from moveit_msgs.srv import LoadGeometryFromFile, LoadMap, SaveGeometryToFile, SaveMap
import numpy as np
from rclpy.clock import Clock, ClockType
from sensor_msgs.msg import JointState
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage

from armsim_ros.arrays import Matrix
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.transforms import quat_xyzw_from_matrix
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.planning_scene import Component, scene_to_message
from armsim_ros.nodes.move_group.context import Context, reported
from armsim_ros.nodes.move_group.scene.scene_topics import apply_scene_message
from armsim_ros.planning.scene.octomap import Octomap, octomap_error, read_map_file, write_map_file
from armsim_ros.scene_sources.scene_file import read_scene_file, write_scene_file


class ApplyPlanningScene:
    """Changes the scene; when the answer comes, every later request sees the change."""

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(ApplyPlanningSceneSrv, 'apply_planning_scene', self._fill)

    async def _fill(
        self, request: ApplyPlanningSceneSrv.Request, response: ApplyPlanningSceneSrv.Response
    ) -> None:
        response.success = await apply_scene_message(
            self._context, request.scene, 'apply_planning_scene')


class GetPlanningScene:
    """Answers with the requested parts of the scene, all of them for 0."""

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(GetPlanningSceneSrv, 'get_planning_scene', self._fill)

    async def _fill(
        self, request: GetPlanningSceneSrv.Request, response: GetPlanningSceneSrv.Response
    ) -> None:
        requested = Component(request.components.components) or Component.ALL
        scene = await self._context.present_scene()
        response.scene = await self._context.edits.submit(
            lambda: scene_to_message(scene, requested))
        self._add_velocities(response.scene.robot_state.joint_state)

    def _add_velocities(self, state: JointState) -> None:
        """Add measured velocities to the positions if ``monitor_dynamics`` is set."""
        states = self._context.states
        if states.monitor_dynamics:
            state.velocity = [states.velocities.get(name, 0.0) for name in state.name]


class GeometryFiles:
    """
    Writes the objects of the world to a file, or reads them from a file.

    Files are written only below the folder of the parameter ``geometry_folder``; a path
    that is not absolute begins there.

    :param save: which of the two services to offer.
    """

    def __init__(self, context: Context, *, save: bool) -> None:
        self._context = context
        self._folder = geometry_folder(context.planning_parameters.geometry_folder)
        if save:
            context.serve(SaveGeometryToFile, 'save_geometry_to_file', self._save)
        else:
            context.serve(LoadGeometryFromFile, 'load_geometry_from_file', self._load)

    async def _save(self, request: Any, response: Any) -> None:
        scene = await self._context.present_scene()

        def save() -> None:
            path = below_folder(self._folder, request.file_path_and_name)
            write_scene_file(str(path), scene)

        response.success = await done(self._context, 'save_geometry_to_file', save)

    async def _load(self, request: Any, response: Any) -> None:
        def load() -> None:
            path = self._folder / request.file_path_and_name
            self._context.scene.load(read_scene_file(str(path)))

        response.success = await done(self._context, 'load_geometry_from_file', load)


def geometry_folder(given: str) -> Path:
    """Return the folder of scene files; by default the user's own."""
    if given:
        return Path(given).expanduser().absolute()
    return Path(os.environ.get('ROS_HOME') or '~/.ros').expanduser().absolute() / 'scenes'


def below_folder(folder: Path, name: str) -> Path:
    """
    Return the path of a file below the folder of scene files, which is made.

    :raises PlanningError: FAILURE for a path elsewhere.
    """
    root = folder.resolve()
    path = (root / name).resolve()
    if not path.is_relative_to(root):
        raise PlanningError(
            MoveItErrorCode.FAILURE,
            f"'{path}' is not below '{folder}'; give a path in that folder, or start "
            "move_group with another geometry_folder ('/' for anywhere)")
    root.mkdir(parents=True, exist_ok=True)
    return path


async def done(context: Context, source: str, work: Callable[[], None]) -> bool:
    """Do the work in the scene's worker, and log why it was refused; return whether it is done."""
    def attempt() -> bool:
        finished = False
        with reported(context.logger, source, None):
            try:
                work()
            except (OSError, ValueError) as error:
                raise PlanningError(MoveItErrorCode.FAILURE, str(error)) from None
            finished = True
        return finished

    return bool(await context.edits.submit(attempt))


class SceneFrames:
    """
    Publishes the frames of objects and their subframes, attached ones included.

    The frame of an object is ``<prefix>/<object>``; that of a subframe,
    ``<prefix>/<object>/<subframe>``, is its child. The prefix is a parameter, by default the
    node's name; '' is none. Each message holds a single transform.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        node, parameters = context.node, context.planning_parameters
        prefix = parameters.planning_scene_tf_prefix
        if prefix is None:
            prefix = node.get_name()
        self._prefix = f'{prefix}/' if prefix else ''
        self._publisher = node.create_publisher(TFMessage, '/tf', qos.TF)
        self._timer = node.create_timer(
            1.0 / parameters.planning_scene_frame_publishing_rate, self._publish,
            clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _publish(self) -> None:
        scene = self._context.scene.snapshot()
        stamp = self._context.node.get_clock().now().to_msg()
        placed = [(self._context.frame, item) for item in scene.objects.values()]
        placed += [(item.link_name, item.object) for item in scene.attached.values()]
        for parent, item in placed:
            frame = f'{self._prefix}{item.id}'
            self._send(parent, frame, item.pose, stamp)
            for name, pose in item.subframes.items():
                self._send(frame, f'{frame}/{name}', pose, stamp)

    def _send(self, parent: str, child: str, pose: Matrix, stamp: Time) -> None:
        made = TransformStamped(child_frame_id=child)
        made.header.stamp, made.header.frame_id = stamp, parent
        place, turn = made.transform.translation, made.transform.rotation
        place.x, place.y, place.z = map(float, pose[:3, 3])
        turn.x, turn.y, turn.z, turn.w = map(float, quat_xyzw_from_matrix(pose))
        self._publisher.publish(TFMessage(transforms=[made]))


class ClearOctomap:
    """
    Empties the map of the scene before it answers.

    :param forget: empties what the sensors have seen up to now.
    """

    def __init__(self, context: Context, forget: Callable[[], None]) -> None:
        self._context, self._forget = context, forget
        context.serve(Empty, 'clear_octomap', self._clear)

    async def _clear(self, *_: object) -> None:
        def clear() -> None:
            self._forget()
            self._context.scene.set_octomap(None)

        await self._context.edits.submit(clear)


class MapFiles:
    """
    Writes the octomap to a ``.bt`` file, and reads it from a file, in the model frame.

    Files are written only below the folder of the parameter ``geometry_folder``; a path
    that is not absolute begins there.

    :param replace: puts a map in the place of the present one.
    """

    def __init__(self, context: Context, replace: Callable[[Octomap], None]) -> None:
        self._context, self._replace = context, replace
        self._folder = geometry_folder(context.planning_parameters.geometry_folder)
        context.serve(SaveMap, 'save_map', self._save)
        context.serve(LoadMap, 'load_map', self._load)

    async def _save(self, request: SaveMap.Request, response: SaveMap.Response) -> None:
        def save() -> None:
            octomap = self._context.scene.octomap
            if octomap is None:
                raise octomap_error('there is none to save')
            below_folder(self._folder, request.filename).write_bytes(write_map_file(octomap))

        response.success = await done(self._context, 'save_map', save)

    async def _load(self, request: LoadMap.Request, response: LoadMap.Response) -> None:
        def load() -> None:
            content = (self._folder / request.filename).read_bytes()
            self._replace(read_map_file(content, np.eye(4)))

        response.success = await done(self._context, 'load_map', load)
