# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``attached_collision_object``."""

from __future__ import annotations

from moveit_msgs.msg import AttachedCollisionObject as Message

from armsim_ros.nodes.conversions.collision_object import attached_from_message
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.failures import reported


class AttachedCollisionObject:
    """
    Attaches objects to links and detaches them.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.subscribe(Message, 'attached_collision_object', self._receive)

    def _receive(self, message: Message) -> None:
        def edit() -> None:
            with reported(self._context.logger, 'attached_collision_object', None):
                self._context.scene.apply_attached(attached_from_message(message))

        self._context.states.update_scene()
        self._context.edits.submit(edit)
