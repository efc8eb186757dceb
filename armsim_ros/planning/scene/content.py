# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All that a scene holds, and a draft of it that an edit changes before it counts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any, TypeVar

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.planning.scene.allowed_collision_matrix import AllowedCollisionMatrix
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject

Value = TypeVar('Value')
Color = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class FixedFrame:
    """
    A frame that stands still in another one, as transforms tell it.

    Where it is in the model frame is found out when it is used: what carries it may move.

    :param parent: a link, object or another such frame; '' is the model frame.
    :param pose: (4, 4) in the parent frame.
    """

    parent: str
    pose: Matrix


def _nothing() -> Mapping[str, Value]:
    return MappingProxyType({})


@dataclass(frozen=True, slots=True, eq=False)
class SceneContent:
    """
    Robot state, world, attached objects and rules; nothing in it ever changes.

    Parts that an edit leaves alone are shared between contents, so a part that ``is`` the same
    holds the same.

    :param q: (n,) robot state, read-only.
    :param objects: id -> object in the world.
    :param attached: id -> object on the robot.
    :param link_padding: link -> [m] added around it against the world.
    :param link_scale: link -> factor of its size against the world.
    :param frames: further frames, each fixed to another one.
    :param colors: object id -> rgba in 0..1.
    """

    q: Vector
    name: str = ''
    objects: Mapping[str, CollisionObject] = field(default_factory=_nothing)
    attached: Mapping[str, AttachedObject] = field(default_factory=_nothing)
    acm: AllowedCollisionMatrix = field(default_factory=AllowedCollisionMatrix)
    link_padding: Mapping[str, float] = field(default_factory=_nothing)
    link_scale: Mapping[str, float] = field(default_factory=_nothing)
    frames: Mapping[str, FixedFrame] = field(default_factory=_nothing)
    colors: Mapping[str, Color] = field(default_factory=_nothing)


class SceneDraft:
    """
    A content that can be changed; whoever refuses the change drops the draft.

    A part is copied when it is first changed, so an edit of many objects costs as much as there
    are objects, and what no edit touches stays the very same in :meth:`content`.

    :param base: what to begin with; it is not changed.
    """

    def __init__(self, base: SceneContent) -> None:
        self._base = base
        self._parts: dict[str, Any] = {}
        self._own_parts: set[str] = set()
        self._forgotten: set[str] = set()

    # ---------------------------------------------------------------- what it holds

    @property
    def q(self) -> Vector:
        """Robot state (n,), read-only."""
        state: Vector = self._part('q')
        return state

    @property
    def objects(self) -> Mapping[str, CollisionObject]:
        """Objects in the world, by id."""
        held: Mapping[str, CollisionObject] = self._part('objects')
        return held

    @property
    def attached(self) -> Mapping[str, AttachedObject]:
        """Objects on the robot, by id."""
        held: Mapping[str, AttachedObject] = self._part('attached')
        return held

    @property
    def frames(self) -> Mapping[str, FixedFrame]:
        """Further frames."""
        held: Mapping[str, FixedFrame] = self._part('frames')
        return held

    def content(self) -> SceneContent:
        """Return what the draft holds, never to be changed again."""
        if self._forgotten:
            acm: AllowedCollisionMatrix = self._part('acm')
            self._parts['acm'] = acm.without(self._forgotten)
        for name in self._own_parts:
            self._parts[name] = MappingProxyType(self._parts[name])
        self._own_parts, self._forgotten = set(), set()
        return replace(self._base, **self._parts)

    # ---------------------------------------------------------------- changes

    def replace(self, **parts: Any) -> None:
        """Replace whole parts of the content."""
        self._parts.update(parts)
        self._own_parts -= parts.keys()
        if 'acm' in parts:
            self._forgotten = set()

    def begin_anew(self, initial: SceneContent, *, keep_attached: bool) -> None:
        """Go back to a scene's beginning, but for the robot's state and the further frames."""
        kept = {'q': self.q, 'frames': self._part('frames')}
        if keep_attached:
            kept['attached'] = self._part('attached')
        self.replace(**{
            each.name: kept.get(each.name, getattr(initial, each.name))
            for each in fields(SceneContent)
        })

    def update(self, part: str, items: Mapping[str, Any]) -> None:
        """Add or renew items of a part that is a mapping."""
        if items:
            self._own(part).update(items)

    def put(self, body: CollisionObject) -> None:
        """Put an object into the world, in place of the one of the same id."""
        self._own('objects')[body.id] = body

    def take(self, *ids: str) -> None:
        """Take objects out of the world, where they are in it."""
        if any(id_ in self.objects for id_ in ids):
            objects = self._own('objects')
            for id_ in ids:
                objects.pop(id_, None)

    def remove(self, ids: Iterable[str]) -> None:
        """Take objects out of the world, and their colours and rules with them."""
        gone = tuple(ids)
        self.take(*gone)
        if any(id_ in self._part('colors') for id_ in gone):
            colors = self._own('colors')
            for id_ in gone:
                colors.pop(id_, None)
        self._forgotten.update(gone)

    def attach(self, item: AttachedObject) -> None:
        """Put an object onto the robot; it is in the world no more."""
        self._own('attached')[item.id] = item
        self.take(item.id)

    def detach(self, item: AttachedObject, body: CollisionObject) -> None:
        """Take an object from the robot; it stands in the world unless its id does already."""
        del self._own('attached')[item.id]
        if item.id not in self.objects:
            self.put(body)

    def _part(self, name: str) -> Any:
        return self._parts[name] if name in self._parts else getattr(self._base, name)

    def _own(self, name: str) -> dict[str, Any]:
        """Return a part as a dictionary that only this draft has."""
        if name not in self._own_parts:
            self._own_parts.add(name)
            self._parts[name] = dict(self._part(name))
        own: dict[str, Any] = self._parts[name]
        return own
