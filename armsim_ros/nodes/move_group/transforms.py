# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Frames of ``/tf`` and ``/tf_static`` that the robot's model does not have."""

from __future__ import annotations

from geometry_msgs.msg import TransformStamped
from rclpy.qos import QoSProfile
from tf2_msgs.msg import TFMessage

from armsim_ros.errors import PlanningError
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.geometry import Matrix, pose_from_transform
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.planning.scene_update import SceneUpdate

LONGEST_CHAIN = 100


class Transforms:
    """
    Makes frames that others publish known to the planning scene.

    Frames of the robot's own links come from its model and are left alone; a frame counts when
    a chain of transforms leads from one of them to it.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        """Subscribe."""
        self._context = context
        self._parents: dict[str, tuple[str, Matrix]] = {}
        self._placed: dict[str, Matrix] = {}
        static = QoSProfile(
            depth=100, reliability=qos.LATCHED.reliability, durability=qos.LATCHED.durability
        )
        context.subscribe(TFMessage, '/tf', self._receive, qos.TF)
        context.subscribe(TFMessage, '/tf_static', self._receive, static)

    def _receive(self, message: TFMessage) -> None:
        foreign = [item for item in message.transforms if not self._own(item)]
        if not foreign:
            return
        for item in foreign:
            try:
                pose = pose_from_transform(item.transform)
            except PlanningError as error:
                self._context.warn_once(f"tf: frame '{item.child_frame_id}': {error}")
                continue
            self._parents[strip(item.child_frame_id)] = (strip(item.header.frame_id), pose)
        self._place()

    def _own(self, item: TransformStamped) -> bool:
        robot, child = self._context.robot, strip(item.child_frame_id)
        return child in robot.links or child == robot.model_frame

    def _place(self) -> None:
        placed = {}
        for frame in self._parents:
            pose = self._pose(frame)
            if pose is not None:
                placed[frame] = pose
        changed = {
            frame: pose
            for frame, pose in placed.items()
            if frame not in self._placed or abs(pose - self._placed[frame]).max() > 1e-9
        }
        self._placed = placed
        if changed:
            self._context.scene.apply(SceneUpdate(fixed_frames=changed))

    def _pose(self, frame: str) -> Matrix | None:
        """Return a frame's pose in the model frame, None where no chain leads there."""
        robot, scene = self._context.robot, self._context.scene
        pose: Matrix | None = None
        for _ in range(LONGEST_CHAIN):
            if frame in robot.links or frame == robot.model_frame:
                return pose if pose is None else scene.frame_pose(frame) @ pose
            if frame not in self._parents:
                return None
            frame, step = self._parents[frame]
            pose = step if pose is None else step @ pose
        return None


def strip(frame: str) -> str:
    """Return a frame's name without the leading slash of ROS 1."""
    return frame.removeprefix('/')
