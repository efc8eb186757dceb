# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All that a scene holds and where its frames are, and a draft of it for an edit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
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


SceneParts = SceneContent | SceneDraft

#: Transforms from a frame to the robot, one in the other; more are a circle.
LONGEST_CHAIN = 100


def link_of_frame(
    kinematics: KinematicModel, content: SceneParts, frame: str
) -> tuple[str, Matrix]:
    """
    Return the link that a frame is fixed to, and its pose (4, 4) on that link.

    Links come first, then attached objects, then the world, then further frames; a subframe is
    ``object/subframe``. What stands in the world is fixed to the root link; so is a further
    frame, at the place where it is in the content's robot state.

    :param frame: '' is the model frame; a leading slash is dropped.
    :raises PlanningError: FRAME_TRANSFORM_FAILURE for an unknown frame.
    """
    found = _own_frame(kinematics, content, _name(frame))
    if found is None:
        return kinematics.robot.root_link, frame_pose(kinematics, content, frame)
    return found


def frame_pose(
    kinematics: KinematicModel, content: SceneParts, frame: str, q: Vector | None = None
) -> Matrix:
    """
    Return the pose (4, 4) of a frame in the model frame.

    :param q: (n,) robot state; None for the content's. What moves with a link is where the link
        is in that state.
    :raises PlanningError: FRAME_TRANSFORM_FAILURE for an unknown frame.
    """
    name, offset = _name(frame), np.eye(4)
    for _ in range(LONGEST_CHAIN):
        found = _own_frame(kinematics, content, name)
        if found is not None:
            link, pose = found
            offset = pose @ offset
            if link == kinematics.robot.root_link:
                return offset
            return kinematics.link_pose(content.q if q is None else q, link) @ offset
        edge = content.frames.get(name)
        if edge is None:
            raise _unknown(kinematics, content, frame, name)
        name, offset = _name(edge.parent), edge.pose @ offset
    raise PlanningError(
        MoveItErrorCode.FRAME_TRANSFORM_FAILURE,
        f"frame '{frame}': its chain of transforms leads to no link of the robot, it goes in a "
        f"circle at '{name}'",
        'planning scene',
    )


def _own_frame(
    kinematics: KinematicModel, content: SceneParts, name: str
) -> tuple[str, Matrix] | None:
    """Return link and pose of a frame of robot or objects, None for any other."""
    robot = kinematics.robot
    if kinematics.has_link(name):
        return name, np.eye(4)
    if not name or name == robot.model_frame:
        return robot.root_link, np.eye(4)
    attached = content.attached.get(name)
    if attached is not None:
        return attached.link_name, attached.object.pose
    for owner, subframe in _splits(name):
        attached = content.attached.get(owner)
        if attached is not None and subframe in attached.object.subframes:
            body = attached.object
            return attached.link_name, body.pose @ body.subframes[subframe]
    item = content.objects.get(name)
    if item is not None:
        return robot.root_link, item.pose
    for owner, subframe in _splits(name):
        item = content.objects.get(owner)
        if item is not None and subframe in item.subframes:
            return robot.root_link, item.pose @ item.subframes[subframe]
    return None


def _splits(name: str) -> Iterator[tuple[str, str]]:
    """Yield the parts before and after each slash of ``object/subframe``."""
    at = name.find('/')
    while at >= 0:
        yield name[:at], name[at + 1 :]
        at = name.find('/', at + 1)


def _name(frame: str) -> str:
    return frame[1:] if frame.startswith('/') else frame


def _unknown(
    kinematics: KinematicModel, content: SceneParts, frame: str, name: str
) -> PlanningError:
    joined = f"; its chain of transforms ends at '{name}'" if name != _name(frame) else ''
    return PlanningError(
        MoveItErrorCode.FRAME_TRANSFORM_FAILURE,
        f"frame '{frame}' is no link, object, subframe or known fixed frame{joined}; "
        f"the model frame is '{kinematics.robot.model_frame}' "
        f'{nearest(name, known_frames(kinematics, content))}'.rstrip(),
        'planning scene',
    )


def known_frames(kinematics: KinematicModel, content: SceneParts) -> tuple[str, ...]:
    """Return the names of all frames."""
    bodies = [*content.objects.values(), *(item.object for item in content.attached.values())]
    subframes = [f'{body.id}/{name}' for body in bodies for name in body.subframes]
    return (
        *kinematics.robot.links,
        *(body.id for body in bodies),
        *subframes,
        *content.frames,
    )
