# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The octomap of the planning scene: its cells, and the button that empties it."""

from __future__ import annotations

import asyncio
from typing import Any

from moveit_msgs.msg import PlanningScene, PlanningSceneComponents
from moveit_msgs.srv import GetPlanningScene
from rclpy.qos import QoSProfile
from std_srvs.srv import Empty

from armsim_ros.errors import ArmsimError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes.conversions.octomap import octomap_from_message
from armsim_ros.nodes.web.page import Page, PanelCommand, Part
from armsim_ros.nodes.web.parts.robot import RobotPart
from armsim_ros.nodes.web.parts.watch import WatchPart
from armsim_ros.nodes.web.scene.octomap_drawing import OctomapDrawing
from armsim_ros.nodes.web.session import Session

#: Between two drawings, each of which sends all cells to the browser [s].
_PERIOD = 0.5
_NEWS = QoSProfile(depth=5)


class ClearOctomap(PanelCommand):
    """Empty the map."""


class OctomapPart(Part):
    """
    Shows the cells while a panel is open.

    :param watch: pauses while none is.
    :param robot_part: knows the frames.
    """

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
        request = GetPlanningScene.Request()
        request.components.components = PlanningSceneComponents.OCTOMAP
        scene = (await self.page.call(GetPlanningScene, '/get_planning_scene', request)).scene
        message = scene.world.octomap
        update = await asyncio.to_thread(octomap_from_message, message, is_diff=False)
        octomap = update.octomap if update is not None else None
        cells = self._drawing.show(octomap, self._robot_part.node_of(message.header.frame_id))
        self.page.publish('octomap', {'cells': cells, 'resolution': octomap.resolution}
                          if octomap is not None else None)

    async def _clear(self, _session: Session, _command: ClearOctomap) -> None:
        await self.page.call(Empty, '/clear_octomap', Empty.Request())
        self._changed.set()
