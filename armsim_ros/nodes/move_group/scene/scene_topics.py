# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topics of the scene: those that edit it, and ``monitored_planning_scene``."""

from __future__ import annotations

from collections.abc import Callable

from builtin_interfaces.msg import Time
from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, PlanningSceneWorld
from moveit_msgs.msg import CollisionObject as CollisionObjectMessage
from moveit_msgs.msg import PlanningScene as PlanningSceneMessage
from rclpy.clock import Clock, ClockType
from rclpy.qos import QoSProfile
from rclpy.task import Future
from std_msgs.msg import String

from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.collision_object import (
    attached_from_message,
    attached_object_to_message,
    object_from_message,
    object_to_message,
    removal_message,
)
from armsim_ros.nodes.conversions.motion_plan_request import robot_state_to_message
from armsim_ros.nodes.conversions.octomap import CLEARED, octomap_to_message
from armsim_ros.nodes.conversions.planning_scene import (
    acm_to_message,
    colors,
    paddings,
    scales,
    scene_to_message,
    transforms,
    update_from_message,
    world_from_message,
)
from armsim_ros.nodes.conversions.time import time_from_ns
from armsim_ros.nodes.move_group.context import Context, reported
from armsim_ros.nodes.move_group.worker import Job
from armsim_ros.planning.scene.allowed_collision_matrix import AllowedCollisionMatrix
from armsim_ros.planning.scene.content import FRAMES, SceneContent
from armsim_ros.planning.scene.objects import AttachedObject
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import SceneUpdate
from armsim_ros.scene_sources.simulated_world import of_world

WORLD = 'planning_scene_world'


class RejectedSceneChanges:
    """
    Publishes why a change of the scene was refused, which neither topics nor services return.

    :param context: the parts of move_group; its ``scene_log`` becomes this.
    """

    def __init__(self, context: Context) -> None:
        self._logger = context.logger
        self._publisher = context.node.create_publisher(
            String, 'rejected_scene_changes', qos.EVENTS)
        context.scene_log = self

    def error(self, text: str) -> None:
        """Log a reason and publish it."""
        self._logger.error(text)
        self._publisher.publish(String(data=text))


class PlanningSceneTopic:
    """Changes the scene by message."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self.subscription = context.subscribe(
            PlanningSceneMessage, 'planning_scene', self._receive)

    def _receive(self, message: PlanningSceneMessage) -> None:
        apply_scene_message(self._context, message, 'planning_scene')


class PlanningSceneWorldTopic:
    """Changes the objects of the world by message."""

    def __init__(self, context: Context) -> None:
        self._context = context
        context.subscribe(PlanningSceneWorld, WORLD, self._receive)

    def _receive(self, message: PlanningSceneWorld) -> None:
        _apply(self._context, lambda: world_from_message(message), WORLD)


def apply_scene_message(context: Context, message: PlanningSceneMessage, source: str) -> Job:
    """
    Apply a scene message part by part; the log names the parts that are refused.

    :param source: the endpoint that the message came by.
    :returns: whether all of it was taken, when that is known.
    """
    frame = context.frame
    return _apply(context, lambda: update_from_message(message, frame), source)


def _apply(context: Context, read: Callable[[], SceneUpdate], source: str) -> Job:
    def edit() -> bool:
        done = False
        with reported(context.scene_log, source, None):
            update, allowed = read(), context.scene.acm
            if of_world(update):
                context.ownership.apply(update)
            else:
                context.ownership.apply_client(update)
            _warn_of_forgotten_pairs(context, allowed, source)
            done = True
        return done

    context.states.update_scene()
    return context.edits.submit(edit)


def _warn_of_forgotten_pairs(
    context: Context, before: AllowedCollisionMatrix, source: str
) -> None:
    """Warn where a message's matrix leaves out links: it replaces the whole, as upstream."""
    pairs = before.forgotten_by(context.scene.acm, context.robot.links)
    if pairs:
        first, second = pairs[0]
        context.logger.warning(
            f'{source}: the allowed collision matrix replaces the whole matrix and lacks links: '
            f"{len(pairs)} of their pairs may no longer touch, such as '{first}' with '{second}'; "
            'change the matrix that get_planning_scene returns, and send all of it')


class CollisionObjectTopic:
    """Adds, removes, extends and moves objects of the world."""

    def __init__(self, context: Context) -> None:
        self._context = context
        context.subscribe(CollisionObject, 'collision_object', self._receive)

    def _receive(self, message: CollisionObject) -> None:
        def edit() -> None:
            with reported(self._context.scene_log, 'collision_object', None):
                self._context.scene.apply_object(object_from_message(message))

        self._context.edits.submit(edit)


class AttachedCollisionObjectTopic:
    """Attaches objects to links and detaches them."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self.subscription = context.subscribe(
            AttachedCollisionObject, 'attached_collision_object', self._receive)

    def _receive(self, message: AttachedCollisionObject) -> None:
        def edit() -> None:
            with reported(self._context.scene_log, 'attached_collision_object', None):
                self._context.scene.apply_attached(attached_from_message(message))

        self._context.states.update_scene()
        self._context.edits.submit(edit)


class AttachHint:
    """
    Checks every object that is attached without touch_links.

    Nothing is exempted silently: the object counts as touching until the client allows it.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._remove = context.scene.add_listener(self._changed)

    def _changed(self, before: SceneContent, after: SceneContent) -> None:
        if before.attached is after.attached:
            return
        for name, item in after.attached.items():
            if item is not before.attached.get(name) and not item.touch_links:
                self._look(item)

    def _look(self, item: AttachedObject) -> None:
        context, scene = self._context, self._context.scene.snapshot()

        def look() -> None:
            contacts = context.query_planner.check_state(scene, scene.q).contacts
            if any({item.id, item.link_name} == {contact.body1, contact.body2}
                   for contact in contacts):
                context.logger.warning(
                    f"attached object '{item.id}' touches the link '{item.link_name}' that it is "
                    f"attached to: every plan will begin in collision; add '{item.link_name}' to "
                    'touch_links')

        context.queries.submit(look)


TOPIC = 'monitored_planning_scene'
DEPTH = 100
#: Between two octomaps [s].
OCTOMAP_PERIOD = 0.2
GEOMETRY = ('objects', 'attached', 'acm', 'link_padding', 'link_scale', 'colors')


class MonitoredPlanningScene:
    """
    Publishes the scene in full at first, then changes.

    After a full scene, a replaced world, and changes of the allowed collision matrix, padding,
    scale or name by message, it is published in full again. An edit of objects and rules goes
    out at once, so that a program that moves the arm by it, such as servo_node, has it; motion
    goes out some times a second, and so do octomaps. No message is made while there is no
    subscription.
    """

    def __init__(self, context: Context) -> None:
        """Create the publisher; its timer runs on while sim time is paused."""
        self._context = context
        self._parameters = context.planning_parameters
        self._publisher = context.node.create_publisher(
            PlanningSceneMessage, TOPIC, QoSProfile(depth=DEPTH))
        self._published: PlanningScene | None = None
        self._pending: Future | None = None
        self._asked = False
        self._octomap_at = -OCTOMAP_PERIOD
        if self._parameters.publish_planning_scene:
            self._timer = context.node.create_timer(
                1.0 / self._parameters.publish_planning_scene_hz, self._look,
                clock=Clock(clock_type=ClockType.STEADY_TIME))
            context.scene.add_listener(self._edited)

    def _edited(self, before: SceneContent, now: SceneContent) -> None:
        """Wake the executor; called in the thread of the edit."""
        if self._asked:
            return
        if any(getattr(before, part) is not getattr(now, part) for part in GEOMETRY):
            self._asked = True
            self._look_soon()

    def _look_soon(self, _: object = None) -> None:
        executor = self._context.node.executor
        if self._asked and executor is not None:
            executor.create_task(self._look)

    def _look(self) -> None:
        if self._pending is not None and not self._pending.done():
            return
        self._asked = False
        heard = self._publisher.get_subscription_count()
        if self._published is None and not heard:
            return
        before, now = self._published, self._context.scene.snapshot()
        if before is not None and before.octomap is not now.octomap:
            if self._context.clock() - self._octomap_at < OCTOMAP_PERIOD:
                now.set_octomap(before.octomap)  # it goes out with a later message
            else:
                self._octomap_at = self._context.clock()
        self._published = now
        if heard and (before is None or before.content is not now.content):
            stamp = time_from_ns(max(self._context.states.stamp_ns, 0))
            self._pending = self._context.edits.submit(lambda: self._publish(before, now, stamp))
            # An edit meanwhile could not be seen.
            self._pending.add_done_callback(self._look_soon)

    def _publish(self, before: PlanningScene | None, now: PlanningScene, stamp: Time) -> None:
        if before is None or before.content.whole_version != now.content.whole_version:
            message: PlanningSceneMessage | None = scene_to_message(now)
        else:
            message = self._difference(before, now)
        if message is not None:
            message.robot_state.joint_state.header.stamp = stamp
            self._publisher.publish(message)

    def _difference(
        self, before: PlanningScene, now: PlanningScene
    ) -> PlanningSceneMessage | None:
        message = PlanningSceneMessage(is_diff=True)
        message.name, message.robot_model_name = now.content.name, now.robot.name
        message.robot_state.is_diff = True
        changed = False
        requested = self._parameters
        if requested.publish_state_updates and (before.q != now.q).any():
            changed = True
            message.robot_state = robot_state_to_message(
                now.kinematic_model.positions(now.q), now.model_frame, is_diff=True)
        if requested.publish_geometry_updates and any(
            getattr(before.content, part) is not getattr(now.content, part) for part in GEOMETRY
        ):
            changed = True
            fill_geometry(message, before, now)
        if requested.publish_geometry_updates and before.octomap is not now.octomap:
            changed = True
            message.world.octomap = octomap_to_message(now.octomap, now.model_frame)
            if now.octomap is None:
                message.world.octomap.octomap.id = CLEARED
        frames_changed = any(
            getattr(before.content, part) is not getattr(now.content, part) for part in FRAMES)
        if requested.publish_transforms_updates and frames_changed:
            changed = True
            message.fixed_frame_transforms = transforms(now)
        return message if changed else None


def fill_geometry(
    message: PlanningSceneMessage, before: PlanningScene, now: PlanningScene
) -> None:
    """Update a follower's earlier scene with the present objects and rules."""
    frame = now.model_frame
    message.world.collision_objects = [
        removal_message(name, frame)
        for name in (*before.objects, *before.attached)
        if name not in now.objects and name not in now.attached]
    message.world.collision_objects += [
        object_to_message(item, frame)
        for name, item in now.objects.items()
        if before.objects.get(name) is not item]
    attached = [
        attached_object_to_message(item)
        for name, item in now.attached.items()
        if before.attached.get(name) is not item]
    for name, item in before.attached.items():
        if name not in now.attached:
            gone = attached_object_to_message(item)
            gone.object.operation = CollisionObjectMessage.REMOVE
            attached.append(gone)
    message.robot_state.attached_collision_objects = attached
    if before.content.acm is not now.content.acm:
        message.allowed_collision_matrix = acm_to_message(now.acm.to_update())
    message.link_padding = paddings(now.link_padding)
    message.link_scale = scales(now.link_scale)
    if before.content.colors is not now.content.colors:
        message.object_colors = colors(now.colors)
