# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects of a planning scene, in the world or on a link, and whether they can be used."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
import math
from types import MappingProxyType

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.model.geometry import Geometry, LARGEST, shape_fault
from armsim_ros.model.transforms import pose_from_quat_xyzw
from armsim_ros.trajectory import JointTrajectory

#: By how much the axes of a rotation may fail to be of length 1 and square to each other.
ROTATION_TOLERANCE = 1e-4
#: The id that octomaps have in messages; no other object may have it.
OCTOMAP_ID = '<octomap>'

_IDENTITY = np.eye(3)


class ObjectOperation(IntEnum):
    """Constants of ``moveit_msgs/msg/CollisionObject``."""

    ADD = 0
    REMOVE = 1
    APPEND = 2
    MOVE = 3


@dataclass(frozen=True, slots=True)
class ObjectType:
    """Content of ``object_recognition_msgs/msg/ObjectType``: a key in a data base."""

    key: str = ''
    db: str = ''

    @property
    def empty(self) -> bool:
        """Whether no type is given."""
        return not (self.key or self.db)


def _identity() -> Matrix:
    return np.eye(4)


@dataclass(frozen=True, slots=True, eq=False)
class ObjectShape:
    """A shape and its pose (4, 4) in the frame of the object that it belongs to."""

    geometry: Geometry
    pose: Matrix = field(default_factory=_identity)


@dataclass(frozen=True, slots=True, eq=False)
class CollisionObject:
    """
    A rigid object, or an operation on an object; immutable, an edit makes a new object.

    The content of ``moveit_msgs/msg/CollisionObject``. What a scene holds is an ADD whose pose is
    in the model frame, or in a link's frame while attached.

    :param id: unique in the world.
    :param operation: a value of :class:`ObjectOperation`.
    :param frame_id: frame of ``pose``; '' is the model frame.
    :param pose: (4, 4); ADD and APPEND read the identity as not given.
    :param shapes: at least one in ADD and APPEND; no others read them.
    :param subframes: name -> pose (4, 4) in the object's frame.
    :param shape_poses: poses (4, 4) that a MOVE gives to the shapes, in their order; empty where
        the shapes stay as they are in the object's frame.
    """

    id: str
    operation: int = ObjectOperation.ADD
    frame_id: str = ''
    pose: Matrix = field(default_factory=_identity)
    shapes: tuple[ObjectShape, ...] = ()
    subframes: Mapping[str, Matrix] = field(default_factory=lambda: MappingProxyType({}))
    type: ObjectType = field(default_factory=ObjectType)
    shape_poses: tuple[Matrix, ...] = ()

    def at(self, pose: Matrix, frame_id: str = '') -> CollisionObject:
        """Return the object as a scene holds it at another pose (4, 4)."""
        return replace(self, operation=ObjectOperation.ADD, frame_id=frame_id, pose=pose,
                       shape_poses=())


@dataclass(frozen=True, slots=True, eq=False)
class AttachedObject:
    """
    An object that moves with a link, or an operation on an object; immutable.

    The content of ``moveit_msgs/msg/AttachedCollisionObject``.

    :param link_name: the link that carries it.
    :param touch_links: links and attached objects that it may touch, as the client gave them;
        the carrying link itself is only exempt when it is named here.
    :param detach_posture: kept for the client, not used.
    :param weight: [kg] kept for the client, not used.
    """

    link_name: str
    object: CollisionObject
    touch_links: tuple[str, ...] = ()
    detach_posture: JointTrajectory = field(default_factory=lambda: JointTrajectory(()))
    weight: float = 0.0

    @property
    def id(self) -> str:
        """The object's id."""
        return self.object.id


def object_error(message: str) -> PlanningError:
    """Return the error for an object that the scene cannot take."""
    return PlanningError(MoveItErrorCode.INVALID_OBJECT_NAME, message, 'planning scene')


def check_pose(pose: Matrix, what: str) -> Matrix:
    """
    Return a pose (4, 4) of its own, or refuse it.

    :param what: names the pose in the error.
    :raises PlanningError: INVALID_OBJECT_NAME.
    """
    matrix = np.array(pose, dtype=np.float64)
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        raise object_error(f'{what} is not a pose of finite numbers')
    rotation = matrix[:3, :3]
    off = np.abs(rotation @ rotation.T - _IDENTITY).max()
    if off > ROTATION_TOLERANCE or np.linalg.det(rotation) < 0.0:
        raise object_error(f'{what} has a part that is not a rotation')
    if np.abs(matrix[:3, 3]).max() > LARGEST:
        far = ', '.join(f'{value:g}' for value in matrix[:3, 3])
        raise object_error(f'{what} lies too far away: ({far}) m; allowed: {LARGEST:g} m')
    return matrix


def checked_shape(shape: ObjectShape, what: str) -> ObjectShape:
    """
    Return a shape with a pose of its own, or refuse it.

    :param what: names the shape in the error.
    :raises PlanningError: INVALID_OBJECT_NAME.
    """
    fault = shape_fault(shape.geometry)
    if fault:
        raise object_error(f'{what}: {fault}')
    return ObjectShape(shape.geometry, check_pose(shape.pose, f'the pose of {what}'))


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
            MoveItErrorCode.FAILURE, f'a pose has a number that is not finite: {values}')
    if not any(quat_xyzw):
        quat_xyzw = (0.0, 0.0, 0.0, 1.0)
    largest = max(abs(part) for part in quat_xyzw)
    return pose_from_quat_xyzw(xyz, [part / largest for part in quat_xyzw])
