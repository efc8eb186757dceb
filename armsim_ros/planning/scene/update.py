# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Scene messages and start states as plain values, and how a draft of a scene takes them over.

Values stand as the client gave them; what is wrong with them is found where they are used.
Poses are (4, 4).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from typing import Any

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.scene.allowed_collision_matrix import AcmUpdate, AllowedCollisionMatrix
from armsim_ros.planning.scene.content import (
    Color,
    FixedFrame,
    SceneContent,
    SceneDraft,
)
from armsim_ros.planning.scene.object_operations import apply_attached, apply_object
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    check_pose,
    CollisionObject,
    object_error,
    ObjectOperation,
)

#: Refusals of one message that are told; what comes after them is not tried any more.
MOST_REFUSALS = 10


@dataclass(frozen=True, slots=True)
class StartState:
    """
    Where a motion begins.

    :param joint_names: joints that differ from the monitored state.
    :param positions: [rad or m], one a joint name.
    :param is_diff: whether attached objects of the monitored scene stay.
    :param attached_objects: objects to attach for this request.
    :param velocities: [rad/s or m/s] of the joints; may be empty.
    """

    joint_names: tuple[str, ...] = ()
    positions: tuple[float, ...] = ()
    is_diff: bool = True
    attached_objects: tuple[AttachedObject, ...] = ()
    velocities: tuple[float, ...] = ()

    @classmethod
    def from_positions(cls, positions: Mapping[str, float]) -> StartState:
        """Return the monitored state with these joints [rad or m] laid over it."""
        return cls(tuple(positions), tuple(positions.values()))


@dataclass(frozen=True, slots=True, eq=False)
class SceneUpdate:
    """
    Content of ``moveit_msgs/msg/PlanningScene``.

    :param is_diff: False replaces the whole scene.
    :param acm: None where the client gave none.
    :param link_padding: link -> [m].
    :param link_scale: link -> factor.
    :param fixed_frames: further frames by name.
    :param object_colors: object id -> rgba in 0..1.
    """

    is_diff: bool = True
    name: str = ''
    robot_state: StartState = field(default_factory=StartState)
    objects: tuple[CollisionObject, ...] = ()
    acm: AcmUpdate | None = None
    link_padding: Mapping[str, float] = field(default_factory=dict)
    link_scale: Mapping[str, float] = field(default_factory=dict)
    fixed_frames: Mapping[str, FixedFrame] = field(default_factory=dict)
    object_colors: Mapping[str, Color] = field(default_factory=dict)

    @property
    def empty(self) -> bool:
        """Whether it is a diff that changes nothing."""
        state = self.robot_state
        return self.is_diff and not (
            self.name
            or state.joint_names
            or state.positions
            or state.attached_objects
            or self.objects
            or (self.acm is not None and self.acm.entry_names)
            or self.link_padding
            or self.link_scale
            or self.fixed_frames
            or self.object_colors
        )


def apply_update(draft: SceneDraft, update: SceneUpdate, initial: SceneContent) -> None:
    """
    Do all that a scene message asks for.

    Every operation is tried, so that the error can name what is wrong with each.

    :param draft: to be dropped where the update is refused.
    :param initial: what a message that is no difference starts from; its allowed collision
        matrix stays where such a message gives none.
    :raises PlanningError: with the code of the first refusal and the sentences of all.
    """
    refusals: list[PlanningError] = []

    def attempt(step: Callable[..., None], *arguments: Any) -> None:
        if len(refusals) < MOST_REFUSALS:
            try:
                step(draft, *arguments)
            except PlanningError as error:
                refusals.append(error)

    if not update.is_diff:
        draft.begin_anew(initial, keep_attached=update.robot_state.is_diff)
    standing = frozenset(draft.objects)
    if update.name:
        draft.name = update.name
    attempt(_set_frames, update.fixed_frames)
    if update.robot_state.joint_names or update.robot_state.positions:
        attempt(_set_joints, update.robot_state)
        if not update.robot_state.is_diff:
            draft.attached = dict(initial.attached)
    for attached in update.robot_state.attached_objects:
        attempt(apply_attached, attached)
    attempt(_set_acm, update.acm)
    attempt(_set_padding, update.link_padding)
    attempt(_set_scale, update.link_scale)
    attempt(_set_colors, update.object_colors)
    for item in update.objects:
        taken = item.id in standing and item.id not in draft.objects
        if item.operation == ObjectOperation.REMOVE and taken and item.id in draft.attached:
            continue  # the same message has attached it
        attempt(apply_object, item)
    if refusals:
        raise _joined(refusals)


def _joined(refusals: Sequence[PlanningError]) -> PlanningError:
    """Return the errors of an update as one."""
    first = refusals[0]
    if len(refusals) == 1:
        return first
    text = '; '.join(map(str, refusals))
    more = ', and perhaps more' if len(refusals) == MOST_REFUSALS else ''
    return PlanningError(
        first.code, f'{len(refusals)} parts{more}, are refused: {text}', first.source
    )


def apply_start_state(draft: SceneDraft, start: StartState, *, strict: bool) -> None:
    """
    Take over a client's start state.

    :raises PlanningError: INVALID_ROBOT_STATE, or what an attached object is refused for.
    """
    _set_joints(draft, start)
    given = bool(start.joint_names or start.attached_objects)
    if strict and given and not start.is_diff:
        draft.attached = {}
    for attached in start.attached_objects:
        apply_attached(draft, attached)


def _set_joints(draft: SceneDraft, state: StartState) -> None:
    names, positions = state.joint_names, state.positions
    if len(names) != len(positions):
        raise PlanningError(
            MoveItErrorCode.INVALID_ROBOT_STATE,
            f'the robot state has {len(names)} joint names but {len(positions)} positions',
            'planning scene',
        )
    if names:
        q = draft.kinematics.vector(dict(zip(names, positions, strict=True)), draft.q)
        q.setflags(write=False)
        draft.q = q


def _set_frames(draft: SceneDraft, frames: Mapping[str, FixedFrame]) -> None:
    for name, frame in frames.items():
        if name.lstrip('/'):
            draft.frames[name.lstrip('/')] = replace(
                frame, pose=check_pose(frame.pose, f"the pose of frame '{name}'"))
    for name in frames:
        draft.frame_pose(name.lstrip('/'))


def _set_acm(draft: SceneDraft, acm: AcmUpdate | None) -> None:
    if acm is not None:
        made = AllowedCollisionMatrix.from_update(acm)
        draft.acm = made if acm.entry_names else draft.acm


def _set_padding(draft: SceneDraft, padding: Mapping[str, float]) -> None:
    for link, value in padding.items():
        draft.check_link(link, 'padding is given for')
        if not (math.isfinite(value) and value >= 0.0):
            raise object_error(f"padding {value} m of link '{link}'; allowed: 0 or more")
    draft.link_padding.update(padding)


def _set_scale(draft: SceneDraft, scale: Mapping[str, float]) -> None:
    for link, value in scale.items():
        draft.check_link(link, 'scale is given for')
        if not (math.isfinite(value) and value > 0.0):
            raise object_error(f"scale {value} of link '{link}'; allowed: above 0")
    draft.link_scale.update(scale)


def _set_colors(draft: SceneDraft, colors: Mapping[str, Color]) -> None:
    for id_, color in colors.items():
        if not all(math.isfinite(part) and 0.0 <= part <= 1.0 for part in color):
            raise object_error(f"color {color} of object '{id_}'; allowed: 0 to 1 for r, g, b, a")
    draft.colors.update(colors)
