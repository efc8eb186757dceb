# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A hint about objects that collide with the link they were attached to."""

from __future__ import annotations

from armsim_ros.nodes.move_group.context import Context
from armsim_ros.planning.scene.content import SceneContent
from armsim_ros.planning.scene.objects import AttachedObject


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
