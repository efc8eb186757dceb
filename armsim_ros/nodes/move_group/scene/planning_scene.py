# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topics ``planning_scene`` and ``planning_scene_world``."""

from __future__ import annotations

from collections.abc import Callable

from moveit_msgs.msg import PlanningScene, PlanningSceneWorld

from armsim_ros.nodes.conversions.planning_scene import update_from_message, world_from_message
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.failures import reported
from armsim_ros.nodes.move_group.worker import Job
from armsim_ros.planning.scene.update import SceneUpdate
from armsim_ros.scene_sources.simulated_world import of_world

WORLD = 'planning_scene_world'


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
        _apply(self._context, lambda: world_from_message(message), message, WORLD)


def apply_scene_message(context: Context, message: PlanningScene, source: str) -> Job:
    """
    Apply a scene message part by part; the log names the parts that are refused.

    :param source: the endpoint that the message came by.
    :returns: whether all of it was taken, when that is known.
    """
    frame = context.frame
    return _apply(context, lambda: update_from_message(message, frame), message.world, source)


def _apply(
    context: Context, read: Callable[[], SceneUpdate], world: PlanningSceneWorld, source: str
) -> Job:
    if world.octomap.octomap.data:
        context.warn_once(f'{source}: octomaps are not supported; the rest of the scene is used')

    def edit() -> bool:
        done = False
        with reported(context.logger, source, None):
            update = read()
            if of_world(update):
                context.ownership.apply(update)
            else:
                context.scene.apply(update)
            done = True
        return done

    context.states.update_scene()
    return context.edits.submit(edit)
