# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The octomap of the planning scene: its cells, and the button that empties it."""

from __future__ import annotations

import asyncio
from typing import Any

from moveit_msgs.msg import PlanningScene, PlanningSceneComponents
import numpy as np
from numpy.typing import NDArray
from rclpy.qos import QoSProfile
from std_srvs.srv import Empty

from armsim_ros.arrays import Vector
from armsim_ros.errors import ArmsimError
from armsim_ros.model.geometry import Box
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.transforms import quat_wxyz_from_matrix
from armsim_ros.nodes.conversions.octomap import octomap_from_message
from armsim_ros.nodes.web.page import Page, PanelCommand, Part, Session
from armsim_ros.nodes.web.parts.robot import RobotPart
from armsim_ros.nodes.web.parts.watch import WatchPart
from armsim_ros.nodes.web.shapes import ShapeReader
from armsim_ros.planning.scene.octomap import Octomap

#: Colours from the lowest cell to the highest.
_COLORS = np.array([(68, 1, 84), (49, 104, 142), (53, 183, 121), (253, 231, 37)], dtype=float)


class OctomapDrawing:
    """Boxes, one per occupied leaf of the tree, drawn as instances of a single mesh."""

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self._node: Any = None
        self._box, = ShapeReader().parts(Box((1.0, 1.0, 1.0)))

    def show(self, octomap: Octomap | None, node: str) -> int:
        """Draw a map and no other; return the number of boxes."""
        if self._node is not None:
            self._node.remove()
            self._node = None
        if octomap is None:
            return 0
        centres, edges = octomap.boxes
        if len(edges):
            turns = np.zeros((len(edges), 4), dtype=np.float32)
            turns[:, 0] = 1.0
            heights: Vector = centres @ octomap.pose[2, :3]
            self._node = self._scene.add_batched_meshes_simple(
                f'{node}/octomap', self._box.vertices, self._box.faces, turns,
                centres.astype(np.float32), batched_scales=edges.astype(np.float32),
                batched_colors=height_colors(heights), flat_shading=True, cast_shadow=False,
                receive_shadow=False, lod='off', position=octomap.pose[:3, 3],
                wxyz=quat_wxyz_from_matrix(octomap.pose))
        return len(edges)


def height_colors(heights: Vector) -> NDArray[np.uint8]:
    """Return colours (k, 3) of heights (k,) [m] between the lowest and the highest."""
    low, high = heights.min(), heights.max()
    share = (heights - low) / max(high - low, 1e-9) * (len(_COLORS) - 1)
    places = np.arange(len(_COLORS))
    return np.stack(
        [np.interp(share, places, channel) for channel in _COLORS.T], axis=-1).astype(np.uint8)


#: Between two drawings, each of which sends all cells to the browser [s].
_PERIOD = 0.5
_NEWS = QoSProfile(depth=5)


class ClearOctomap(PanelCommand):
    """Empty the map."""


class OctomapPart(Part):
    """Shows the cells while a panel is open."""

    def __init__(self, page: Page, watch: WatchPart, robot_part: RobotPart) -> None:
        super().__init__(page)
        self._watch, self._robot_part = watch, robot_part
        self._drawing = OctomapDrawing(page.scene)
        self._changed = asyncio.Event()
        page.link.subscribe(PlanningScene, '/monitored_planning_scene', _NEWS, self._notice)

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {'clear_octomap': (ClearOctomap, self._clear)}

    def on_program(self, name: str, there: bool) -> None:
        """Read the map of a new move_group."""
        if name == 'move_group' and there:
            self._changed.set()

    def on_robot(self, robot: RobotModel) -> None:
        """Move the map into the frame of another robot."""
        self._changed.set()

    def _notice(self, message: Any) -> None:
        """Note, in the link's thread, that a message of the scene may have changed the map."""
        if not message.is_diff or message.world.octomap.octomap.id:
            self.page.soon(self._changed.set)

    async def run(self) -> None:
        """Read the map after every change of it."""
        while True:
            await self._changed.wait()
            self._changed.clear()
            try:
                await self._read()
            except ArmsimError:
                self.page.publish('octomap', None)
            await self._watch.rest(_PERIOD)

    async def _read(self) -> None:
        scene = await self.page.planning_scene(PlanningSceneComponents.OCTOMAP)
        message = scene.world.octomap
        update = await asyncio.to_thread(octomap_from_message, message, is_diff=False)
        octomap = update.octomap if update is not None else None
        cells = self._drawing.show(octomap, self._robot_part.node_of(message.header.frame_id))
        self.page.publish('octomap', {'cells': cells, 'resolution': octomap.resolution}
                          if octomap is not None else None)

    async def _clear(self, _session: Session, _command: ClearOctomap) -> None:
        await self.page.call(Empty, '/clear_octomap', Empty.Request())
        self._changed.set()
