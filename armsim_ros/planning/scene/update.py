# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Scene messages and start states as plain values, and how a draft of a scene takes them over.

Values are those that the client gave; they are checked where they are used. Poses are (4, 4).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
import math
from types import MappingProxyType
from typing import Any

from armsim_ros.arrays import Matrix
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.scene.allowed_collision_matrix import AcmUpdate, AllowedCollisionMatrix
from armsim_ros.planning.scene.content import Color, SceneDraft
from armsim_ros.planning.scene.object_operations import (
    apply_attached,
    apply_attached_in_state,
    apply_object,
)
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    check_pose,
    CollisionObject,
    object_error,
    ObjectOperation,
    ObjectType,
)
from armsim_ros.planning.scene.octomap import OctomapUpdate

#: Refusals of a message that are described; of others only the number is reported.
MOST_REFUSALS = 10


@dataclass(frozen=True, slots=True)
class StartState:
    """
    Where a motion begins.

    :param joint_names: joints that differ from the monitored state.
    :param positions: [rad or m], a value per joint name.
    :param is_diff: whether attached objects of the monitored scene stay.
    :param attached_objects: objects to attach or to take away for this request.
    :param velocities: [rad/s or m/s] of the joints; may be empty.
    :param unreadable: why other attached objects could not be read.
    """

    joint_names: tuple[str, ...] = ()
    positions: tuple[float, ...] = ()
    is_diff: bool = True
    attached_objects: tuple[AttachedObject, ...] = ()
    velocities: tuple[float, ...] = ()
    unreadable: tuple[PlanningError, ...] = ()

    @classmethod
    def from_positions(cls, positions: Mapping[str, float]) -> StartState:
        """Return the monitored state with these joints [rad or m] laid over it."""
        return cls(tuple(positions), tuple(positions.values()))


@dataclass(frozen=True, slots=True, eq=False)
class SceneUpdate:
    """
    Content of ``moveit_msgs/msg/PlanningScene``.

    :param is_diff: False replaces world, colours and allowed collision matrix.
    :param acm: None where the client gave none.
    :param link_padding: link -> [m].
    :param link_scale: link -> factor.
    :param fixed_frames: frame -> pose (4, 4) in the model frame.
    :param object_colors: object id -> rgba.
    :param replaces_world: whether the objects take the place of those in the world.
    :param octomap: takes the place of the scene's map; None leaves it.
    :param unreadable: why other parts could not be read.
    """

    is_diff: bool = True
    name: str = ''
    robot_state: StartState = field(default_factory=StartState)
    objects: tuple[CollisionObject, ...] = ()
    acm: AcmUpdate | None = None
    link_padding: Mapping[str, float] = field(default_factory=dict)
    link_scale: Mapping[str, float] = field(default_factory=dict)
    fixed_frames: Mapping[str, Matrix] = field(default_factory=dict)
    object_colors: Mapping[str, Color] = field(default_factory=dict)
    replaces_world: bool = False
    octomap: OctomapUpdate | None = None
    unreadable: tuple[PlanningError, ...] = ()


class _Attempts:
    """Operations on a draft, each of which is done or changes nothing."""

    def __init__(self, draft: SceneDraft, refusals: Sequence[PlanningError] = ()) -> None:
        self._draft = draft
        self.refusals = list(refusals)

    def __call__(self, step: Callable[..., None], *arguments: Any) -> None:
        try:
            step(self._draft, *arguments)
        except PlanningError as error:
            self.refusals.append(error)


def apply_update(
    draft: SceneDraft, update: SceneUpdate,
    apply_item: Callable[[SceneDraft, CollisionObject], None] = apply_object,
) -> list[PlanningError]:
    """
    Do all that a scene message asks for and that can be done; return the other refusals.

    :param apply_item: what is done with each object of the world.
    """
    state = update.robot_state
    attempt = _Attempts(draft, (*update.unreadable, *state.unreadable))
    whole = not update.is_diff
    if whole or update.replaces_world or (update.name and update.name != draft.name) or (
        (update.acm is not None and update.acm.entry_names)
        or update.link_padding or update.link_scale
    ):
        draft.whole_version += 1
    if whole or update.name:
        draft.name = update.name
    for frame in update.fixed_frames.items():
        attempt(_set_frame, *frame)
    if state.joint_names:
        attempt(_set_state, state)
    for attached in state.attached_objects:
        attempt(apply_attached if state.is_diff else _add_attached, attached)
    if whole:
        attempt(_replace_acm, update.acm or AcmUpdate())
        draft.colors, draft.first_colors = {}, {}
        draft.attached.update({
            id_: replace(item, object=replace(item.object, type=ObjectType()))
            for id_, item in draft.attached.items() if not item.object.type.empty
        })
    elif update.acm is not None:
        attempt(_merge_acm, update.acm)
    for padding in update.link_padding.items():
        attempt(_set_padding, *padding)
    for scale in update.link_scale.items():
        attempt(_set_scale, *scale)
    for color in update.object_colors.items():
        attempt(_set_color, *color)
    if whole or update.replaces_world:
        draft.objects = {}
    for item in update.objects:
        attempt(apply_item, item)
    if update.octomap is not None:
        attempt(_set_octomap, update.octomap)
    return attempt.refusals


def joined(refusals: Sequence[PlanningError]) -> PlanningError:
    """Return the errors of an update, at least one, as a single error."""
    first, more = refusals[0], len(refusals) - MOST_REFUSALS
    if len(refusals) == 1:
        return first
    text = '; '.join(map(str, refusals[:MOST_REFUSALS]))
    if more > 0:
        text += f'; and {more} more'
    return PlanningError(
        first.code, f'{len(refusals)} parts are refused: {text}', first.source)


def apply_start_state(
    draft: SceneDraft, start: StartState, *, strict: bool
) -> list[PlanningError]:
    """
    Take over a client's start state; return why attached objects were refused.

    :param strict: whether a state that is not a difference drops the scene's attached objects.
    :raises PlanningError: INVALID_ROBOT_STATE.
    """
    _set_joints(draft, start)
    given = bool(start.joint_names or start.attached_objects)
    if strict and given and not start.is_diff:
        draft.attached = {}
    attempt = _Attempts(draft, start.unreadable)
    for attached in start.attached_objects:
        attempt(apply_attached_in_state, attached)
    return attempt.refusals


def _set_state(draft: SceneDraft, state: StartState) -> None:
    _set_joints(draft, state)
    if not state.is_diff:
        draft.attached = {}


def _add_attached(draft: SceneDraft, item: AttachedObject) -> None:
    if item.object.operation != ObjectOperation.ADD:
        raise object_error(
            f"attached object '{item.id}': a robot state whose is_diff is false takes ADD only; "
            'set robot_state.is_diff to detach or change it')
    apply_attached(draft, item)


def _set_joints(draft: SceneDraft, state: StartState) -> None:
    names, positions = state.joint_names, state.positions
    if len(names) != len(positions):
        raise PlanningError(
            MoveItErrorCode.INVALID_ROBOT_STATE,
            f'the robot state has {len(names)} joint names but {len(positions)} positions',
            'planning scene')
    if names:
        q = draft.kinematics.vector(dict(zip(names, positions, strict=True)), draft.q)
        q.setflags(write=False)
        draft.q = q


def _set_frame(draft: SceneDraft, name: str, pose: Matrix) -> None:
    added = {name.removeprefix('/'): check_pose(pose, f"the pose of frame '{name}'")}
    draft.fixed_frames = MappingProxyType({**draft.fixed_frames, **added})


def _replace_acm(draft: SceneDraft, acm: AcmUpdate) -> None:
    draft.acm = AllowedCollisionMatrix.from_update(acm)


def _merge_acm(draft: SceneDraft, acm: AcmUpdate) -> None:
    made = AllowedCollisionMatrix.from_update(acm)
    if acm.entry_names:
        draft.acm = made


def _set_padding(draft: SceneDraft, link: str, padding: float) -> None:
    draft.check_link(link, 'padding is given for')
    if not (math.isfinite(padding) and padding >= 0.0):
        raise object_error(f"padding {padding} m of link '{link}'; allowed: 0 or more")
    draft.link_padding[link] = padding


def _set_scale(draft: SceneDraft, link: str, scale: float) -> None:
    draft.check_link(link, 'scale is given for')
    if not (math.isfinite(scale) and scale > 0.0):
        raise object_error(f"scale {scale} of link '{link}'; allowed: above 0")
    draft.link_scale[link] = scale


def _set_octomap(draft: SceneDraft, update: OctomapUpdate) -> None:
    octomap = update.octomap
    if octomap is not None:
        octomap = replace(octomap, pose=draft.frame_pose(update.frame_id) @ octomap.pose)
    draft.octomap = octomap


def _set_color(draft: SceneDraft, id_: str, color: Color) -> None:
    if not id_:
        raise object_error('a colour needs the id of an object that is not empty')
    draft.colors[id_] = color
    draft.first_colors.setdefault(id_, color)
