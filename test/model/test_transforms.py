"""Rotations: every representation is the same rotation."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest

from armsim_ros.model import transforms as tf

ANGLE = st.floats(-math.pi, math.pi)
QUICK = settings(max_examples=60, deadline=None)


@QUICK
@given(ANGLE, ANGLE, ANGLE)
def test_a_rotation_has_one_quaternion(roll, pitch, yaw):
    """Matrix to quaternion and back is the same matrix, w not below 0, wxyz too."""
    matrix = tf.matrix_from_rpy((roll, pitch, yaw))
    quat = tf.quat_xyzw_from_matrix(matrix)
    assert quat[3] >= 0.0
    assert np.linalg.norm(quat) == pytest.approx(1.0)
    assert tf.matrix_from_quat_xyzw(quat) == pytest.approx(matrix, abs=1e-12)
    assert tf.matrix_from_quat_wxyz(tf.quat_wxyz_from_matrix(matrix)) == pytest.approx(
        matrix, abs=1e-12)


@QUICK
@given(ANGLE, ANGLE | st.sampled_from([math.pi / 2, -math.pi / 2]), ANGLE)
def test_a_rotation_has_roll_pitch_and_yaw(roll, pitch, yaw):
    """Other angles may be found, of the same rotation."""
    matrix = tf.matrix_from_rpy((roll, pitch, yaw))
    assert tf.matrix_from_rpy(tf.rpy_from_matrix(matrix)) == pytest.approx(matrix, abs=1e-8)


@QUICK
@given(ANGLE, ANGLE, ANGLE, ANGLE)
def test_an_inverse_undoes(roll, pitch, yaw, x):
    """A pose times its inverse is the identity."""
    pose = tf.pose_matrix((x, 2.0, 3.0), (roll, pitch, yaw))
    assert pose @ tf.inverse_pose(pose) == pytest.approx(np.eye(4), abs=1e-9)


@pytest.mark.parametrize(('rpy', 'image'), [
    ((math.pi / 2, 0, 0), (0, 0, 1)), ((0, math.pi / 2, 0), (0, 1, 0)),
    ((0, 0, math.pi / 2), (-1, 0, 0)),
])
def test_the_sense_of_turning(rpy, image):
    """Rotations are right handed: where y goes."""
    assert tf.matrix_from_rpy(rpy) @ (0, 1, 0) == pytest.approx(image, abs=1e-12)


def test_axis_angle_is_a_rotation_about_the_axis():
    """Rodrigues' formula agrees with yaw, and the angle between is the angle."""
    turned = tf.matrix_from_axis_angle((0, 0, 1), 0.7)
    assert turned == pytest.approx(tf.matrix_from_rpy((0, 0, 0.7)))
    assert tf.rotation_angle(np.eye(3), turned) == pytest.approx(0.7)
    assert tf.rotation_vector(turned) == pytest.approx((0, 0, 0.7))


@pytest.mark.parametrize('quat', [(0, 0, 0, 0), (math.nan, 0, 0, 1), (math.inf, 0, 0, 1)])
def test_no_rotation(quat):
    """A quaternion without length, or not finite, is refused."""
    with pytest.raises(ValueError, match='quaternion'):
        tf.matrix_from_quat_xyzw(quat)
