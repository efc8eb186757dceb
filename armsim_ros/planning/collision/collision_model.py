# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a robot state touches itself or the world."""

from __future__ import annotations

from collections.abc import Sequence
import math

import numpy as np

from armsim_ros.arrays import Mask, Matrix, Vector
from armsim_ros.kinematics.displacement_bounds import DisplacementBounds
from armsim_ros.planning.budget import nothing, Poll
from armsim_ros.planning.collision.bodies import BodyKey, points_beside_links
from armsim_ros.planning.collision.broad_phase import CollisionTest
from armsim_ros.planning.collision.contacts import BodyType, Contact, PairDistance
from armsim_ros.planning.collision.near_pairs import Exactly, NearPairs
from armsim_ros.planning.collision.scene_tables import SceneTables
from armsim_ros.planning.collision.tables import CollisionTables
from armsim_ros.planning.scene.content import SceneContent
from armsim_ros.planning.scene.planning_scene import PlanningScene

#: Which of two touching bodies is named first.
_ORDER = {BodyType.ROBOT_LINK: 0, BodyType.ROBOT_ATTACHED: 1, BodyType.WORLD_OBJECT: 2}


class CollisionChecker:
    """
    Checks robot states in a scene; follows the scene's edits at the next query.

    A move sets one pose, and another group changes which pairs are checked; for other edits
    the tables that they concern are made anew. The robot's own shapes and all meshes are
    prepared once. One thread at a time may use a checker.

    :param scene: the scene to follow; :meth:`use` changes it.
    """

    def __init__(self, scene: PlanningScene) -> None:
        self._scene = scene
        self._kinematics = scene.kinematic_model
        content = scene.content
        self._tables = SceneTables(self._kinematics, content)
        self._motion = self._bounds(content)
        #: The last test and its arguments, until others are requested.
        self._test: CollisionTest = _always
        self._judged: tuple[str | None, float, bool] | None = None

    @property
    def scene(self) -> PlanningScene:
        """The scene that is followed."""
        return self._scene

    def use(self, scene: PlanningScene) -> None:
        """Follow another scene of the same robot; only what differs is taken over."""
        if scene.kinematic_model is not self._kinematics:
            raise ValueError('a collision checker serves scenes of one kinematic model')
        self._scene = scene

    def follows(self, scene: PlanningScene) -> bool:
        """Return whether a scene collides as the last one did."""
        return self._tables.holds(scene.content)

    # ---------------------------------------------------------------- questions

    def in_collision(
        self, q: Vector, group: str | None = None, clearance: float = 0.0, exact: bool = True
    ) -> bool:
        """
        Return whether a state touches anything that it may not touch.

        :param q: (n,) robot state.
        :param group: look only at links that this group moves, and at what they carry.
        :param clearance: [m] nearer than this counts as touching.
        :param exact: check the shapes; else meshes of the robot count as their hulls, and
            only False is sure.
        :raises PlanningError: INVALID_GROUP_NAME for an unknown group.
        """
        return self.test(group, clearance, exact)(q)

    def test(
        self, group: str | None = None, clearance: float = 0.0, exact: bool = True
    ) -> CollisionTest:
        """
        Return the quickest form of a question about many states, to be asked at once.

        It holds until another question or an edit; until then each call returns the same object.
        Parameters are those of :meth:`in_collision`.
        """
        asked = group, clearance, exact
        if asked != self._judged or self._scene.content is not self._tables.content:
            self._test = self._made_test(group, clearance, exact)
            self._judged = asked
        return self._test

    def _made_test(self, group: str | None, clearance: float, exact: bool) -> CollisionTest:
        tests = []
        for tables in self._followed():
            if tables.rigid_pairs(group):
                return _always
            tests.append(tables.test(group, clearance, exact))
        if len(tests) == 1:
            return tests[0]
        return lambda q: any(test(q) for test in tests)

    def near_pairs(
        self, states: Matrix, reach: Matrix | None, group: str | None = None,
        exact: Exactly = Exactly.ALWAYS, clearance: float = 0.0, poll: Poll = nothing,
        before: NearPairs | None = None,
    ) -> NearPairs:
        """
        Return what may be within reach of what.

        A motion without such pairs is proved: from its state no joint can move by its reach and
        anything touch.

        :param states: (k, n) robot states.
        :param reach: (k, n) motion of every joint to either side [rad or m]; None for none.
        :param exact: when to check the shapes themselves where their hulls are near.
        :param clearance: [m] that shall be left.
        :param poll: called now and then; raises what ends the request.
        :param before: what this method has returned for wider motions that hold these.
        """
        followed = self._followed()
        if any(tables.rigid_pairs(group) for tables in followed):
            return NearPairs(np.zeros((len(states), 0, 0)), (), always=True)
        weights = np.zeros((len(states), 0, 0))
        possible: Sequence[Mask | tuple[Matrix, Matrix]]
        if before is not None:
            weights, possible = before.weights, before.pairs
        else:
            frames = self._motion.frames(states)
            possible = [frames] * len(followed)
            if reach is not None:
                weights = self._motion.weights_near(frames, reach)
        moved = None if reach is None else self._motion.relative_displacement(reach, weights)
        return NearPairs(weights, [
            tables.near(states, moved, group, exact, clearance, poll, each)
            for tables, each in zip(followed, possible, strict=True)])

    def contacts(
        self, q: Vector, group: str | None = None, max_contacts: int | None = None
    ) -> list[Contact]:
        """
        Return the deepest contact of every two bodies that touch, the deepest first.

        Parameters are those of :meth:`in_collision`.

        :param max_contacts: the most to return; None for all.
        """
        deepest: dict[tuple[BodyKey, BodyKey], Contact] = {}
        for tables in self._followed():
            for pair in tables.touching(group, q):
                contact = _contact(tables, pair)
                key = (contact.type1, contact.body1), (contact.type2, contact.body2)
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
        smallest = math.inf
        for tables in self._followed():
            for first, second, distance in tables.ready(True, group).near(q, math.inf):
                smallest = min(smallest, tables.apart(first, second, distance))
        return smallest

    def pair_distances(
        self, q: Vector, within: float, group: str | None = None, exact: bool = True
    ) -> list[PairDistance]:
        """
        Return the distance of every two near shapes whose bodies may not touch.

        Parameters are those of :meth:`in_collision`.

        :param within: [m] farther apart than this is not near.
        """
        found = []
        widest = max(self._scene.link_padding.values(), default=0.0)
        for tables in self._followed():
            stage = tables.ready(exact, group)
            for first, second, distance in stage.near(q, within + widest):
                first, second = _in_order(tables, first, second)
                shape, other = tables.shapes[first], tables.shapes[second]
                found.append(PairDistance(
                    (shape.body.name, other.body.name), (shape.body.type, other.body.type),
                    (shape.joint, other.joint), tables.apart(first, second, distance)))
        return found

    @property
    def edits(self) -> int:
        """How many edits of the scene that matter to collisions it has followed up to now."""
        self._followed()
        return self._tables.edits

    @property
    def has_hulls(self) -> bool:
        """Whether there are hulls that are not the shapes themselves."""
        return any(tables.hull is not None for tables in self._followed())

    @property
    def relative_motion(self) -> Matrix:
        """How far joints move what others carry, see ``DisplacementBounds.relative``."""
        return self._motion.relative

    def displacement_bound(self, q1: Vector, q2: Vector, group: str | None = None) -> float:
        """
        Return a distance [m] that no point of robot or load exceeds between two states.

        It holds for every state of the straight segment in joint space.

        :param group: look only at links that this group moves.
        """
        self._followed()
        return self._motion.displacement_bound(q1, q2, group)

    def _followed(self) -> list[CollisionTables]:
        """Return the tables, with what the scene has changed since the last query."""
        self._judged = None
        content, before = self._scene.content, self._tables.content
        if content is not before:
            self._test = _always  # it would keep the tables that were
            self._tables.follow(content)
            if (content.attached is not before.attached
                    or content.link_scale is not before.link_scale):
                self._motion = self._bounds(content)
        return self._tables.tables

    def _bounds(self, content: SceneContent) -> DisplacementBounds:
        return DisplacementBounds(
            self._kinematics, points_beside_links(self._kinematics, content))


def _always(q: Vector) -> bool:
    """Return True: shapes touch that no joint moves apart."""
    return True


def _in_order(tables: CollisionTables, *numbers: int) -> list[int]:
    """Return the numbers of two shapes in the order in which their bodies are named."""
    bodies = {number: tables.shapes[number].body for number in numbers}
    return sorted(numbers, key=lambda number: (_ORDER[bodies[number].type], bodies[number].name))


def _contact(tables: CollisionTables, pair: int) -> Contact:
    """Return the deepest contact of a pair of a table, as its last query found it."""
    numbers = tables.exact.numbers(pair)
    first, second = _in_order(tables, *numbers)
    a, b = tables.shapes[first].body, tables.shapes[second].body
    found = tables.exact.deepest(pair)
    if found is None:  # the two just graze each other, and this time did not
        return Contact(
            a.name, b.name, a.type, b.type, tables.exact.pose(first)[:3, 3], np.zeros(3), 0.0)
    position, normal, distance = found
    return Contact(
        a.name, b.name, a.type, b.type, position, normal if first == numbers[0] else -normal,
        max(0.0, tables.margin(first, second) - distance))
