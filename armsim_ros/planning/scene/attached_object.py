# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects that a link carries."""

from __future__ import annotations

from dataclasses import dataclass, field

from armsim_ros.planning.scene.world_object import CollisionObject
from armsim_ros.trajectory import JointTrajectory


@dataclass(frozen=True, slots=True, eq=False)
class AttachedObject:
    """
    An object that moves with a link; it never changes, an edit makes a new one.

    :param object: its pose is relative to the link.
    :param link_name: the link that carries it.
    :param touch_links: links and attached objects that it may touch, as the client gave them;
        the carrying link itself is only exempt when it is named here.
    :param detach_posture: kept for the client, not used.
    :param weight: [kg] kept for the client, not used.
    """

    object: CollisionObject
    link_name: str
    touch_links: tuple[str, ...] = ()
    detach_posture: JointTrajectory = field(default_factory=lambda: JointTrajectory(()))
    weight: float = 0.0

    @property
    def id(self) -> str:
        """The object's id."""
        return self.object.id
