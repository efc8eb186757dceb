# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The robot in the scene, from its descriptions and transforms."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from contextlib import suppress
from functools import partial
import math
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from rcl_interfaces.srv import GetParameters
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from armsim_ros.arrays import Matrix
from armsim_ros.clients.description import bounds, describe, tip_of, with_limits
from armsim_ros.errors import ArmsimError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.transforms import pose_from_quat_xyzw
from armsim_ros.nodes import qos
from armsim_ros.nodes.web.page import Page, PanelCommand, Part, Session
from armsim_ros.nodes.web.robot_drawing import RobotDrawing
from armsim_ros.nodes.web.shapes import ShapeReader
from armsim_ros.packages import Packages

#: How often the robot is redrawn [Hz].
RATE = 30.0
#: How long an SRDF is waited for before the robot is shown without [s].
_SRDF_PATIENCE = 2.0
_LIMITS = 'robot_description_planning.joint_limits'
_TF = QoSProfile(depth=50, reliability=QoSReliabilityPolicy.BEST_EFFORT,
                 durability=QoSDurabilityPolicy.VOLATILE)
_TF_STATIC = QoSProfile(depth=100, reliability=QoSReliabilityPolicy.RELIABLE,
                        durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
#: What the camera sees around a robot, as a share of its diagonal.
_ROOM = 0.56
#: Light from above and from below, and how much of it.
_SKY, _GROUND, _BRIGHTNESS = (255, 255, 255), (196, 200, 208), 1.6
#: Colours of the floor's cells and sections.
_GRID = {'light': ((208, 213, 220), (184, 190, 199)), 'dark': ((44, 49, 57), (66, 73, 83))}


class Frames(PanelCommand):
    """Whether the axes of the links are to be seen."""

    shown: bool


class ResetView(PanelCommand):
    """The camera is to show the whole robot again."""


class Theme(PanelCommand):
    """Whether the session's system is dark."""

    dark: bool


class RobotPart(Part):
    """Draws the robot at the poses that tf publishes."""

    def __init__(self, page: Page, packages: Packages) -> None:
        super().__init__(page)
        self.reader = ShapeReader(packages)
        self.drawing: RobotDrawing | None = None
        self.edges: dict[str, tuple[str, Matrix, Matrix]] = {}
        """Child frame -> parent frame, position (3,), quaternion xyzw (4,)."""
        self._dark: WeakKeyDictionary[Session, bool] = WeakKeyDictionary()
        self._texts = {'urdf': '', 'srdf': ''}
        self._news, self._semantic_came = asyncio.Event(), asyncio.Event()
        page.scene.configure_default_lights(cast_shadow=False)
        # Light out of a photograph costs a machine without a graphics card half a minute.
        page.scene.configure_environment_map(hdri=None)
        page.scene.add_light_hemisphere(
            '/lights/sky', sky_color=_SKY, ground_color=_GROUND, intensity=_BRIGHTNESS,
            position=(0.0, 0.0, 1.0))
        self._tf = page.link.poll(TFMessage, '/tf', _TF)
        self._tf_static = page.link.poll(TFMessage, '/tf_static', _TF_STATIC)
        for topic, kind in (('/robot_description', 'urdf'),
                            ('/robot_description_semantic', 'srdf')):
            page.link.subscribe(String, topic, qos.DESCRIPTION, partial(self._heard, kind))
        page.link.prepare(GetParameters, '/move_group/get_parameters')

    def _heard(self, kind: str, message: String) -> None:
        self.page.soon(lambda: self._take(kind, message.data))

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {'frames': (Frames, self._show_frames), 'reset_view': (ResetView, self._reset),
                'theme': (Theme, self._take_theme)}

    def on_scene(self, session: Session) -> None:
        """Give a new scene its floor, and point its camera at the robot."""
        self._draw_floor(session)
        self.look_at_robot(session)

    def on_program(self, name: str, there: bool) -> None:
        """Ask a new move_group for the limits that it plans with."""
        if name == 'move_group' and there:
            self._news.set()

    async def run(self) -> None:
        """Move the robot as tf publishes while a panel is open."""
        self.page.start(self._keep_described())
        while True:
            if not self.page.watched:
                self.page.arrival.clear()
                if not self.page.watched:
                    await self.page.arrival.wait()
            self.follow()
            await asyncio.sleep(1.0 / RATE)

    def follow(self) -> None:
        """Take the transforms that have come and move what has moved."""
        news = {}
        for message in (*self._tf_static.take(), *self._tf.take()):
            for stamped in message.transforms:
                news[stamped.child_frame_id] = stamped
        if not news:
            return
        with self.page.server.viser.atomic():
            for child, stamped in news.items():
                xyz, xyzw = stamped.transform.translation, stamped.transform.rotation
                position = np.array((xyz.x, xyz.y, xyz.z))
                quaternion = np.array((xyzw.x, xyzw.y, xyzw.z, xyzw.w))
                self.edges[child] = (stamped.header.frame_id, position, quaternion)
                if self.drawing is not None:
                    self.drawing.set_link(child, position, quaternion[[3, 0, 1, 2]])

    def pose_of(self, frame: str) -> Matrix:
        """Return the pose of a frame in the root frame of tf, (4, 4)."""
        pose = np.eye(4)
        for _ in range(len(self.edges) + 1):
            if frame not in self.edges:
                break
            frame, xyz, xyzw = self.edges[frame]
            pose = pose_from_quat_xyzw(xyz, xyzw) @ pose
        return pose

    def node_of(self, frame: str) -> str:
        """Return the path of a frame in the scene; that of the scene for an unknown frame."""
        if self.drawing is not None and frame in self.drawing.paths:
            return self.drawing.paths[frame]
        return ''

    def place_before(self) -> Matrix:
        """Return a place before the robot that it can reach, (3,) [m]."""
        centre, radius = self._extent()
        place: Matrix = centre + np.array((0.45 * radius / _ROOM, 0.0, 0.0))
        return place

    def look_at_robot(self, session: Session) -> None:
        """Turn a session's camera so that the robot fills the view."""
        if self.drawing is None or session.scene is None:
            return
        centre, radius = self._extent()
        camera = session.scene.camera
        away = np.array((0.78, -0.95, 0.45))
        distance = radius / math.sin(0.5 * camera.fov) * (1.0 if camera.aspect > 1.0
                                                          else 1.0 / max(camera.aspect, 0.3))
        camera.position = centre + away / np.linalg.norm(away) * distance
        camera.look_at = centre

    def _draw_floor(self, session: Session) -> None:
        cells, sections = _GRID['dark' if self._dark.get(session, False) else 'light']
        if session.scene is not None:
            session.scene.scene.add_grid(
                '/floor', 4.0, 4.0, cell_size=0.1, section_size=0.5, cell_color=cells,
                section_color=sections, cell_thickness=0.6, section_thickness=1.0,
                infinite_grid=True, fade_distance=6.0, position=(0.0, 0.0, -0.001))

    async def _take_theme(self, session: Session, command: Theme) -> None:
        self._dark[session] = command.dark
        self._draw_floor(session)

    def _extent(self) -> tuple[Matrix, float]:
        """Return the middle of the robot and how far it reaches from there [m]."""
        places = np.array([
            (self.pose_of(link) @ corner)[:3]
            for link, corners in (self.drawing.corners.items() if self.drawing else ())
            for corner in corners])
        if not len(places):
            return np.zeros(3), 1.0
        low, high = places.min(axis=0), places.max(axis=0)
        return 0.5 * (low + high), max(_ROOM * float(np.linalg.norm(high - low)), 0.15)

    async def _show_frames(self, _session: Session, command: Frames) -> None:
        if self.drawing is not None:
            self.drawing.show_axes(command.shown)
        self.page.publish('frames', command.shown)

    async def _reset(self, session: Session, _command: ResetView) -> None:
        self.look_at_robot(session)

    def _take(self, kind: str, text: str) -> None:
        if text == self._texts[kind]:
            return
        self._texts[kind] = text
        if kind == 'srdf':
            self._semantic_came.set()
        self._news.set()

    async def _keep_described(self) -> None:
        """Describe the robot anew where something new is known; two at once would mix."""
        while True:
            await self._news.wait()
            if self._texts['urdf']:
                with suppress(asyncio.TimeoutError, TimeoutError):
                    await asyncio.wait_for(self._semantic_came.wait(), _SRDF_PATIENCE)
            self._news.clear()
            if self._texts['urdf']:
                await asyncio.wait([self.page.start(self._describe())])

    async def _describe(self) -> None:
        """Read both texts, ask for limits, draw."""
        try:
            robot = describe(self._texts['urdf'], self._texts['srdf'])
        except ArmsimError as error:
            self.page.publish('robot_error', str(error))
            return
        self.page.publish('robot_error', '')
        robot = with_limits(robot, await self._planner_limits(robot))
        same = self.drawing is not None and self.drawing.robot.urdf == robot.urdf
        if not same:
            if self.drawing is not None:
                self.drawing.remove()
            self.drawing = None
            drawing = await asyncio.to_thread(
                RobotDrawing, self.page.scene, '/robot', robot, self.reader)
            for child, (_, xyz, xyzw) in self.edges.items():
                drawing.set_link(child, xyz, xyzw[[3, 0, 1, 2]])
            self.drawing = drawing
        assert self.drawing is not None
        self.page.publish('robot', robot_form(robot, self.drawing.complaints))
        self.follow()
        self.page.take_robot(robot)
        if not same:
            for session in self.page.sessions.values():
                self.look_at_robot(session)

    async def _planner_limits(self, robot: RobotModel) -> dict[str, dict[str, float]]:
        """Return the limits that move_group plans with, as far as it publishes them."""
        names = [(joint, kind) for joint in robot.active_joints
                 for kind in ('velocity', 'acceleration')]
        request = GetParameters.Request(names=[
            f'{_LIMITS}.{joint}.{what}_{kind}{"_limits" if what == "has" else ""}'
            for joint, kind in names for what in ('has', 'max')])
        try:
            values = (await self.page.call(
                GetParameters, '/move_group/get_parameters', request, 2.0)).values
        except ArmsimError:
            return {}
        found: dict[str, dict[str, float]] = {}
        for index, (joint, kind) in enumerate(names[:len(values) // 2]):
            has, most = values[2 * index], values[2 * index + 1]
            number = most.double_value if most.type == 3 else float(most.integer_value)
            if has.bool_value and number > 0.0:
                found.setdefault(joint, {})[kind] = number
        return found


def robot_form(robot: RobotModel, complaints: Iterable[str] = ()) -> dict[str, Any]:
    """Return what the panel has to know of a robot."""
    groups = []
    for name, group in robot.semantic.groups.items():
        if group.active_joints:
            groups.append({
                'name': name,
                'tip': tip_of(group),
                'states': list(robot.semantic.named_states.get(name, {})),
                'joints': [_joint_form(robot, joint) for joint in group.active_joints],
            })
    chains = [group for group in groups if group['tip'] and len(group['joints']) > 2]
    return {'name': robot.name, 'groups': groups, 'complaints': list(complaints)[:5],
            'group': (chains or groups or [{'name': ''}])[0]['name']}


def _joint_form(robot: RobotModel, name: str) -> dict[str, Any]:
    joint = robot.joints[name]
    lower, upper = bounds(joint)
    return {
        'name': name, 'turns': joint.type.value != 'prismatic', 'lower': lower, 'upper': upper,
        'velocity': _number(joint.limits.velocity),
        'acceleration': _number(joint.limits.acceleration),
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
