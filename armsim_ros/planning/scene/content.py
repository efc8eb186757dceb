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
from armsim_ros.planning.scene.octomap import Octomap

Value = TypeVar('Value')
Color = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class FixedFrame:
    """
    A frame that is fixed in another frame, as TF has it.

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
    :param frames: frames of TF, each fixed to another frame.
    :param fixed_frames: frame -> pose (4, 4) in the model frame, as scene messages gave it; it is
        used where TF does not connect the frame to the robot.
    :param standing: of a request: the content in which TF was when it came; further frames are
        where they are there, unless the request has them, whatever its robot state.
    :param colors: object id -> rgba.
    :param first_colors: object id -> the first colour that it was given, its own after a detach.
    :param octomap: what cameras see, None where there is no map.
    :param whole_version: number of edits after which a follower needs the whole scene.
    """

    q: Vector
    name: str = ''
    objects: Mapping[str, CollisionObject] = field(default_factory=_nothing)
    attached: Mapping[str, AttachedObject] = field(default_factory=_nothing)
    acm: AllowedCollisionMatrix = field(default_factory=AllowedCollisionMatrix)
    link_padding: Mapping[str, float] = field(default_factory=_nothing)
    link_scale: Mapping[str, float] = field(default_factory=_nothing)
    frames: Mapping[str, FixedFrame] = field(default_factory=_nothing)
    fixed_frames: Mapping[str, Matrix] = field(default_factory=_nothing)
    standing: SceneContent | None = None
    colors: Mapping[str, Color] = field(default_factory=_nothing)
    first_colors: Mapping[str, Color] = field(default_factory=_nothing)
    octomap: Octomap | None = None
    whole_version: int = 0

    def collides_like(self, other: SceneContent) -> bool:
        """Return whether both hold the same things in the way of a motion, and frames."""
        return all(getattr(self, part) is getattr(other, part) for part in _IN_THE_WAY)


#: Parts of a content that hold frames; that decide whether a robot state collides.
FRAMES = ('frames', 'fixed_frames', 'standing')
_IN_THE_WAY = ('objects', 'attached', 'acm', 'link_padding', 'link_scale', 'octomap', *FRAMES)


class SceneDraft:
    """
    A content that can be changed; readers of the scene see all changes at once.

    :param kinematics: the robot.
    :param base: the content to begin with; it is not changed.
    """

    def __init__(self, kinematics: KinematicModel, base: SceneContent) -> None:
        self.kinematics, self._base = kinematics, base
        self.q, self.name, self.acm = base.q, base.name, base.acm
        self.objects, self.attached = dict(base.objects), dict(base.attached)
        self.link_padding, self.link_scale = dict(base.link_padding), dict(base.link_scale)
        self.frames, self.fixed_frames = base.frames, base.fixed_frames
        self.standing = base.standing
        self.colors, self.first_colors = dict(base.colors), dict(base.first_colors)
        self.octomap, self.whole_version = base.octomap, base.whole_version
        self._forgotten: set[str] = set()

    def content(self) -> SceneContent:
        """Return what the draft holds; parts that are as they were are those of the base."""
        self.acm = self.acm.without(self._forgotten)
        changed: dict[str, Any] = {}
        for each in fields(SceneContent):
            part, before = getattr(self, each.name), getattr(self._base, each.name)
            if part is not before and not (isinstance(part, dict) and part == before):
                changed[each.name] = MappingProxyType(part) if isinstance(part, dict) else part
        return replace(self._base, **changed) if changed else self._base

    def remove(self, ids: Iterable[str]) -> None:
        """Take objects out of the world, and their colours and rules with them."""
        for id_ in tuple(ids):
            self.objects.pop(id_, None)
            self.colors.pop(id_, None)
            self._forgotten.add(id_)

    def restore(self, ids: Iterable[str], content: SceneContent) -> None:
        """Set objects to what they are in another content; colours given meanwhile stay."""
        for id_ in ids:
            if id_ in content.attached:
                self.attach(content.attached[id_])
            else:
                self.attached.pop(id_, None)
                if id_ in content.objects:
                    self.objects[id_] = content.objects[id_]
                else:
                    self.remove((id_,))
            for colors, earlier in ((self.colors, content.colors),
                                    (self.first_colors, content.first_colors)):
                if id_ in earlier:
                    colors.setdefault(id_, earlier[id_])

    def attach(self, item: AttachedObject) -> None:
        """Put an object onto the robot; it is in the world no more."""
        self.attached[item.id] = item
        self.objects.pop(item.id, None)

    def frame_pose(self, frame: str) -> Matrix:
        """Return the pose (4, 4) of a frame in the model frame, see :func:`frame_pose`."""
        return frame_pose(self.kinematics, self, frame)

    def link_pose(self, link: str) -> Matrix:
        """Return the pose (4, 4) of a link in the model frame."""
        return self.kinematics.link_pose(self.q, link)

    def check_link(self, link: str, what: str) -> None:
        """
        Refuse a link that the robot does not have.

        :param what: begins the sentence and ends before the link.
        :raises PlanningError: INVALID_LINK_NAME.
        """
        if not self.kinematics.has_link(link):
            robot = self.kinematics.robot
            raise PlanningError(
                MoveItErrorCode.INVALID_LINK_NAME,
                f"{what} link '{link}', which robot '{robot.name}' does not have "
                f'{nearest(link, tuple(robot.links))}'.rstrip(),
                'planning scene')


SceneParts = SceneContent | SceneDraft

#: Transforms from a frame to the robot, nested; more are a cycle.
LONGEST_CHAIN = 100


def link_of_frame(
    kinematics: KinematicModel, content: SceneParts, frame: str
) -> tuple[str, Matrix]:
    """
    Return the link that a frame is fixed to, and its pose (4, 4) on that link.

    Links come first, then attached objects, then the world, then further frames; a subframe is
    ``object/subframe``. What is in the world is fixed to the root link; so is a further
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
    fixed: Matrix | None = None
    for _ in range(LONGEST_CHAIN):
        found = _own_frame(kinematics, content, name)
        if found is not None:
            link, pose = found
            offset = pose @ offset
            if link == kinematics.robot.root_link:
                return offset
            return kinematics.link_pose(content.q if q is None else q, link) @ offset
        if fixed is None:
            fixed = _fixed_pose(kinematics, content, name)
            fixed = None if fixed is None else fixed @ offset
        edge = content.frames.get(name)
        if edge is None:
            break
        name, offset = _name(edge.parent), edge.pose @ offset
    if fixed is not None:
        return fixed
    if name not in content.frames:
        raise _unknown(kinematics, content, frame, name)
    raise PlanningError(
        MoveItErrorCode.FRAME_TRANSFORM_FAILURE,
        f"frame '{frame}': its chain of transforms leads to no link of the robot, it goes in a "
        f"circle at '{name}'",
        'planning scene')


def _fixed_pose(
    kinematics: KinematicModel, content: SceneParts, name: str
) -> Matrix | None:
    """Return the pose (4, 4) of a frame that moves with no robot state, None for any other."""
    if name in content.fixed_frames:
        return content.fixed_frames[name]
    if content.standing is None or name not in further_frames(content.standing):
        return None
    return frame_pose(kinematics, content.standing, name)


def transform(kinematics: KinematicModel, content: SceneContent, frame: str) -> Matrix:
    """
    Return the pose (4, 4) of a frame in the model frame as TF has it: objects are not in TF.

    :param frame: '' is the model frame.
    :raises PlanningError: FRAME_TRANSFORM_FAILURE for a frame that TF does not have.
    """
    nothing: Mapping[str, Any] = {}
    try:
        return frame_pose(
            kinematics, replace(content, objects=nothing, attached=nothing), frame)
    except PlanningError as error:
        if _own_frame(kinematics, content, _name(frame)) is None:
            raise
        raise PlanningError(
            error.code, f"frame '{frame}' is an object of the planning scene and not a frame of "
            'TF; give the pose in a link or a frame that is published on /tf', 'tf') from None


def robot_frame(
    kinematics: KinematicModel, content: SceneParts, frame: str
) -> tuple[str, Matrix] | None:
    """Return link and pose on it of a link, an attached object or its subframe, else None."""
    name = _name(frame)
    if kinematics.has_link(name):
        return name, np.eye(4)
    attached = content.attached.get(name)
    if attached is not None:
        return attached.link_name, attached.object.pose
    for owner, subframe in _splits(name):
        attached = content.attached.get(owner)
        if attached is not None and subframe in attached.object.subframes:
            body = attached.object
            return attached.link_name, body.pose @ body.subframes[subframe]
    return None


def _own_frame(
    kinematics: KinematicModel, content: SceneParts, name: str
) -> tuple[str, Matrix] | None:
    """Return link and pose of a frame of robot or objects, None for any other."""
    robot = kinematics.robot
    found = robot_frame(kinematics, content, name)
    if found is not None:
        return found
    if not name or name == robot.model_frame:
        return robot.root_link, np.eye(4)
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
        f"frame '{frame}' is not a link, object, subframe or known fixed frame{joined}; "
        f"the model frame is '{kinematics.robot.model_frame}' "
        f'{nearest(name, known_frames(kinematics, content))}'.rstrip(),
        'planning scene')


def further_frames(content: SceneParts) -> tuple[str, ...]:
    """Return the names of the frames that TF or a scene message added."""
    before = () if content.standing is None else further_frames(content.standing)
    return tuple(dict.fromkeys((*before, *content.frames, *content.fixed_frames)))


def known_frames(kinematics: KinematicModel, content: SceneParts) -> tuple[str, ...]:
    """Return the names of all frames."""
    bodies = [*content.objects.values(), *(item.object for item in content.attached.values())]
    subframes = [f'{body.id}/{name}' for body in bodies for name in body.subframes]
    return (
        *kinematics.robot.links, *(body.id for body in bodies), *subframes,
        *further_frames(content))
