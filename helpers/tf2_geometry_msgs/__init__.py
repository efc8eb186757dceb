# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Transforms messages of geometry_msgs, and registers how with tf2_ros when imported."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

from geometry_msgs.msg import (
    Point32,
    PointStamped,
    PolygonStamped,
    Pose,
    PoseStamped,
    PoseWithCovarianceStamped,
    TransformStamped,
    Vector3Stamped,
    WrenchStamped,
)
import numpy as np
import numpy.typing as npt
from tf2_ros import ConvertRegistration, TransformRegistration

Array = npt.NDArray[np.float64]


def do_transform_point(point: PointStamped, transform: TransformStamped) -> PointStamped:
    """Return a point in the transform's frame."""
    result = PointStamped(header=transform.header)
    _set(result.point, _moved(point.point, transform))
    return result


def do_transform_vector3(vector3: Vector3Stamped, transform: TransformStamped) -> Vector3Stamped:
    """Return a free vector in the transform's frame: it is rotated only."""
    result = Vector3Stamped(header=transform.header)
    _set(result.vector, _rotated(vector3.vector, transform))
    return result


def do_transform_pose(pose: Pose, transform: TransformStamped) -> Pose:
    """Return a pose in the transform's frame."""
    result = Pose()
    _set(result.position, _moved(pose.position, transform))
    x, y, z, w = _quaternion(transform.transform.rotation)
    a, b, c, d = _quaternion(pose.orientation)
    product = np.array([
        w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a,
        w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c])
    numbers = (product if product[3] >= 0 else -product).tolist()
    orientation = result.orientation
    orientation.x, orientation.y, orientation.z, orientation.w = numbers
    return result


def do_transform_pose_stamped(pose: PoseStamped, transform: TransformStamped) -> PoseStamped:
    """Return a stamped pose in the transform's frame."""
    return PoseStamped(header=transform.header, pose=do_transform_pose(pose.pose, transform))


def do_transform_pose_with_covariance_stamped(
        pose: PoseWithCovarianceStamped,
        transform: TransformStamped) -> PoseWithCovarianceStamped:
    """Return a stamped pose and its covariance in the transform's frame."""
    result = PoseWithCovarianceStamped(header=transform.header)
    result.pose.pose = do_transform_pose(pose.pose.pose, transform)
    result.pose.covariance = transform_covariance(pose.pose.covariance, transform)
    return result


def do_transform_polygon_stamped(
        polygon: PolygonStamped, transform: TransformStamped) -> PolygonStamped:
    """Return a polygon in the transform's frame."""
    result = PolygonStamped(header=transform.header)
    points = []
    for point in polygon.polygon.points:
        points.append(Point32())
        _set(points[-1], _moved(point, transform))
    result.polygon.points = points
    return result


def do_transform_wrench_stamped(
        wrench: WrenchStamped, transform: TransformStamped) -> WrenchStamped:
    """Return force and torque in the transform's frame: both are rotated only, as tf2 does."""
    result = WrenchStamped(header=transform.header)
    _set(result.wrench.force, _rotated(wrench.wrench.force, transform))
    _set(result.wrench.torque, _rotated(wrench.wrench.torque, transform))
    return result


def transform_covariance(cov_in: Any, transform: TransformStamped) -> Any:
    """
    Return a covariance of translation and rotation in the transform's frame.

    :param cov_in: 36 numbers, row by row.
    """
    rotation = np.kron(np.eye(2), _matrix(transform))
    return (rotation @ np.reshape(cov_in, (6, 6)) @ rotation.T).ravel()


def _quaternion(message: Any) -> Array:
    """Return x, y, z, w with length 1; zeros mean no rotation."""
    quaternion = np.array([message.x, message.y, message.z, message.w])
    length = float(np.linalg.norm(quaternion))
    return quaternion / length if length > 0 else np.array([0.0, 0.0, 0.0, 1.0])


def _matrix(transform: TransformStamped) -> Array:
    x, y, z, w = _quaternion(transform.transform.rotation)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def _rotated(vector: Any, transform: TransformStamped) -> Array:
    result: Array = _matrix(transform) @ (vector.x, vector.y, vector.z)
    return result


def _moved(point: Any, transform: TransformStamped) -> Array:
    offset = transform.transform.translation
    return np.add(_rotated(point, transform), [offset.x, offset.y, offset.z])


def _set(message: Any, vector: Array) -> None:
    message.x, message.y, message.z = vector.tolist()


for _type, _function in (
        (PointStamped, do_transform_point),
        (Vector3Stamped, do_transform_vector3),
        (PoseStamped, do_transform_pose_stamped),
        (PoseWithCovarianceStamped, do_transform_pose_with_covariance_stamped),
        (PolygonStamped, do_transform_polygon_stamped),
        (WrenchStamped, do_transform_wrench_stamped)):
    TransformRegistration().add(_type, _function)
    ConvertRegistration().add_to_msg(_type, deepcopy)
    ConvertRegistration().add_from_msg(_type, deepcopy)
