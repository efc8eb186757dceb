# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``monitored_planning_scene``."""

from __future__ import annotations

from moveit_msgs.msg import CollisionObject as CollisionObjectMessage
from moveit_msgs.msg import PlanningScene as PlanningSceneMessage
from rclpy.clock import Clock, ClockType
from rclpy.qos import QoSProfile

from armsim_ros.nodes.conversions.collision_object import (
    attached_object_to_message,
    object_to_message,
    removal_message,
)
from armsim_ros.nodes.conversions.planning_scene import (
    acm_to_message,
    colors,
    paddings,
    scales,
    scene_to_message,
    transforms,
)
from armsim_ros.nodes.conversions.robot_state import robot_state_to_message
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.planning.scene import PlanningScene

TOPIC = 'monitored_planning_scene'
DEPTH = 100
GEOMETRY = ('objects', 'attached', 'acm', 'link_padding', 'link_scale', 'colors')


class MonitoredPlanningScene:
    """
    Publishes the scene: once in full, then what has changed.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        """Make the publisher; its timer goes on while sim time stands still."""
        self._context = context
        self._parameters = context.planning_parameters
        self._publisher = context.node.create_publisher(
            PlanningSceneMessage, TOPIC, QoSProfile(depth=DEPTH)
        )
        self._published: PlanningScene | None = None
        if self._parameters.publish_planning_scene:
            self._timer = context.node.create_timer(
                1.0 / self._parameters.publish_planning_scene_hz,
                self._publish,
                clock=Clock(clock_type=ClockType.STEADY_TIME),
            )

    def _publish(self) -> None:
        before, now = self._published, self._context.scene.snapshot()
        self._published = now
        if before is None:
            self._publisher.publish(scene_to_message(now))
            return
        if before.content is now.content:
            return
        message = self._difference(before, now)
        if message is not None:
            self._publisher.publish(message)

    def _difference(
        self, before: PlanningScene, now: PlanningScene
    ) -> PlanningSceneMessage | None:
        message = PlanningSceneMessage(is_diff=True)
        message.name, message.robot_model_name = now.content.name, now.robot.name
        message.robot_state.is_diff = True
        changed = False
        wanted = self._parameters
        if wanted.publish_state_updates and (before.q != now.q).any():
            changed = True
            message.robot_state = robot_state_to_message(
                now.kinematic_model.positions(now.q), now.model_frame, is_diff=True
            )
        if wanted.publish_geometry_updates and any(
            getattr(before.content, part) is not getattr(now.content, part) for part in GEOMETRY
        ):
            changed = True
            _fill_geometry(message, before, now)
        frames_changed = before.content.frames is not now.content.frames
        if wanted.publish_transforms_updates and frames_changed:
            changed = True
            message.fixed_frame_transforms = transforms(now.model_frame, now.fixed_frames)
        return message if changed else None


def _fill_geometry(
    message: PlanningSceneMessage, before: PlanningScene, now: PlanningScene
) -> None:
    frame = now.model_frame
    message.world.collision_objects = [
        removal_message(name, frame) for name in before.objects if name not in now.objects
    ]
    message.world.collision_objects += [
        object_to_message(item, frame)
        for name, item in now.objects.items()
        if before.objects.get(name) is not item
    ]
    attached = [
        attached_object_to_message(item)
        for name, item in now.attached.items()
        if before.attached.get(name) is not item
    ]
    for name, item in before.attached.items():
        if name not in now.attached:
            gone = attached_object_to_message(item)
            gone.object.operation = CollisionObjectMessage.REMOVE
            attached.append(gone)
    message.robot_state.attached_collision_objects = attached
    if before.content.acm is not now.content.acm:
        message.allowed_collision_matrix = acm_to_message(now.full_update().acm)
    message.link_padding = paddings(now.link_padding)
    message.link_scale = scales(now.link_scale)
    if before.content.colors is not now.content.colors:
        message.object_colors = colors(now.colors)
