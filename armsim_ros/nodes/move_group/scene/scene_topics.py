# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topics that edit the scene: ``planning_scene``, ``collision_object`` and their like."""

from __future__ import annotations

from collections.abc import Callable

from moveit_msgs.msg import (
    AttachedCollisionObject,
    CollisionObject,
    PlanningScene,
    PlanningSceneWorld,
)
from std_msgs.msg import String

from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.collision_object import (
    attached_from_message,
    object_from_message,
)
from armsim_ros.nodes.conversions.planning_scene import update_from_message, world_from_message
from armsim_ros.nodes.move_group.answers import reported
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.worker import Job
from armsim_ros.planning.scene.content import SceneContent
from armsim_ros.planning.scene.objects import AttachedObject
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


class PlanningSceneTopics:
    """
    Changes the scene by message.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.subscribe(PlanningScene, 'planning_scene', self._receive)
        context.subscribe(PlanningSceneWorld, WORLD, self._receive_world)

    def _receive(self, message: PlanningScene) -> None:
        apply_scene_message(self._context, message, 'planning_scene')

    def _receive_world(self, message: PlanningSceneWorld) -> None:
        _apply(self._context, lambda: world_from_message(message), WORLD)


def apply_scene_message(context: Context, message: PlanningScene, source: str) -> Job:
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
            update = read()
            if of_world(update):
                context.ownership.apply(update)
            else:
                context.scene.apply(update)
            done = True
        return done

    context.states.update_scene()
    return context.edits.submit(edit)


class CollisionObjectTopic:
    """
    Adds, removes, extends and moves objects of the world.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.subscribe(CollisionObject, 'collision_object', self._receive)

    def _receive(self, message: CollisionObject) -> None:
        def edit() -> None:
            with reported(self._context.scene_log, 'collision_object', None):
                self._context.scene.apply_object(object_from_message(message))

        self._context.edits.submit(edit)


class AttachedCollisionObjectTopic:
    """
    Attaches objects to links and detaches them.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.subscribe(AttachedCollisionObject, 'attached_collision_object', self._receive)

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

    :param context: the parts of move_group.
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
                    'touch_links'
                )

        context.queries.submit(look)
