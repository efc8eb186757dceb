# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a client may ask of a planning scene: the content of its messages as plain values.

Values stand as the client gave them; what is wrong with them is found where they are used.
Poses are (4, 4); :func:`message_pose` makes one from a message's numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
import math

from armsim_ros.arrays import Matrix
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.geometry import Geometry, Mesh, Plane
from armsim_ros.model.transforms import pose_from_quat_xyzw
from armsim_ros.planning.scene.world_object import ObjectType
from armsim_ros.trajectory import JointTrajectory

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


class ObjectOperation(IntEnum):
    """Constants of ``moveit_msgs/msg/CollisionObject``."""

    ADD = 0
    REMOVE = 1
    APPEND = 2
    MOVE = 3


@dataclass(frozen=True, slots=True, eq=False)
class CollisionObjectUpdate:
    """
    Content of ``moveit_msgs/msg/CollisionObject``.

    :param operation: a value of :class:`ObjectOperation`.
    :param frame_id: frame of ``pose``; '' is the model frame.
    :param pose: (4, 4) of the object, None or identity where it is not given.
    :param primitive_poses: (4, 4) each in the object's frame; missing ones are identity.
    """

    id: str
    operation: int = ObjectOperation.ADD
    frame_id: str = ''
    pose: Matrix | None = None
    primitives: tuple[Geometry, ...] = ()
    primitive_poses: tuple[Matrix, ...] = ()
    meshes: tuple[Mesh, ...] = ()
    mesh_poses: tuple[Matrix, ...] = ()
    planes: tuple[Plane, ...] = ()
    plane_poses: tuple[Matrix, ...] = ()
    subframes: Mapping[str, Matrix] = field(default_factory=dict)
    type: ObjectType = field(default_factory=ObjectType)

    @property
    def has_shapes(self) -> bool:
        """Whether the client gave any geometry."""
        return bool(self.primitives or self.meshes or self.planes)


@dataclass(frozen=True, slots=True, eq=False)
class AttachedObjectUpdate:
    """Content of ``moveit_msgs/msg/AttachedCollisionObject``."""

    link_name: str
    object: CollisionObjectUpdate
    touch_links: tuple[str, ...] = ()
    detach_posture: JointTrajectory = field(default_factory=lambda: JointTrajectory(()))
    weight: float = 0.0


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
    attached_objects: tuple[AttachedObjectUpdate, ...] = ()
    velocities: tuple[float, ...] = ()

    @classmethod
    def from_positions(cls, positions: Mapping[str, float]) -> StartState:
        """Return the monitored state with these joints [rad or m] laid over it."""
        return cls(tuple(positions), tuple(positions.values()))


@dataclass(frozen=True, slots=True)
class AcmUpdate:
    """
    Content of ``moveit_msgs/msg/AllowedCollisionMatrix``.

    :param entry_names: n names of links and objects.
    :param entry_values: n rows of n booleans, True where the two may touch.
    """

    entry_names: tuple[str, ...] = ()
    entry_values: tuple[tuple[bool, ...], ...] = ()
    default_entry_names: tuple[str, ...] = ()
    default_entry_values: tuple[bool, ...] = ()


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
    objects: tuple[CollisionObjectUpdate, ...] = ()
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


def message_pose(xyz: Sequence[float], quat_xyzw: Sequence[float]) -> Matrix:
    """
    Return the pose (4, 4) of a message; an all-zero quaternion means no rotation.

    :param xyz: (3,) [m].
    :param quat_xyzw: (4,), of any length above 0; it is normalized.
    :raises PlanningError: FAILURE for a number that is not finite.
    """
    values = [*xyz, *quat_xyzw]
    if not all(math.isfinite(value) for value in values):
        raise PlanningError(
            MoveItErrorCode.FAILURE, f'a pose has a number that is not finite: {values}'
        )
    if not any(quat_xyzw):
        quat_xyzw = (0.0, 0.0, 0.0, 1.0)
    largest = max(abs(part) for part in quat_xyzw)
    return pose_from_quat_xyzw(xyz, [part / largest for part in quat_xyzw])
