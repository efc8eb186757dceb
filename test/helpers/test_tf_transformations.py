# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""tf_transformations against scipy's rotations and numbers of its documentation."""

from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp
import tf_transformations as tf

AXES = [frame + ''.join(letters) for frame in 'sr' for letters in product('xyz', repeat=3)
        if letters[0] != letters[1] != letters[2]]


@pytest.mark.parametrize('axes', AXES)
def test_all_euler_conventions(axes):
    """Static axes are scipy's small letters, turning ones its capitals."""
    assert len(AXES) == 24
    random = np.random.default_rng(7)
    for angles in random.uniform(-3, 3, (20, 3)):
        expected = Rotation.from_euler(
            axes[1:] if axes[0] == 's' else axes[1:].upper(), angles).as_matrix()
        np.testing.assert_allclose(tf.euler_matrix(*angles, axes)[:3, :3], expected, atol=1e-12)
        quaternion = tf.quaternion_from_euler(*angles, axes)
        np.testing.assert_allclose(
            Rotation.from_quat(quaternion).as_matrix(), expected, atol=1e-12)
        back = tf.euler_from_quaternion(quaternion, axes)
        np.testing.assert_allclose(tf.euler_matrix(*back, axes)[:3, :3], expected, atol=1e-12)


@pytest.mark.parametrize('axes', AXES)
@pytest.mark.parametrize('sign', [-1, 1])
def test_at_a_singularity_the_matrix_is_the_same(axes, sign):
    """Two of the angles turn about the same axis there; one of them is 0."""
    middle = (0.0 if sign < 0 else np.pi) if axes[1] == axes[3] else sign * np.pi / 2
    expected = tf.euler_matrix(0.3, middle, -0.4, axes)
    angles = tf.euler_from_matrix(expected, axes)
    np.testing.assert_allclose(tf.euler_matrix(*angles, axes), expected, atol=1e-7)


def test_published_numbers():
    """Examples of the original's docstrings."""
    assert tf.quaternion_from_euler(1, 2, 3, 'ryxz') == pytest.approx(
        (0.310622, -0.718287, 0.444435, 0.435953), abs=1e-6)
    assert tf.quaternion_about_axis(0.123, (1, 0, 0)) == pytest.approx(
        (0.06146124, 0, 0, 0.99810947))
    assert tf.quaternion_multiply([1, -2, 3, 4], [-5, 6, 7, 8]) == (-44, -14, 48, 28)
    np.testing.assert_allclose(
        tf.quaternion_matrix([0.06146124, 0, 0, 0.99810947]), tf.rotation_matrix(0.123, (1, 0, 0)))


def test_quaternions_and_matrices_are_inverse_of_each_other():
    """The quaternion has w not negative, for half turns as well."""
    for quaternion in [*Rotation.random(50, random_state=1).as_quat(), (1, 0, 0, 0), (0, 1, 0, 0)]:
        matrix = tf.quaternion_matrix(quaternion)
        found = tf.quaternion_from_matrix(matrix)
        assert found[3] >= 0
        np.testing.assert_allclose(tf.quaternion_matrix(found), matrix, atol=1e-12)
        np.testing.assert_allclose(tf.quaternion_multiply(
            np.multiply(quaternion, 2), tf.quaternion_inverse(np.multiply(quaternion, 2))),
            (0, 0, 0, 1), atol=1e-12)


def test_slerp():
    """The shortest path is scipy's; the ends are the quaternions themselves."""
    rotations = Rotation.random(20, random_state=2)
    for first, second in zip(rotations[:10], rotations[10:], strict=True):
        ends = first.as_quat(), second.as_quat()
        expected = Slerp([0, 1], Rotation.concatenate([first, second]))(0.3)
        found = Rotation.from_quat(tf.quaternion_slerp(*ends, 0.3))
        assert (found * expected.inv()).magnitude() < 1e-9
        np.testing.assert_allclose(tf.quaternion_slerp(*ends, 0.0), ends[0])
        np.testing.assert_allclose(tf.quaternion_slerp(*ends, 1.0), ends[1])


def test_matrices():
    """Rotation about a point, scaling, reflection, products and inverses."""
    turn = tf.rotation_matrix(np.pi / 2, (0, 0, 1), (1, 0, 0))
    np.testing.assert_allclose(turn @ (0, 0, 0, 1), (1, -1, 0, 1), atol=1e-12)
    np.testing.assert_allclose(tf.scale_matrix(-2, (1, 1, 1)) @ (0, 0, 0, 1), (3, 3, 3, 1))
    np.testing.assert_allclose(
        tf.reflection_matrix((0, 0, 1), (0, 0, 2)) @ (5, 6, 3, 1), (5, 6, -1, 1))
    moved = tf.concatenate_matrices(tf.translation_matrix((1, 2, 3)), turn)
    assert tf.translation_from_matrix(tf.translation_matrix((1, 2, 3))).tolist() == [1, 2, 3]
    assert tf.is_same_transform(moved @ tf.inverse_matrix(moved), tf.identity_matrix())
    assert not tf.is_same_transform(moved, turn)
    assert tf.vector_norm([[3, 4], [0, 2]], axis=1).tolist() == [5, 2]
    assert tf.unit_vector([0, 3, 4]) == pytest.approx([0, 0.6, 0.8])
    assert tf.vector_norm(tf.random_quaternion()) == pytest.approx(1)
    assert np.linalg.det(tf.random_rotation_matrix([0.1, 0.2, 0.3])) == pytest.approx(1)


@pytest.mark.parametrize('angle', [0.0, 0.5, -2.0, np.pi])
def test_a_rotation_is_taken_apart(angle):
    """Angle, axis and a point on it make the same matrix; a screw has no such point."""
    turn = tf.rotation_matrix(angle, (1, 2, -3), (0.5, -1, 2))
    found, axis, point = tf.rotation_from_matrix(turn)
    assert point.shape == (4,)
    np.testing.assert_allclose(tf.rotation_matrix(found, axis, point), turn, atol=1e-9)
    with pytest.raises(ValueError, match='kind'):
        tf.rotation_from_matrix(tf.translation_matrix((1, 2, -3)) @ turn)
    with pytest.raises(ValueError, match='kind'):
        tf.rotation_from_matrix(tf.scale_matrix(2.0))


@pytest.mark.parametrize('factor', [-1.0, -0.3, 0.0, 1.0, 2.5])
@pytest.mark.parametrize('direction', [None, (1, 2, -3)])
def test_a_scaling_is_taken_apart(factor, direction):
    """Factor, origin and direction make the same matrix."""
    scaled = tf.scale_matrix(factor, (0.5, -1, 2), direction)
    np.testing.assert_allclose(tf.scale_matrix(*tf.scale_from_matrix(scaled)), scaled, atol=1e-9)
    with pytest.raises(ValueError, match='kind'):
        tf.scale_from_matrix(tf.rotation_matrix(0.3, (1, 0, 0)))


def test_a_reflection_is_taken_apart():
    """A point of the plane and its normal make the same matrix."""
    mirror = tf.reflection_matrix((0.5, -1, 2), (1, 2, -3))
    np.testing.assert_allclose(
        tf.reflection_matrix(*tf.reflection_from_matrix(mirror)), mirror, atol=1e-9)
    with pytest.raises(ValueError, match='reflection'):
        tf.reflection_from_matrix(tf.scale_matrix(-1.0))


@pytest.mark.parametrize('mirror', [1.0, -1.0])
def test_a_matrix_is_composed_and_decomposed(mirror):
    """A point is sheared, scaled, turned and moved, in this order."""
    parts = {'scale': (2.0 * mirror, 3.0, 4.0), 'shear': (0.2, 0.1, 0.3),
             'angles': (0.4, -0.5, 0.6), 'translate': (20, 30, 40)}
    matrix = tf.compose_matrix(**parts)
    sheared = np.array([[1, 0.2, 0.1], [0, 1, 0.3], [0, 0, 1]]) @ (1, 2, 3)
    turned = Rotation.from_euler('xyz', parts['angles']).apply(sheared * parts['scale'])
    np.testing.assert_allclose(matrix @ (1, 2, 3, 1), [*(turned + parts['translate']), 1])
    scale, shear, angles, translate, perspective = tf.decompose_matrix(matrix)
    for found, name in ((scale, 'scale'), (shear, 'shear'), (angles, 'angles'),
                        (translate, 'translate')):
        np.testing.assert_allclose(found, parts[name], atol=1e-9)
    assert perspective is None
    np.testing.assert_allclose(tf.compose_matrix(), np.eye(4))
    with pytest.raises(ValueError, match='positive definite'):
        tf.decompose_matrix(np.zeros((4, 4)))


@pytest.fixture
def points():
    """Return homogeneous points (4, 12)."""
    return np.vstack([np.random.default_rng(4).normal(size=(3, 12)), np.ones(12)])


@pytest.mark.parametrize('rows', [3, 4])
def test_points_are_superimposed(points, rows):
    """Rotation, translation and scale between two sets of points are found."""
    moved = tf.compose_matrix([2, 2, 2], None, (0.4, -0.5, 0.6), (1, 2, 3))
    np.testing.assert_allclose(
        tf.superimposition_matrix(points[:rows], (moved @ points)[:rows], True), moved)
    with pytest.raises(ValueError, match='three'):
        tf.superimposition_matrix(points[:rows, :2], points[:rows, :2])


@pytest.mark.parametrize('spread', [1.0, 0.0])
def test_superimposed_points_with_noise(points, spread):
    """The rotation is that of the least squares, proper also for points in a plane."""
    points[2] *= spread
    noisy = points[:3, ::-1] + np.random.default_rng(5).normal(size=(3, 12))
    expected, _ = Rotation.align_vectors(
        (noisy - noisy.mean(axis=1)[:, None]).T,
        (points[:3] - points[:3].mean(axis=1)[:, None]).T)
    found = tf.superimposition_matrix(points[:3], noisy)
    np.testing.assert_allclose(found[:3, :3], expected.as_matrix(), atol=1e-9)
    np.testing.assert_allclose(
        (found @ points)[:3].mean(axis=1), noisy.mean(axis=1), atol=1e-12)
