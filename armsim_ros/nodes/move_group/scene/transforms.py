# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of ``/tf`` and ``/tf_static`` that are not part of the robot's model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription
from tf2_msgs.msg import TFMessage

from armsim_ros.errors import PlanningError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.transforms import inverse_pose
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.geometry import pose_from_transform
from armsim_ros.nodes.conversions.serialized import child_frame_ids
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.planning.scene.content import FixedFrame
from armsim_ros.planning.scene.objects import check_pose
from armsim_ros.planning.scene.planning_scene import PlanningScene

#: Transforms that differ by less are the same.
SAME = 1e-9
#: Messages on /tf that are queued until the program reads them.
DEPTH = 500


class FrameHost(Protocol):
    """A program that needs the frames."""

    node: PollingNode
    robot: RobotModel
    scene: PlanningScene

    def subscribe(
        self, kind: Any, name: str, receive: Callable[[Any], None], profile: QoSProfile | int
    ) -> object:
        """Subscribe to a topic."""

    def warn_once(self, text: str) -> None:
        """Log a warning once."""


class Transforms:
    """
    Adds frames that others publish to the planning scene, each with its parent.

    Frames of the robot's own links come from its model and are left alone. Where a frame is,
    is found out when a message or a request names it, as of then: what is mounted on a
    link moves with it. Frames above the root link are turned about, so that what hangs on them
    is known too.

    :param moving: follow ``/tf`` from the beginning, not only when ``follow_moving`` asks for it.
    """

    def __init__(self, context: FrameHost, *, moving: bool = True) -> None:
        self._context = context
        self._moving: Subscription | None = None
        self._roots = {context.robot.root_link, context.robot.model_frame}
        self._received: dict[str, FixedFrame] = {}
        static = QoSProfile(
            depth=100, reliability=qos.LATCHED.reliability, durability=qos.LATCHED.durability)
        context.subscribe(TFMessage, '/tf_static', self._receive, static)
        if moving:
            self.follow_moving()

    def follow_moving(self) -> None:
        """Follow ``/tf``, too."""
        if self._moving is None:
            profile = QoSProfile(
                depth=DEPTH, reliability=qos.COMMAND.reliability,
                durability=qos.COMMAND.durability)
            self._moving = self._context.node.poll(
                TFMessage, '/tf', self._receive_moving, profile, raw=True)

    def _receive_moving(self, serialized: bytes) -> None:
        """Take a message of /tf; most hold only the robot's links and are not unpacked."""
        names = child_frame_ids(serialized)
        links = self._context.robot.links
        if names is None or not all(
            name in links and name not in self._roots for name in map(strip, names)
        ):
            self._receive(deserialize_message(serialized, TFMessage))

    def _receive(self, message: TFMessage) -> None:
        changed = False
        for item in message.transforms:
            child, parent = strip(item.child_frame_id), strip(item.header.frame_id)
            if self._own(child) and (child not in self._roots or self._own(parent)):
                continue
            if not child or not parent:
                self._context.warn_once(f"tf: frame '{child}' in '{parent}': a name is missing")
                continue
            try:
                pose = check_pose(pose_from_transform(item.transform), 'its pose')
                frame = FixedFrame(parent, pose)
            except PlanningError as error:
                self._context.warn_once(f"tf: frame '{child}': {error}")
                continue
            if _differ(frame, self._received.get(child)):
                self._received[child] = frame
                changed = True
        if changed:
            known = self._context.scene.content.frames
            self._context.scene.set_frames({
                name: frame
                for name, frame in self._frames().items()
                if _differ(frame, known.get(name))})

    def _frames(self) -> dict[str, FixedFrame]:
        """Return all frames that were received, as a tree rooted at the robot."""
        frames = {name: frame for name, frame in self._received.items() if not self._own(name)}
        for root in self._roots:
            below, passed = root, {root}
            while below in self._received and self._received[below].parent not in passed:
                above = self._received[below].parent
                frames[above] = FixedFrame(below, inverse_pose(self._received[below].pose))
                below = above
                passed.add(above)
        return frames

    def _own(self, name: str) -> bool:
        return name in self._context.robot.links or name in self._roots


def _differ(frame: FixedFrame, other: FixedFrame | None) -> bool:
    if other is None or frame.parent != other.parent:
        return True
    return bool(abs(frame.pose - other.pose).max() > SAME)


def strip(frame: str) -> str:
    """Return a frame's name without the leading slash of ROS 1."""
    return frame.removeprefix('/')
