# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit_msgs/msg/PlanningScene`` to plain values, and back."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntFlag

from geometry_msgs.msg import TransformStamped, Vector3
from moveit_msgs.msg import (
    AllowedCollisionEntry,
    AllowedCollisionMatrix,
    LinkPadding,
    LinkScale,
    ObjectColor,
    PlanningSceneComponents,
    PlanningSceneWorld,
    RobotState,
)
from moveit_msgs.msg import PlanningScene as PlanningSceneMessage
from sensor_msgs.msg import JointState, MultiDOFJointState
from std_msgs.msg import ColorRGBA

from armsim_ros.arrays import Matrix
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.nodes.conversions.collision_object import (
    attached_from_message,
    object_from_message,
    object_to_message,
)
from armsim_ros.nodes.conversions.geometry import pose_from_transform, pose_to_message
from armsim_ros.nodes.conversions.motion_plan_request import (
    readable,
    robot_state_to_message,
    start_state_from_message,
)
from armsim_ros.nodes.conversions.octomap import octomap_to_message, readable_octomap
from armsim_ros.planning.scene.allowed_collision_matrix import AcmUpdate
from armsim_ros.planning.scene.content import further_frames
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import SceneUpdate


class Component(IntFlag):
    """Bits of ``moveit_msgs/msg/PlanningSceneComponents``."""

    SCENE_SETTINGS = PlanningSceneComponents.SCENE_SETTINGS
    ROBOT_STATE = PlanningSceneComponents.ROBOT_STATE
    ATTACHED_OBJECTS = PlanningSceneComponents.ROBOT_STATE_ATTACHED_OBJECTS
    WORLD_OBJECT_NAMES = PlanningSceneComponents.WORLD_OBJECT_NAMES
    WORLD_OBJECT_GEOMETRY = PlanningSceneComponents.WORLD_OBJECT_GEOMETRY
    OCTOMAP = PlanningSceneComponents.OCTOMAP
    TRANSFORMS = PlanningSceneComponents.TRANSFORMS
    ALLOWED_COLLISION_MATRIX = PlanningSceneComponents.ALLOWED_COLLISION_MATRIX
    LINK_PADDING_AND_SCALING = PlanningSceneComponents.LINK_PADDING_AND_SCALING
    OBJECT_COLORS = PlanningSceneComponents.OBJECT_COLORS
    ALL = 1023


def update_from_message(message: PlanningSceneMessage, model_frame: str) -> SceneUpdate:
    """
    Return what a scene message asks for.

    :param model_frame: fixed transforms lead to it.
    """
    objects, bad_objects = readable(object_from_message, message.world.collision_objects)
    frames, bad_frames = readable(
        lambda item: _fixed_frame(item, model_frame), message.fixed_frame_transforms)
    octomap, bad_octomap = readable_octomap(message.world.octomap, is_diff=bool(message.is_diff))
    return SceneUpdate(
        is_diff=bool(message.is_diff),
        name=message.name,
        robot_state=start_state_from_message(message.robot_state, attached_from_message),
        objects=objects,
        acm=_acm_update(message.allowed_collision_matrix),
        link_padding={item.link_name: float(item.padding) for item in message.link_padding},
        link_scale={item.link_name: float(item.scale) for item in message.link_scale},
        fixed_frames=dict(frames),
        object_colors={
            item.id: (
                float(item.color.r), float(item.color.g), float(item.color.b), float(item.color.a))
            for item in message.object_colors},
        octomap=octomap,
        unreadable=(*bad_frames, *bad_objects, *bad_octomap))


def world_from_message(message: PlanningSceneWorld) -> SceneUpdate:
    """Return the update that puts a message's objects and map in the place of all others."""
    objects, unreadable = readable(object_from_message, message.collision_objects)
    octomap, bad_octomap = readable_octomap(message.octomap, is_diff=False)
    return SceneUpdate(objects=objects, replaces_world=True, octomap=octomap,
                       unreadable=(*unreadable, *bad_octomap))


def is_empty(message: PlanningSceneMessage) -> bool:
    """Return whether a scene message has no content; colours do not count."""
    world, state = message.world, message.robot_state
    return not (
        message.name
        or message.fixed_frame_transforms
        or message.allowed_collision_matrix.entry_names
        or message.link_padding
        or message.link_scale
        or world.collision_objects
        or world.octomap.octomap.data
    ) and state == RobotState(
        is_diff=True, joint_state=JointState(header=state.joint_state.header),
        multi_dof_joint_state=MultiDOFJointState(header=state.multi_dof_joint_state.header))


def _fixed_frame(message: TransformStamped, model_frame: str) -> tuple[str, Matrix]:
    """Return name and pose (4, 4) of the frame that a transform to the model frame describes."""
    name, target = message.header.frame_id, message.child_frame_id
    if target.removeprefix('/') != model_frame.removeprefix('/'):
        raise PlanningError(
            MoveItErrorCode.FRAME_TRANSFORM_FAILURE,
            f"the fixed transform of frame '{name}' has the child frame '{target}'; a frame is "
            f"described by a transform with header.frame_id '{name}', child_frame_id "
            f"'{model_frame}' and the frame's pose in '{model_frame}'",
            'planning scene')
    if not name:
        raise PlanningError(
            MoveItErrorCode.FRAME_TRANSFORM_FAILURE,
            'a fixed transform has no frame name in header.frame_id', 'planning scene')
    return name, pose_from_transform(message.transform)


def scene_to_message(
    scene: PlanningScene, components: Component = Component.ALL
) -> PlanningSceneMessage:
    """
    Return a full scene (is_diff false) with the components asked for.

    Geometry wins over names; attached objects come with the joints, joints may come alone.
    """
    content = scene.snapshot()
    message = PlanningSceneMessage(is_diff=False)
    message.robot_state.is_diff = False
    if components & Component.SCENE_SETTINGS:
        message.name = content.content.name
        message.robot_model_name = content.robot.name
    if components & (Component.ROBOT_STATE | Component.ATTACHED_OBJECTS):
        attached = content.attached.values() if components & Component.ATTACHED_OBJECTS else ()
        message.robot_state = robot_state_to_message(
            content.kinematic_model.positions(content.q), content.model_frame, attached=attached)
    if components & (Component.WORLD_OBJECT_NAMES | Component.WORLD_OBJECT_GEOMETRY):
        geometry = bool(components & Component.WORLD_OBJECT_GEOMETRY)
        message.world.collision_objects = [
            object_to_message(item, content.model_frame, geometry=geometry)
            for item in content.objects.values()]
    if components & Component.OCTOMAP:
        message.world.octomap = octomap_to_message(content.octomap, content.model_frame)
    if components & Component.TRANSFORMS:
        message.fixed_frame_transforms = transforms(content)
    if components & Component.ALLOWED_COLLISION_MATRIX:
        message.allowed_collision_matrix = acm_to_message(content.acm.to_update())
    if components & Component.LINK_PADDING_AND_SCALING:
        message.link_padding = paddings(content.link_padding)
        message.link_scale = scales(content.link_scale)
    if components & Component.OBJECT_COLORS:
        message.object_colors = colors(content.colors)
    return message


def acm_to_message(acm: AcmUpdate | None) -> AllowedCollisionMatrix:
    """Return the matrix in the form of its message."""
    if acm is None:
        return AllowedCollisionMatrix()
    return AllowedCollisionMatrix(
        entry_names=list(acm.entry_names),
        entry_values=[AllowedCollisionEntry(enabled=list(row)) for row in acm.entry_values],
        default_entry_names=list(acm.default_entry_names),
        default_entry_values=list(acm.default_entry_values))


def paddings(values: Mapping[str, float]) -> list[LinkPadding]:
    """Return link -> padding [m] as messages."""
    return [LinkPadding(link_name=link, padding=value) for link, value in values.items()]


def scales(values: Mapping[str, float]) -> list[LinkScale]:
    """Return link -> scale as messages."""
    return [LinkScale(link_name=link, scale=value) for link, value in values.items()]


def colors(values: Mapping[str, tuple[float, float, float, float]]) -> list[ObjectColor]:
    """Return object -> rgba as messages."""
    return [
        ObjectColor(id=name, color=ColorRGBA(r=r, g=g, b=b, a=a))
        for name, (r, g, b, a) in values.items()]


def _acm_update(message: AllowedCollisionMatrix) -> AcmUpdate | None:
    if not message.entry_names and not message.entry_values and not message.default_entry_names:
        return None
    return AcmUpdate(
        entry_names=tuple(message.entry_names),
        entry_values=tuple(tuple(map(bool, row.enabled)) for row in message.entry_values),
        default_entry_names=tuple(message.default_entry_names),
        default_entry_values=tuple(map(bool, message.default_entry_values)))


def transforms(scene: PlanningScene) -> list[TransformStamped]:
    """Return the poses of further frames in the model frame, and of that itself, as messages."""
    messages = []
    for frame in dict.fromkeys((scene.model_frame, *further_frames(scene.content))):
        if not scene.has_frame(frame):
            continue  # its chain of transforms leads to no link
        message = TransformStamped(child_frame_id=scene.model_frame)
        message.header.frame_id = frame
        flat = pose_to_message(scene.frame_pose(frame))
        message.transform.translation = Vector3(
            x=flat.position.x, y=flat.position.y, z=flat.position.z)
        message.transform.rotation = flat.orientation
        messages.append(message)
    return messages
