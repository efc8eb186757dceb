# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""PlanningSceneMonitor: the scene that follows the robot and the topics."""

from __future__ import annotations

from contextlib import AbstractContextManager, ExitStack
import threading
from types import TracebackType
from typing import Any, cast

from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, ObjectColor
from moveit_msgs.msg import PlanningScene as PlanningSceneMessage
from moveit_msgs.srv import GetPlanningScene
from rclpy.time import Time

from armsim_ros.moveit_py.moveit_cpp import MoveItCpp
from armsim_ros.moveit_py.planning_scene import PlanningScene
from armsim_ros.moveit_py.robot_model import RobotModel
from armsim_ros.moveit_py.utils import logger
from armsim_ros.nodes.conversions.planning_scene import Component
from armsim_ros.nodes.move_group.scene.scene_topics import apply_scene_message
from armsim_ros.planning.scene.planning_scene import PlanningScene as Scene

#: How long a service is waited for [s].
_SERVICE_TIMEOUT = 5.0


class _LockedPlanningScene:
    """
    The scene for a block: edits of others wait, and the robot's state does not change in it.

    What the block changes takes effect, and is published, when it ends.
    """

    def __init__(self, monitor: PlanningSceneMonitor) -> None:
        self._monitor = monitor

    def __enter__(self) -> PlanningScene:
        """Return the scene."""
        return self._monitor._enter()

    def __exit__(
        self, type: type[BaseException] | None, value: BaseException | None,  # noqa: A002
        traceback: TracebackType | None,
    ) -> None:
        """Put what was changed in place."""
        self._monitor._leave()


class LockedPlanningSceneContextManagerRO(_LockedPlanningScene):
    """The scene for a block that reads it; what is changed all the same takes effect, too."""


class LockedPlanningSceneContextManagerRW(_LockedPlanningScene):
    """The scene for a block that changes it."""


class PlanningSceneMonitor:
    """
    Keeps the planning scene.

    :param cpp: the parts that plan and execute.
    :param robot_model: the robot.
    """

    def __init__(self, cpp: MoveItCpp, robot_model: RobotModel) -> None:
        self._cpp, self._model = cpp, robot_model
        self._name = str(cpp.parameters.get('planning_scene_monitor_options.name')
                         or 'planning_scene_monitor')
        #: The blocks of this thread: the scene of the outermost, and how many there are.
        self._blocks = threading.local()

    @property
    def name(self) -> str:
        """Name of the monitor."""
        return self._name

    def read_only(self) -> LockedPlanningSceneContextManagerRO:
        """Return a context manager that gives the scene."""
        return LockedPlanningSceneContextManagerRO(self)

    def read_write(self) -> LockedPlanningSceneContextManagerRW:
        """Return a context manager that gives the scene."""
        return LockedPlanningSceneContextManagerRW(self)

    def _enter(self) -> PlanningScene:
        blocks = self._blocks
        depth = getattr(blocks, 'depth', 0)
        if depth == 0:
            self._cpp.check()
            blocks.stack = ExitStack()
            edited: AbstractContextManager[Scene] = self._cpp.context.scene.edited()
            blocks.scene = PlanningScene._of(self._model, blocks.stack.enter_context(edited))
        blocks.depth = depth + 1
        return cast(PlanningScene, blocks.scene)

    def _leave(self) -> None:
        blocks = self._blocks
        blocks.depth -= 1
        if blocks.depth == 0:
            blocks.stack.close()
            blocks.scene = None

    @property
    def _open(self) -> PlanningScene | None:
        """The scene of the block that this thread is in."""
        return getattr(self._blocks, 'scene', None)

    # ---------------------------------------------------------------- edits

    def process_collision_object(
        self, collision_object_msg: CollisionObject, color_msg: ObjectColor | None = None
    ) -> bool:
        """Add, remove, extend or move an object of the world; return whether that was done."""
        with self.read_write() as scene:
            return scene._apply_object(collision_object_msg, color_msg)

    def process_attached_collision_object(
        self, attached_collision_object_msg: AttachedCollisionObject
    ) -> bool:
        """Attach, extend or detach an object; return whether that was done."""
        with self.read_write() as scene:
            return scene.process_attached_collision_object(attached_collision_object_msg)

    def new_planning_scene_message(self, scene: PlanningSceneMessage) -> bool:
        """Apply a scene message, a difference or a whole; return whether all of it was taken."""
        async def apply() -> bool:
            return bool(await apply_scene_message(
                self._cpp.context, scene, 'new_planning_scene_message'))

        return self._cpp.call(apply)

    def clear_octomap(self) -> None:
        """Remove the octomap from the scene, and what sensors have seen up to now."""
        self._cpp.octomap.forget()
        self._cpp.context.scene.set_octomap(None)

    # ---------------------------------------------------------------- topics

    def update_frame_transforms(self) -> None:
        """Take the newest transforms; that happens before each plan, too."""
        self._cpp.run(self._cpp.node.catch_up)

    def wait_for_current_robot_state(self, t: Time, wait_time: float) -> bool:
        """
        Wait for a robot state of a time or later.

        :param wait_time: longest time to wait [s].
        :returns: whether there is one.
        """
        states = self._cpp.context.states

        async def wait() -> bool:
            found = bool(await states.newer_than(t.nanoseconds, float(wait_time)))
            states.update_scene()
            return found

        return self._cpp.call(wait)

    def request_planning_scene_state(self, service_name: str) -> bool:
        """Take over the whole scene of a service; return whether it answered."""
        context = self._cpp.context

        async def request() -> bool:
            client = self._cpp.node.create_client(
                GetPlanningScene, service_name, callback_group=context.group)
            deadline = context.clock() + _SERVICE_TIMEOUT
            while not client.service_is_ready() and context.clock() < deadline:
                await context.ticker.next()
            question = GetPlanningScene.Request()
            question.components.components = int(Component.ALL)
            answer: Any = client.call_async(question)
            while not answer.done() and context.clock() < deadline:
                await context.ticker.next()
            self._cpp.node.destroy_client(client)
            if not answer.done():
                logger().error(f"request_planning_scene_state: no answer of '{service_name}' "
                               f'within {_SERVICE_TIMEOUT:g} s')
                return False
            return bool(await apply_scene_message(
                context, answer.result().scene, 'request_planning_scene_state'))

        return self._cpp.call(request)

    def start_scene_monitor(self) -> None:
        """Follow ``planning_scene``, as from the beginning."""
        self._cpp.run(lambda: self._cpp.follow_scene(True))

    def stop_scene_monitor(self) -> None:
        """Follow ``planning_scene`` no longer; the topics of objects stay followed."""
        self._cpp.run(lambda: self._cpp.follow_scene(False))

    def start_state_monitor(self) -> None:
        """Follow the joint states and ``attached_collision_object``, as from the beginning."""
        self._cpp.run(lambda: self._cpp.follow_state(True))

    def stop_state_monitor(self) -> None:
        """Follow the joint states and ``attached_collision_object`` no longer."""
        self._cpp.run(lambda: self._cpp.follow_state(False))
