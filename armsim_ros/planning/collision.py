# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a robot state touches itself or the world."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
import math

import numpy as np
from numpy.typing import NDArray

from armsim_ros.planning.collision_bodies import BodyKey
from armsim_ros.planning.collision_tables import CollisionTables
from armsim_ros.planning.contacts import BodyType, Contact
from armsim_ros.planning.link_motion import LinkMotion
from armsim_ros.planning.poll import nothing, Poll
from armsim_ros.planning.scene import PlanningScene
from armsim_ros.planning.scene_content import SceneContent
from armsim_ros.planning.scene_follower import follow, same_for_collisions

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Which of two touching bodies is named first.
_ORDER = {BodyType.ROBOT_LINK: 0, BodyType.ROBOT_ATTACHED: 1, BodyType.WORLD_OBJECT: 2}


class Exactly(Enum):
    """
    When shapes themselves are looked at, which takes many times as long as their hulls.

    Hulls that are near tell as much as the shapes, unless they touch where the shapes do not.
    """

    NEVER = 'never'
    WHERE_HULLS_TOUCH = 'where hulls touch'
    ALWAYS = 'always'


class CollisionChecker:
    """
    Checks robot states in a scene; follows the scene's edits at the next query.

    An edit costs what it changes: a move sets one pose, an edit of the rules or a change of
    the group sets which pairs are looked at, an object that goes is no longer looked at, and
    only an object that is new makes the tables of pairs anew. The robot's own shapes and all
    meshes are prepared once. One thread at a time may use a checker.

    :param scene: the scene to follow; :meth:`use` changes it.
    """

    def __init__(self, scene: PlanningScene) -> None:
        """Take over the robot's shapes and the scene's objects."""
        self._scene = scene
        self._kinematics = scene.kinematic_model
        content = scene.content
        self._tables = CollisionTables(self._kinematics, content)
        self._motion = LinkMotion(self._kinematics, content.attached)
        follow(self._kinematics, self._tables, content, None)
        self._content: SceneContent = content

    @property
    def scene(self) -> PlanningScene:
        """The scene that is followed."""
        return self._scene

    def use(self, scene: PlanningScene) -> None:
        """Follow another scene of the same robot; only what differs is taken over."""
        if scene.kinematic_model is not self._kinematics:
            raise ValueError('a collision checker serves scenes of one kinematic model')
        self._scene = scene

    # ---------------------------------------------------------------- questions

    def in_collision(
        self, q: Vector, group: str | None = None, clearance: float = 0.0
    ) -> bool:
        """
        Return whether a state touches anything that it may not touch; exact.

        :param q: (n,) robot state.
        :param group: look only at links that this group moves, and at what they carry.
        :param clearance: [m] nearer than this counts as touching.
        :raises PlanningError: INVALID_GROUP_NAME for an unknown group.
        """
        tables = self._followed()
        if tables.rigid_hit(group):
            return True
        if tables.hull is not None and not tables.ready(False, group, clearance).hit(q):
            return False
        return tables.ready(True, group, clearance).hit(q)

    def maybe_in_collision(
        self, q: Vector, group: str | None = None, clearance: float = 0.0
    ) -> bool:
        """
        Return False only where a state is surely free; meshes of the robot count as hulls.

        Parameters are those of :meth:`in_collision`.
        """
        tables = self._followed()
        if tables.rigid_hit(group):
            return True
        return tables.ready(False, group, clearance).hit(q)

    def judge(
        self, group: str | None = None, clearance: float = 0.0, exact: bool = True
    ) -> Callable[[Vector], bool]:
        """
        Return the quickest form of a question about many states, to be asked at once.

        It holds until another question or an edit. Parameters are those of :meth:`in_collision`.

        :param exact: :meth:`in_collision`; else :meth:`maybe_in_collision`.
        """
        tables = self._followed()
        if tables.rigid_hit(group):
            return _always
        maybe = tables.ready(False, group, clearance).judge()
        if not exact or tables.hull is None:
            return maybe
        surely = tables.ready(True, group, clearance).judge()
        return lambda q: maybe(q) and surely(q)

    def crowded(
        self, states: Matrix, reach: Matrix, group: str | None = None,
        exact: Exactly = Exactly.ALWAYS, clearance: float = 0.0, poll: Poll = nothing,
    ) -> Mask:
        """
        Return in which states anything may be within reach of something.

        False is proof: from that state no joint can move by its reach and touch anything.

        :param states: (k, n) robot states.
        :param reach: (k, n) motion of every joint to either side [rad or m].
        :param exact: when to judge by the shapes themselves where their hulls are near.
        :param clearance: [m] that shall be left.
        :param poll: called now and then; raises what ends the request.
        """
        tables = self._followed()
        if tables.rigid_hit(group):
            return np.ones(len(states), dtype=bool)

        def near(which: Mask | slice, surely: bool) -> Mask:
            return tables.near(
                states[which], reach[which], self._motion.relative, group, surely, clearance,
                poll)

        found = near(slice(None), surely=False)
        if exact is Exactly.NEVER or tables.hull is None:
            return found
        asked = found.copy()
        if exact is Exactly.WHERE_HULLS_TOUCH:
            asked[found] = tables.touched(states[found], group, clearance, poll)
        found[asked] = near(asked, surely=True)
        return found

    def contacts(
        self, q: Vector, group: str | None = None, max_contacts: int | None = None
    ) -> list[Contact]:
        """
        Return the deepest contact of every two bodies that touch, the deepest first.

        Parameters are those of :meth:`in_collision`.

        :param max_contacts: the most to return; None for all.
        """
        tables = self._followed()
        tables.ready(True, group)
        deepest: dict[tuple[BodyKey, BodyKey], Contact] = {}
        for first, second in tables.exact.touching(q):
            contact = self._contact(first, second)
            key = (tables.shapes[first].body.key, tables.shapes[second].body.key)
            if key not in deepest or contact.depth > deepest[key].depth:
                deepest[key] = contact
        found = sorted(deepest.values(), key=lambda contact: -contact.depth)
        return found if max_contacts is None else found[:max_contacts]

    def distance(self, q: Vector, group: str | None = None) -> float:
        """
        Return the smallest distance [m] of two bodies that may not touch.

        It is negative where they overlap and infinite where no pair is checked; padding is
        taken off. Parameters are those of :meth:`in_collision`.
        """
        tables = self._followed()
        tables.ready(True, group)
        return min(
            (
                distance - tables.margin(first, second)
                for first, second, distance in tables.exact.distances(q)
            ),
            default=math.inf,
        )

    def displacement_bound(self, q1: Vector, q2: Vector, group: str | None = None) -> float:
        """
        Return a distance [m] that no point of robot or load exceeds between two states.

        It holds for every state of the straight segment in joint space.

        :param group: look only at links that this group moves.
        """
        self._followed()
        return self._motion.displacement_bound(q1, q2, group)

    def _followed(self) -> CollisionTables:
        """Return the tables, with what the scene has changed since the last query."""
        content, before = self._scene.content, self._content
        if content is not before:
            if not same_for_collisions(content, before):
                follow(self._kinematics, self._tables, content, before)
                if content.attached is not before.attached:
                    self._motion = LinkMotion(self._kinematics, content.attached)
            self._content = content
        return self._tables

    def _contact(self, first: int, second: int) -> Contact:
        tables = self._tables
        one, other = tables.shapes[first].body, tables.shapes[second].body
        if (_ORDER[other.type], other.name) < (_ORDER[one.type], one.name):
            first, second, one, other = second, first, other, one
        pose_1, pose_2 = tables.exact.pose(first), tables.exact.pose(second)
        result = tables.collide(first, second, pose_1, pose_2)
        best = min(
            result.getContacts(), key=lambda contact: contact.penetration_depth, default=None
        )
        if best is None:  # the two just graze each other, and this time did not
            position, normal, depth = pose_1[:3, 3], np.zeros(3), 0.0
        else:
            position = np.array(best.pos, dtype=np.float64).reshape(3)
            normal = np.array(best.normal, dtype=np.float64).reshape(3)
            depth = tables.margin(first, second) - float(best.penetration_depth)
        return Contact(one.name, other.name, one.type, other.type, position, normal, depth)


def _always(_q: Vector) -> bool:
    return True


__all__ = ['BodyType', 'CollisionChecker', 'Contact', 'Exactly']
