# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A robot in the scene, a frame per link, and the handle at its tool."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Set
from itertools import product
from typing import Any

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.transforms import (
    matrix_from_quat_wxyz,
    pose_from_parts,
    quat_wxyz_from_matrix,
)
from armsim_ros.model.tree import joint_pose
from armsim_ros.nodes.web.shapes import Color, PLAIN, ShapeReader

#: A change below this is not sent: a quaternion's part, or [m].
_SMALLEST = 1e-5


class RobotDrawing:
    """
    Draws a robot below a node of the scene.

    :param scene: the scene of all sessions, or of a single session.
    :param path: the node's name, such as ``/robot``.
    :param color: of all links, in place of their own.
    :param opacity: below 1 the robot is translucent.
    """

    def __init__(self, scene: Any, path: str, robot: RobotModel, reader: ShapeReader,
                 color: Color | None = None, opacity: float | None = None) -> None:
        self.robot = robot
        self.complaints: list[str] = []
        self._scene, self._reader = scene, reader
        self._color, self._opacity = color, opacity
        self._root = scene.add_frame(path, show_axes=False)
        self._axes = False
        self.paths = {robot.root_link: f'{path}/{robot.root_link}'}
        self._frames: dict[str, Any] = {}
        self._meshes: dict[str, list[tuple[Any, Color]]] = {}
        self.corners: dict[str, Matrix] = {}
        """Link -> corners (c, 4) of the boxes around its shapes, in its frame, with ones."""
        self._shown: dict[str, tuple[Matrix, Matrix]] = {}
        for name in robot.links:
            self._add_link(name)

    @property
    def visible(self) -> bool:
        """Whether it is to be seen."""
        return bool(self._root.visible)

    @visible.setter
    def visible(self, visible: bool) -> None:
        if self._root.visible != visible:
            self._root.visible = visible

    def place(self, xyz: Matrix, wxyz: Matrix) -> None:
        """Put the root link somewhere; (3,) [m] and (4,)."""
        self.set_link(self.robot.root_link, xyz, wxyz)

    def set_link(self, link: str, xyz: Matrix, wxyz: Matrix) -> None:
        """Put a link somewhere in its parent's frame; unknown links are left out."""
        frame = self._frames.get(link)
        if frame is None:
            return
        before = self._shown.get(link)
        moved = turned = True
        if before is not None:
            moved = bool(np.abs(before[0] - xyz).max() > _SMALLEST)
            turned = bool(np.abs(before[1] - wxyz).max() > _SMALLEST)
        if moved:
            frame.position = xyz
        if turned:
            frame.wxyz = wxyz
        if moved or turned:
            self._shown[link] = (xyz, wxyz)

    def set_joints(self, positions: Mapping[str, float]) -> None:
        """Move joints; mimic joints follow [rad or m]."""
        for name in self.robot.movable_joints:
            value = _value(self.robot, name, positions)
            if value is not None:
                joint = self.robot.joints[name]
                pose = joint_pose(joint, value)
                self.set_link(joint.child, pose[:3, 3], quat_wxyz_from_matrix(pose))

    def paint(self, color: Color | None, touching: Mapping[str, Color]) -> None:
        """
        Colour the robot.

        :param color: of every link; None gives each its own.
        :param touching: link -> a colour that wins.
        """
        for link, meshes in self._meshes.items():
            for handle, own in meshes:
                target = touching.get(link, color or own)
                if tuple(handle.color) != tuple(target):
                    handle.color = target

    def show_links(self, links: Set[str]) -> None:
        """Show the shapes of these links alone."""
        for link, meshes in self._meshes.items():
            for handle, _ in meshes:
                if handle.visible is not (link in links):
                    handle.visible = link in links

    def show_axes(self, shown: bool) -> None:
        """Show the axes of each link's frame, or hide them."""
        if shown != self._axes:
            self._axes = shown
            for frame in self._frames.values():
                frame.show_axes = shown

    def remove(self) -> None:
        """Take it out of the scene."""
        self._root.remove()

    def _add_link(self, name: str) -> None:
        robot = self.robot
        pose = np.eye(4)
        if name != robot.root_link:
            joint = robot.joints[robot.parent_joint[name]]
            self.paths[name] = f'{self.paths[joint.parent]}/{name}'
            pose = joint_pose(joint, 0.0)
        path = self.paths[name]
        self._frames[name] = self._scene.add_frame(
            path, show_axes=False, axes_length=0.08, axes_radius=0.002,
            position=pose[:3, 3], wxyz=quat_wxyz_from_matrix(pose))
        shapes, complaints = self._reader.shapes_of(robot.links[name])
        self.complaints += complaints
        for number, (shape, parts) in enumerate(shapes):
            for index, part in enumerate(parts):
                self._note_corners(name, shape.origin, part.vertices)
                own = part.color or PLAIN
                opacity = self._opacity
                if opacity is None and part.opacity < 1.0:
                    opacity = part.opacity
                handle = self._scene.add_mesh_simple(
                    f'{path}/shape_{number}_{index}', part.vertices, part.faces,
                    color=self._color or own, flat_shading=not part.smooth, opacity=opacity,
                    side='double', position=shape.origin[:3, 3],
                    wxyz=quat_wxyz_from_matrix(shape.origin),
                    cast_shadow=self._opacity is None)
                self._meshes.setdefault(name, []).append((handle, own))

    def _note_corners(self, link: str, origin: Matrix, vertices: Any) -> None:
        ends = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
        box = np.array(list(product(*ends.T, (1.0,)))) @ origin.T
        known = self.corners.get(link)
        self.corners[link] = box if known is None else np.concatenate([known, box])


def _value(robot: RobotModel, name: str, positions: Mapping[str, float]) -> float | None:
    """Return a joint's position, that of a joint that mimics another from the other's."""
    mimic = robot.joints[name].mimic
    if mimic is None:
        return positions.get(name)
    leader = _value(robot, mimic.joint, positions)
    return None if leader is None else mimic.multiplier * leader + mimic.offset


#: Of its arrows [m].
_SIZE = 0.16


class ToolHandle:
    """
    Draws a handle in a session's scene.

    :param pulled: gets the handle's pose in the robot's root link, (4, 4), when it is pulled.
    """

    def __init__(self, scene: Any, pulled: Callable[[Matrix], Awaitable[None]]) -> None:
        self._base = scene.add_frame('/goal', show_axes=False)
        handle = self._handle = scene.add_transform_controls(
            '/goal/handle', scale=_SIZE, line_width=3.0, depth_test=False, disable_sliders=True)

        async def moved(_event: Any) -> None:
            await pulled(pose_from_parts(
                np.asarray(handle.position), matrix_from_quat_wxyz(handle.wxyz)))

        handle.on_update(moved)

    def place(self, xyz: Matrix, wxyz: Matrix) -> None:
        """Put the robot's root link somewhere; (3,) [m] and (4,)."""
        self._base.position, self._base.wxyz = xyz, wxyz

    def put(self, pose: Matrix) -> None:
        """Put the handle somewhere in the robot's root link; (4, 4)."""
        self._handle.position = pose[:3, 3]
        self._handle.wxyz = quat_wxyz_from_matrix(pose)

    def remove(self) -> None:
        """Take it out of the scene."""
        self._base.remove()
