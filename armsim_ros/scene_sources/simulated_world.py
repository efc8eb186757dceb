# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The simulated world in a planning scene: what a scene begins with, and whose an object is.

The world owns the ids that it added. An object that was there before is the user's, and so is
an object that the user adds, moves or attaches; what the user removes stays away. That ends when
the world deletes the object, or when it begins a new epoch: at its start, a reset, another world.

An edit that leaves an object as it is, such as a scene applied as it was requested, changes no
owner. Neither does a whole scene with an object as the world had it shortly before: a client such
as RViz publishes its own copy of all objects, and the copy may be late.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
import threading

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.ompl_planning import PlanningParameters
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.world import WorldSettings
from armsim_ros.errors import PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Mesh
from armsim_ros.model.tree import standing_links
from armsim_ros.model.world_objects import (
    FLOOR,
    floor_object,
    world_in_root,
    world_objects,
    WORLD_TYPE,
    WorldObject,
)
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.collision.contacts import BodyType
from armsim_ros.planning.scene.content import SceneContent
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    ObjectOperation,
    ObjectShape,
    ObjectType,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import joined, SceneUpdate

#: A held object that rests this deep at most in another is lifted out of it when attached [m].
RESTING_DEPTH = 1e-3
#: Numbers of a pose that differ by less are the same: a message has quaternions.
SAME = 1e-9
#: A whole scene may show the world as it was this long ago [s].
LATEST_COPY = 2.0
#: How far it is lifted beyond the contact [m], and how often at most.
LIFT, MOST_LIFTS = 2e-5, 3


def initial_scene(
    model: KinematicModel, settings: RobotSettings, parameters: PlanningParameters, name: str = ''
) -> PlanningScene:
    """
    Return the scene of a robot's files.

    It is empty but for the robot. Where ``scene_from_world`` is ``fixed``, the fixed objects and
    the floor of the world's file are in it; they may touch the links that no joint moves, on which
    the robot is.
    """
    root = world_in_root(settings)
    scene = PlanningScene(
        model, name=name, link_padding=parameters.default_robot_padding,
        link_scale=parameters.default_robot_scale, parent_frame=root)
    if parameters.scene_from_world == 'fixed':
        standing = standing_links(model.robot)
        for item in _fixed_objects(settings.world, root):
            scene.apply_object(item)
            scene.set_acm(scene.acm.with_entry(item.id, True, standing))
    return scene


def collision_object(item: WorldObject, root: Matrix) -> CollisionObject:
    """
    Return an object of the simulated world as an object to be added to a scene.

    :param root: (4, 4) pose of the world in the root link's frame.
    """
    shapes = tuple(ObjectShape(part.geometry, part.origin) for part in item.parts)
    return CollisionObject(item.name, pose=root @ item.pose, shapes=shapes)


def _fixed_objects(world: WorldSettings, root: Matrix) -> list[CollisionObject]:
    """Return what of a world never moves; its pose (4, 4) is in the root link's frame."""
    items = [collision_object(item, root) for item in world_objects(world) if item.mass is None]
    if world.floor_height is not None and FLOOR not in world.objects:
        items.append(collision_object(floor_object(world.floor_height), root))
    return items


Log = Callable[[str], object]
#: An object's place: in the world, or on the robot; neither where it does not exist.
_Place = tuple[CollisionObject | None, AttachedObject | None]


def of_world(update: SceneUpdate) -> bool:
    """Return whether the source is a simulated world."""
    attached = (item.object for item in update.robot_state.attached_objects)
    kinds = [item.type.key for item in (*update.objects, *attached)]
    diff = update.is_diff and not update.replaces_world and update.octomap is None
    return diff and bool(kinds) and set(kinds) == {WORLD_TYPE}


class WorldOwnership:
    """
    Lets a simulated world update its objects, and keeps the user's from it.

    :param scene: what both edit; each edit that does not come through here is the user's.
    :param standing: links that no joint moves; the world's objects may touch them.
    :param log: takes a line for each take-over.
    :param clock: returns the time [s] by which a client's copy of the scene is old.
    """

    def __init__(
        self, scene: PlanningScene, standing: Iterable[str], log: Log,
        clock: Callable[[], float],
    ) -> None:
        self._scene = scene
        self._standing = tuple(standing)
        self._log, self._clock = log, clock
        self._epoch = ''
        self._owned: dict[str, CollisionObject] = {}
        self._taken: set[str] = set()
        self._removed: set[str] = set()
        self._foreign: set[str] = set()
        #: Id -> places that the world has changed lately, each with the time of the change [s].
        self._earlier: dict[str, list[tuple[float, _Place]]] = {}
        self._lock = threading.RLock()
        self._telling = threading.local()
        scene.add_listener(self._look)

    @property
    def owned(self) -> frozenset[str]:
        """Ids that the world owns now."""
        with self._lock:
            return frozenset(self._owned)

    def apply(self, update: SceneUpdate) -> None:
        """
        Apply the world's update as far as the objects are its own.

        :raises PlanningError: an object cannot be updated; the others are done.
        """
        problems = [*update.unreadable, *update.robot_state.unreadable]
        before = self._scene.content
        self._telling.active = True
        try:
            for item in update.objects:
                try:
                    self._tell(item, update)
                except PlanningError as error:
                    problems.append(error)
            for attached in update.robot_state.attached_objects:
                try:
                    self._tell_attached(attached)
                except PlanningError as error:
                    problems.append(error)
        finally:
            self._telling.active = False
            self._note(before)
        if problems:
            raise joined(problems)

    def apply_client(self, update: SceneUpdate) -> None:
        """
        Apply a client's update; what the world has changed since the client's copy stays.

        :raises PlanningError: parts of it are refused; the others are done.
        """
        if update.is_diff and not update.replaces_world:
            self._scene.apply(update)
            return
        with self._scene.edited() as scene:
            present = scene.content
            try:
                scene.apply(update)
            finally:
                self._restore(scene, present)

    def _restore(self, scene: PlanningScene, present: SceneContent) -> None:
        """Give objects that are in an earlier place their present one."""
        since, content = self._clock() - LATEST_COPY, scene.content
        with self._lock:
            late = [id_ for id_, places in self._earlier.items() if any(
                time >= since and _same_place(place, _place(content, id_))
                for time, place in places)]
        scene.restore(late, present)
        for id_ in late:
            if not any(_place(content, id_)) and any(_place(present, id_)):
                scene.set_acm(scene.acm.with_entry(id_, True, self._standing))

    def _note(self, before: SceneContent) -> None:
        """Keep the places that the world has just changed, and drop old ones."""
        after, now = self._scene.content, self._clock()
        changed = {id_: _place(before, id_) for part in (before, after)
                   for id_ in (*part.objects, *part.attached)
                   if _place(before, id_) != _place(after, id_)}
        with self._lock:
            for id_, place in changed.items():
                self._earlier.setdefault(id_, []).append((now, place))
            recent = {id_: [each for each in places if each[0] >= now - LATEST_COPY]
                      for id_, places in self._earlier.items()}
            self._earlier = {id_: places for id_, places in recent.items() if places}

    def _tell(self, item: CollisionObject, update: SceneUpdate) -> None:
        self._begin_epoch(item.type, update)
        if item.operation == ObjectOperation.ADD:
            self._add(item, update)
        elif item.operation == ObjectOperation.REMOVE:
            self._remove(item.id)
        elif item.id in self.owned and item.id in self._scene.objects:
            self._move(item)

    def _add(self, item: CollisionObject, update: SceneUpdate) -> None:
        known = self._owned.get(item.id)
        if known is not None and item.id not in self._scene.attached:
            if not _same(known, item):
                self._put(item, update)
            else:
                self._move(item)
        if known is not None:
            return
        if item.id in self._taken or item.id in self._removed:
            return
        if item.id in self._scene.objects or item.id in self._scene.attached:
            if item.id not in self._foreign:
                self._foreign.add(item.id)
                self._log(f"object '{item.id}' is the user's; that of the simulated world of "
                          'that name stays out of the scene')
            return
        self._foreign.discard(item.id)
        self._put(item, update)

    def _move(self, item: CollisionObject) -> None:
        self._scene.apply_object(CollisionObject(
            item.id, ObjectOperation.MOVE, frame_id=item.frame_id, pose=item.pose))

    def _put(self, item: CollisionObject, update: SceneUpdate) -> None:
        colors = {name: color for name, color in update.object_colors.items() if name == item.id}
        plain = replace(item, type=ObjectType())
        self._scene.apply(SceneUpdate(objects=(plain,), object_colors=colors))
        if item.id not in self._owned and self._standing:
            self._scene.set_acm(self._scene.acm.with_entry(item.id, True, self._standing))
        with self._lock:
            self._owned[item.id] = item

    def _remove(self, id_: str) -> None:
        with self._lock:
            mine = self._owned.pop(id_, None) is not None
            self._taken.discard(id_)
            self._removed.discard(id_)
        if not mine:
            return
        if id_ in self._scene.attached:
            self._detach(id_)
        if id_ in self._scene.objects:
            self._scene.apply_object(CollisionObject(id_, ObjectOperation.REMOVE))

    def _tell_attached(self, item: AttachedObject) -> None:
        id_ = item.object.id
        if id_ not in self.owned:
            return
        if item.object.operation == ObjectOperation.REMOVE:
            if id_ in self._scene.attached:
                self._detach(id_)
        elif id_ in self._scene.objects:
            self._scene.apply_attached(item)
            for _ in range(MOST_LIFTS):
                way = self._way_out(id_)
                if not way.any():
                    return
                self._detach(id_)
                pose = self._scene.objects[id_].pose.copy()
                pose[:3, 3] += way
                self._move(CollisionObject(id_, pose=pose))
                self._scene.apply_attached(item)

    def _way_out(self, id_: str) -> Vector:
        """
        Return the way (3,) [m] by which an attached object leaves what it rests on.

        In the physics it rests a few micrometres deep; a plan could not begin there.
        """
        way = np.zeros(3)
        for contact in CollisionChecker(self._scene).contacts(self._scene.q):
            types = {contact.body1: contact.type1, contact.body2: contact.type2}
            if types.get(id_) is BodyType.ROBOT_ATTACHED and contact.depth < RESTING_DEPTH \
                    and BodyType.WORLD_OBJECT in types.values():
                outwards = 1.0 if contact.body2 == id_ else -1.0
                way += outwards * (contact.depth + LIFT) * contact.normal
        return way

    def _detach(self, id_: str) -> None:
        self._scene.apply_attached(AttachedObject(
            '', CollisionObject(id_, ObjectOperation.REMOVE)))

    def _begin_epoch(self, kind: ObjectType, update: SceneUpdate) -> None:
        """Forget take-overs where the world begins anew; its first message contains all of it."""
        if kind.key != WORLD_TYPE or kind.db == self._epoch:
            return
        with self._lock:
            self._epoch = kind.db
            old, taken = tuple(self._owned), tuple(self._taken)
            self._taken, self._removed = set(), set()
        added = {item.id for item in update.objects if item.operation == ObjectOperation.ADD}
        for id_ in old:
            if id_ not in added or id_ in self._scene.attached:
                self._remove(id_)
        for id_ in taken:
            if id_ in added and id_ in self._scene.attached:
                self._detach(id_)
            if id_ in added and id_ in self._scene.objects:
                self._scene.apply_object(CollisionObject(id_, ObjectOperation.REMOVE))

    def _look(self, before: SceneContent, after: SceneContent) -> None:
        """Note what the user does to the world's objects; in the thread that edits."""
        if getattr(self._telling, 'active', False) \
                or not (self._owned or self._removed or self._earlier):
            return
        if before.objects is after.objects and before.attached is after.attached:
            return
        with self._lock:
            again = {id_ for id_ in self._removed if id_ in after.objects}
            self._removed -= again
            self._taken |= again
            for id_ in tuple(dict.fromkeys((*self._owned, *self._earlier))):
                if _same_place(_place(before, id_), _place(after, id_)):
                    continue
                self._earlier.pop(id_, None)
                if self._owned.pop(id_, None) is None:
                    continue
                there = any(_place(after, id_))
                (self._taken if there else self._removed).add(id_)
                self._log(f"object '{id_}' of the simulated world was "
                          + ('changed by the user and no longer updated' if there else
                             'removed by the user and stays away')
                          + ', until it is deleted there or the simulation is reset')


def _place(content: SceneContent, id_: str) -> _Place:
    return content.objects.get(id_), content.attached.get(id_)


def _same_place(first: _Place, second: _Place) -> bool:
    """Return whether an object has the same content at the same place."""
    return _same_item(first[0], second[0]) and _same_attached(first[1], second[1])


def _same_attached(first: AttachedObject | None, second: AttachedObject | None) -> bool:
    """Return whether two are the same on the same link, or neither exists."""
    if first is None or second is None or first is second:
        return first is second
    return (first.link_name, set(first.touch_links)) == (
        second.link_name, set(second.touch_links)) and _same_item(first.object, second.object)


def _same_item(first: CollisionObject | None, second: CollisionObject | None) -> bool:
    """Return whether two have the same content, or neither exists."""
    if first is None or second is None or first is second:
        return first is second
    return (
        first.type == second.type and _same(first, second)
        and np.allclose(first.pose, second.pose, rtol=0.0, atol=SAME)
        and first.subframes.keys() == second.subframes.keys()
        and all(np.allclose(pose, second.subframes[name], rtol=0.0, atol=SAME)
                for name, pose in first.subframes.items()))


def _same(first: CollisionObject, second: CollisionObject) -> bool:
    """Return whether two have the same shapes, at any pose."""
    def content(shape: ObjectShape) -> object:
        mesh = shape.geometry
        if isinstance(mesh, Mesh):
            return mesh.vertices.tobytes(), mesh.triangles.tobytes()
        return mesh

    return len(first.shapes) == len(second.shapes) and all(
        content(a) == content(b) and np.allclose(a.pose, b.pose)
        for a, b in zip(first.shapes, second.shapes, strict=True))
