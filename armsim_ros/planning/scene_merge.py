# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Scene messages and start states laid over a content."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
import math
from types import MappingProxyType

from armsim_ros.errors import nearest, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.allowed_collision_matrix import AllowedCollisionMatrix
from armsim_ros.planning.attach_operations import apply_attached
from armsim_ros.planning.error_codes import MoveItErrorCode
from armsim_ros.planning.object_checks import check_pose, object_error
from armsim_ros.planning.object_operations import apply_object
from armsim_ros.planning.request import StartState
from armsim_ros.planning.scene_content import SceneContent
from armsim_ros.planning.scene_update import (
    AttachedObjectUpdate,
    CollisionObjectUpdate,
    ObjectOperation,
    SceneUpdate,
)


def merged_content(
    kinematics: KinematicModel, content: SceneContent, update: SceneUpdate, initial: SceneContent
) -> tuple[SceneContent, tuple[str, ...]]:
    """
    Return the content after a scene message, and a sentence for each refused operation.

    Every operation is tried; one that is refused has no effect and does not stop the others.

    :param initial: what a message that is no difference starts from; its allowed collision
        matrix stays where such a message gives none.
    """
    refusals: list[str] = []
    before = content
    if not update.is_diff:
        keep = content.attached if update.robot_state.is_diff else initial.attached
        content = replace(initial, q=content.q, attached=keep, frames=content.frames)
        before = content

    def attempt(step: Callable[[SceneContent], SceneContent]) -> None:
        nonlocal content
        try:
            content = step(content)
        except PlanningError as error:
            refusals.append(str(error))

    if update.name:
        content = replace(content, name=update.name)
    if update.fixed_frames:
        attempt(lambda now: _with_frames(now, update))
    if update.robot_state.joint_names or update.robot_state.positions:
        attempt(lambda now: _with_joints(kinematics, now, update.robot_state))
        if not update.robot_state.is_diff:
            content = replace(content, attached=initial.attached)
    for attached in update.robot_state.attached_objects:
        attempt(partial(_attached, kinematics, attached))
    acm = update.acm
    if acm is not None and (acm.entry_names or acm.entry_values):
        attempt(lambda now: replace(now, acm=AllowedCollisionMatrix.from_update(acm)))
    if update.link_padding:
        attempt(lambda now: _with_padding(kinematics, now, update.link_padding))
    if update.link_scale:
        attempt(lambda now: _with_scale(kinematics, now, update.link_scale))
    if update.object_colors:
        attempt(lambda now: _with_colors(now, update))
    for item in update.objects:
        taken = item.id in before.objects and item.id not in content.objects
        if item.operation == ObjectOperation.REMOVE and taken and item.id in content.attached:
            continue  # the same message has attached it
        attempt(partial(_object, kinematics, item))
    return content, tuple(refusals)


def with_start_state(
    kinematics: KinematicModel, content: SceneContent, start: StartState, *, strict: bool
) -> SceneContent:
    """
    Return the content with a client's start state.

    :raises PlanningError: INVALID_ROBOT_STATE, or what an attached object is refused for.
    """
    content = _with_joints(kinematics, content, start)
    given = bool(start.joint_names or start.attached_objects)
    if strict and given and not start.is_diff:
        content = replace(content, attached=MappingProxyType({}))
    for attached in start.attached_objects:
        content = apply_attached(kinematics, content, attached)
    return content


def _attached(
    kinematics: KinematicModel, update: AttachedObjectUpdate, content: SceneContent
) -> SceneContent:
    return apply_attached(kinematics, content, update)


def _object(
    kinematics: KinematicModel, update: CollisionObjectUpdate, content: SceneContent
) -> SceneContent:
    return apply_object(kinematics, content, update)


def _with_joints(
    kinematics: KinematicModel, content: SceneContent, state: StartState
) -> SceneContent:
    names, positions = state.joint_names, state.positions
    if len(names) != len(positions):
        raise PlanningError(
            MoveItErrorCode.INVALID_ROBOT_STATE,
            f'the robot state has {len(names)} joint names but {len(positions)} positions',
            'planning scene',
        )
    if not names:
        return content
    q = kinematics.vector(dict(zip(names, positions, strict=True)), content.q)
    q.setflags(write=False)
    return replace(content, q=q)


def _with_frames(content: SceneContent, update: SceneUpdate) -> SceneContent:
    added = {
        name.lstrip('/'): check_pose(pose, f"the pose of frame '{name}'")
        for name, pose in update.fixed_frames.items()
        if name.lstrip('/')
    }
    return replace(content, frames=MappingProxyType({**content.frames, **added}))


def _with_padding(
    kinematics: KinematicModel, content: SceneContent, padding: Mapping[str, float]
) -> SceneContent:
    for link, value in padding.items():
        _check_link(kinematics, link, 'padding')
        if not (math.isfinite(value) and value >= 0.0):
            raise object_error(f"padding {value} m of link '{link}'; allowed: 0 or more")
    known = MappingProxyType({**content.link_padding, **padding})
    return replace(content, link_padding=known)


def _with_scale(
    kinematics: KinematicModel, content: SceneContent, scale: Mapping[str, float]
) -> SceneContent:
    for link, value in scale.items():
        _check_link(kinematics, link, 'scale')
        if not (math.isfinite(value) and value > 0.0):
            raise object_error(f"scale {value} of link '{link}'; allowed: above 0")
    return replace(content, link_scale=MappingProxyType({**content.link_scale, **scale}))


def _check_link(kinematics: KinematicModel, link: str, what: str) -> None:
    if not kinematics.has_link(link):
        known = tuple(kinematics.robot.links)
        raise PlanningError(
            MoveItErrorCode.INVALID_LINK_NAME,
            f"{what} is given for link '{link}', which robot '{kinematics.robot.name}' does "
            f'not have {nearest(link, known)}'.rstrip(),
            'planning scene',
        )


def _with_colors(content: SceneContent, update: SceneUpdate) -> SceneContent:
    for id_, color in update.object_colors.items():
        if not all(math.isfinite(part) and 0.0 <= part <= 1.0 for part in color):
            raise object_error(f"color {color} of object '{id_}'; allowed: 0 to 1 for r, g, b, a")
    known = MappingProxyType({**content.colors, **update.object_colors})
    return replace(content, colors=known)
