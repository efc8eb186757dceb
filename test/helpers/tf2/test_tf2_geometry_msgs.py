# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Transformed messages equal products of matrices (upstream's test_tf2_geometry_msgs.py)."""

from geometry_msgs.msg import (
    Point32,
    PointStamped,
    PolygonStamped,
    PoseStamped,
    PoseWithCovarianceStamped,
    Vector3Stamped,
    WrenchStamped,
)
import numpy as np
import pytest
from rclpy.time import Time
from scipy.spatial.transform import Rotation
from stamped_transforms import stamped
import tf2_geometry_msgs
import tf2_ros

TURN = Rotation.from_euler('xyz', [0.3, -1.2, 2.0])
OFFSET = np.array([1.0, 2.0, 3.0])
VECTOR = np.array([0.5, -0.25, 4.0])


@pytest.fixture
def buffer():
    """Return a buffer with a camera in a base."""
    buffer = tf2_ros.Buffer()
    buffer.set_transform_static(
        stamped('base', 'camera', 0.0, OFFSET, TURN.as_quat()), 'test')
    return buffer


def _message(kind):
    message = kind()
    message.header.frame_id = 'camera'
    message.header.stamp = Time(seconds=5).to_msg()
    return message


def _fill(part):
    part.x, part.y, part.z = VECTOR.tolist()


def _vector(part):
    return [part.x, part.y, part.z]


def test_points_and_free_vectors(buffer):
    """Points move and turn; vectors, forces and torques only turn."""
    point, vector, wrench = map(_message, (PointStamped, Vector3Stamped, WrenchStamped))
    for part in (point.point, vector.vector, wrench.wrench.torque):
        _fill(part)
    found = buffer.transform(point, 'base')
    assert (found.header.frame_id, found.header.stamp.sec) == ('base', 5)
    assert _vector(found.point) == pytest.approx(TURN.apply(VECTOR) + OFFSET)
    assert _vector(buffer.transform(vector, 'base').vector) == pytest.approx(TURN.apply(VECTOR))
    turned = buffer.transform(wrench, 'base').wrench
    assert _vector(turned.torque) == pytest.approx(TURN.apply(VECTOR))
    assert _vector(turned.force) == [0, 0, 0]
    assert _vector(point.point) == VECTOR.tolist()


def test_polygons(buffer):
    """Each of their points."""
    polygon = _message(PolygonStamped)
    polygon.polygon.points = [Point32(x=0.5, y=-0.25, z=4.0), Point32()]
    first, second = buffer.transform(polygon, 'base').polygon.points
    assert _vector(first) == pytest.approx(TURN.apply(VECTOR) + OFFSET, rel=1e-6)
    assert _vector(second) == pytest.approx(OFFSET)


def test_poses_and_covariances(buffer):
    """Both blocks of the covariance turn; there and back is the original."""
    pose = _message(PoseWithCovarianceStamped)
    _fill(pose.pose.pose.position)
    own = Rotation.from_euler('z', 2.5)
    orientation = pose.pose.pose.orientation
    orientation.x, orientation.y, orientation.z, orientation.w = own.as_quat().tolist()
    root = np.random.default_rng(1).random((6, 6))
    pose.pose.covariance = (root @ root.T).ravel()
    found = buffer.transform(pose, 'base')
    assert _vector(found.pose.pose.position) == pytest.approx(TURN.apply(VECTOR) + OFFSET)
    turned = found.pose.pose.orientation
    assert turned.w >= 0
    assert (Rotation.from_quat([turned.x, turned.y, turned.z, turned.w])
            * (TURN * own).inv()).magnitude() < 1e-9
    both = np.kron(np.eye(2), TURN.as_matrix())
    np.testing.assert_allclose(
        found.pose.covariance.reshape(6, 6), both @ root @ root.T @ both.T, atol=1e-12)
    back = buffer.transform(found, 'camera')
    assert _vector(back.pose.pose.position) == pytest.approx(VECTOR)
    np.testing.assert_allclose(back.pose.covariance, pose.pose.covariance, atol=1e-12)


def test_a_pose_without_orientation_is_not_turned(buffer):
    """Zeros, the default of old programs, stand for no rotation."""
    pose = _message(PoseStamped)
    pose.pose.orientation.w = 0.0
    found = buffer.transform(pose, 'base', new_type=PoseStamped).pose.orientation
    assert (Rotation.from_quat([found.x, found.y, found.z, found.w])
            * TURN.inv()).magnitude() < 1e-9


def test_the_functions_are_there_by_name(buffer):
    """As upstream exports them."""
    transform = buffer.lookup_transform('base', 'camera', Time())
    found = tf2_geometry_msgs.do_transform_pose_stamped(_message(PoseStamped), transform)
    assert _vector(found.pose.position) == pytest.approx(OFFSET)
