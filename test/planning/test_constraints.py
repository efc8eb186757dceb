# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of constraints: which states keep them, and what cannot be used."""

import math

import numpy as np
import pytest

from armsim_ros.model.geometry import Box, Cylinder, Mesh, Sphere
from armsim_ros.model.transforms import matrix_from_rpy, pose_matrix, quat_xyzw_from_rpy
from armsim_ros.planning.request import (
    JointConstraint,
    OrientationConstraint,
    PositionConstraint,
    Region,
)


def q(*values):
    """Return a state of the planar arm."""
    return np.array(values, dtype=float)


def position(shape, xyz, **options):
    """Return a position constraint of the tool in the base frame."""
    return PositionConstraint('tool', (Region(shape, pose_matrix(xyz)),), 'base', **options)


def orientation(rpy, tolerances, **options):
    """Return an orientation constraint of the tool in the base frame."""
    return OrientationConstraint(
        'tool', tuple(quat_xyzw_from_rpy(rpy)), tolerances, 'base', **options)


@pytest.mark.parametrize('constraint', [
    {'joints': (JointConstraint('axis1', math.nan, 0.1, 0.1),)},
    {'joints': (JointConstraint('axis1', 0.0, math.nan, 0.1),)},
    {'positions': (PositionConstraint(
        'tool', (Region(Sphere(9.0), np.eye(4)),), 'base', (math.nan, 0.0, 0.0)),)},
    {'positions': (PositionConstraint('tool', (Region(Sphere(0.0), np.eye(4)),), 'base'),)},
    {'orientations': (OrientationConstraint('tool', (0, 0, 0, math.nan), (9.0,) * 3, 'base'),)},
    {'orientations': (OrientationConstraint('tool', (0, 0, 0, 1), (9, 9, math.nan), 'base'),)},
], ids=['joint', 'joint tolerance', 'offset', 'region', 'orientation', 'tolerance'])
def test_numbers_that_are_none_are_never_satisfied(constraint_set, constraint):
    """
    A constraint with a number that is not finite, or a region of no extent, is never satisfied.

    Upstream: kinematic_constraint.cpp, the comparisons in decide.
    """
    made = constraint_set(**constraint)
    assert not made.empty
    assert not made.satisfiable
    assert not made.satisfied(q(0.0, 0.0, 0.0))
    assert [each.satisfied for each in made.evaluate(q(0.0, 0.0, 0.0))] == [False]


# The tool of the stretched planar arm is at x = 0.7, its end 0.1 further in z.
@pytest.mark.parametrize(('shape', 'xyz', 'kept'), [
    (Sphere(0.05), (0.74, 0.0, 0.1), True),
    (Sphere(0.05), (0.76, 0.0, 0.1), False),
    (Box((0.1, 0.02, 0.02)), (0.74, 0.0, 0.1), True),
    (Box((0.02, 0.1, 0.02)), (0.74, 0.0, 0.1), False),
    (Cylinder(0.03, 0.2), (0.68, 0.0, 0.19), True),
    (Cylinder(0.03, 0.2), (0.68, 0.0, 0.21), False),
])
def test_position_regions(constraint_set, shape, xyz, kept):
    """CON-2: spheres, boxes and cylinders as regions."""
    assert constraint_set(positions=(position(shape, xyz),)).satisfied(q(0.0, 0.0, 0.0)) is kept


def test_several_regions_are_alternatives(constraint_set):
    """CON-2: one region of several is enough."""
    regions = (Region(Sphere(0.01), pose_matrix((0.0, 0.7, 0.1))),
               Region(Sphere(0.01), pose_matrix((0.7, 0.0, 0.1))))
    made = constraint_set(positions=(PositionConstraint('tool', regions, 'base'),))
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert made.satisfied(q(math.pi / 2, 0.0, 0.0))
    assert not made.satisfied(q(math.pi / 4, 0.0, 0.0))


def test_mesh_region(constraint_set):
    """CON-2: the inside of a closed mesh."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
    made = constraint_set(positions=(position(Mesh(corners, faces), (0.5, -0.5, -0.5)),))
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert not made.satisfied(q(math.pi / 2, 0.0, 0.0))


def test_target_point_offset(constraint_set):
    """CON-2: the constrained point is given in the link's frame."""
    there = position(Sphere(0.001), (0.9, 0.0, 0.1), target_point_offset=(0.2, 0.0, 0.0))
    assert constraint_set(positions=(there,)).satisfied(q(0.0, 0.0, 0.0))


def test_position_without_frame_is_ignored(constraint_set):
    """
    A position constraint with an empty frame is not used.

    Upstream: kinematic_constraint.cpp, PositionConstraint::configure.
    """
    made = constraint_set(positions=(PositionConstraint(
        'tool', (Region(Sphere(0.001), np.eye(4)),), ''),))
    assert made.empty
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert 'frame_id is empty' in made.unusable[0]


@pytest.mark.parametrize('kind', ['position', 'orientation'])
def test_unknown_link_is_ignored(constraint_set, kind):
    """
    A constraint of an unknown link counts as satisfied.

    Upstream: kinematic_constraint.cpp, configure and decide.
    """
    made = constraint_set(
        positions=(PositionConstraint(
            'toll', (Region(Sphere(0.001), np.eye(4)),), 'base'),) if kind == 'position' else (),
        orientations=(OrientationConstraint(
            'toll', (1, 0, 0, 0), (0.1,) * 3, 'base'),) if kind == 'orientation' else ())
    assert made.empty
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert "'toll'" in made.unusable[0]


def test_position_without_a_region_is_ignored(constraint_set, log):
    """
    A position constraint whose shapes have no pose counts as satisfied.

    Upstream: kinematic_constraint.cpp, PositionConstraint::configure.
    """
    made = constraint_set(
        positions=(PositionConstraint('tool', (), 'base', left_out=('no pose',)),))
    assert made.empty
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert [each.satisfied for each in made.evaluate(q(0.0, 0.0, 0.0))] == [True]
    assert 'no pose' in log.recorder.text()


def test_unknown_frame_is_the_model_frame(constraint_set, log):
    """
    A frame that is not known counts as the model frame, with a warning.

    Upstream: robot_state.cpp, getFrameTransform.
    """
    region = Region(Sphere(0.001), pose_matrix((0.7, 0.0, 0.1)))
    made = constraint_set(positions=(PositionConstraint('tool', (region,), 'nowhere'),),
                orientations=(OrientationConstraint(
                    'tool', (0.0, 0.0, 0.0, 1.0), (0.01,) * 3, 'nowhere'),))
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert not made.satisfied(q(0.1, 0.0, 0.0))
    assert "frame 'nowhere' is not known" in log.recorder.text()


def test_orientation_without_frame_is_in_the_model_frame(constraint_set):
    """
    An orientation constraint with an empty frame is one in the model frame.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::configure.
    """
    made = constraint_set(orientations=(OrientationConstraint(
        'tool', tuple(quat_xyzw_from_rpy((0.0, 0.0, 0.3))), (0.01,) * 3, ''),))
    assert made.satisfied(q(0.3, 0.0, 0.0))
    assert not made.satisfied(q(0.0, 0.0, 0.0))


def test_frame_that_moves(constraint_set):
    """CON-5: a region in the frame of a moving link moves with it."""
    region = Region(Sphere(0.001), pose_matrix((0.3, 0.0, 0.1)))
    made = constraint_set(positions=(PositionConstraint('tool', (region,), 'segment2'),))
    assert made.satisfied(q(1.0, -0.4, 0.3))


@pytest.mark.parametrize('parameterization', [0, 1])
def test_orientation_tolerance_axes(constraint_set, parameterization):
    """Each axis has a tolerance of its own."""
    made = constraint_set(orientations=(orientation(
        (0.0, 0.0, 0.0), (0.01, 0.01, 0.5), parameterization=parameterization),))
    assert made.satisfied(q(0.4, 0.0, 0.0))
    assert not made.satisfied(q(0.6, 0.0, 0.0))


# The wanted orientation's x axis points along the frame's z axis: turning the arm about its
# axis is a turn about x in the first, about z in the second.
@pytest.mark.parametrize(('parameterization', 'free', 'kept'), [
    (0, 0, True), (0, 2, False), (1, 0, False), (1, 2, True)])
def test_whose_axes_tolerances_are_about(constraint_set, parameterization, free, kept):
    """
    Euler angles are about the axes of the desired orientation, a rotation vector the frame's.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::decide.
    """
    desired = (0.0, -math.pi / 2, 0.0)
    tolerances = [0.01, 0.01, 0.01]
    tolerances[free] = 0.5
    term, = constraint_set(orientations=(orientation(
        desired, tuple(tolerances), parameterization=parameterization),)).orientations
    poses = {link: np.eye(4) for link in (term.target.link, term.frame.link)}
    poses[term.target.link] = pose_matrix(rpy=(0.0, 0.0, 0.4)) @ pose_matrix(rpy=desired) \
        @ np.linalg.inv(term.target.offset)
    assert term.evaluate(poses).satisfied is kept


def test_orientation_tolerances_have_no_sign(constraint_set):
    """
    Tolerances of an orientation are taken by absolute value.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::configure.
    """
    made = constraint_set(orientations=(orientation((0.0, 0.0, 0.0), (-0.01, 0.01, -0.5)),))
    assert made.satisfied(q(0.4, 0.0, 0.0))
    assert not made.satisfied(q(0.6, 0.0, 0.0))


def test_orientation_distance(constraint_set):
    """
    The distance of an orientation is the weighted sum of its angles; weight 0 counts as 1.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::decide.
    """
    made = constraint_set(orientations=(
        orientation((0.0, 0.0, 0.3), (0.1, 0.1, 0.1), weight=2.0),
        orientation((0.2, 0.0, 0.0), (0.1, 0.1, 0.1), weight=0.0)))
    first, second = made.evaluate(q(0.0, 0.0, 0.0))
    assert first.distance == pytest.approx(0.6)
    assert second.distance == pytest.approx(0.2)


def test_position_distance(constraint_set):
    """
    The distance is that to the first region that holds the point, else to the last region.

    Upstream: kinematic_constraint.cpp, PositionConstraint::decide.
    """
    def regions(*spheres):
        return tuple(Region(Sphere(r), pose_matrix((x, 0.0, 0.1))) for r, x in spheres)
    made = constraint_set(positions=(
        PositionConstraint('tool', regions((0.01, 0.0), (0.5, 0.5), (0.5, 0.7)), 'base'),
        PositionConstraint('tool', regions((0.01, 0.6), (0.01, 0.4)), 'base', weight=2.0)))
    held, outside = made.evaluate(q(0.0, 0.0, 0.0))
    assert (held.satisfied, held.distance) == (True, pytest.approx(0.2))
    assert (outside.satisfied, outside.distance) == (False, pytest.approx(0.6))


@pytest.mark.parametrize(('pitch', 'tolerances', 'kept'), [
    (math.pi / 2, (0.3, 2.0, 0.3), True), (-math.pi / 2, (0.3, 2.0, 0.3), True),
    (math.pi / 2, (0.3, 2.0, 0.1), False), (math.pi / 2, (0.1, 2.0, 0.3), False),
])
def test_gimbal_lock(constraint_set, pitch, tolerances, kept):
    """
    At a pitch of a right angle the sum of roll and yaw has to be within both tolerances.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::decide.
    """
    term, = constraint_set(orientations=(orientation((0.0, 0.0, 0.0), tolerances),)).orientations
    turned = (matrix_from_rpy((0.2, 0.0, 0.0)) @ matrix_from_rpy((0.0, pitch, 0.0)))
    poses = {term.frame.link: np.eye(4)}
    poses[term.target.link] = np.eye(4)
    poses[term.target.link][:3, :3] = turned @ term.target.offset[:3, :3].T
    assert term.evaluate(poses).satisfied is kept


def test_free_axis(constraint_set):
    """A tolerance of 3.14 rad or more leaves an axis free."""
    made = constraint_set(orientations=(orientation((0.0, 0.0, 0.0), (0.01, 0.01, 3.1416)),))
    assert made.satisfied(q(2.9, 0.2, 0.0))


def test_quaternion_that_is_not_unit_reads_as_identity(constraint_set, log):
    """CON-3: a quaternion off by more than 1e-3 counts as the identity, with a warning."""
    made = constraint_set(orientations=(OrientationConstraint(
        'tool', (0.0, 0.0, 0.0, 0.0), (0.1, 0.1, 0.1), 'base'),))
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert 'not of length 1' in log.recorder.text()


def test_unknown_parameterization(constraint_set, log):
    """CON-3: an unknown parameterization counts as Euler angles, with a warning."""
    made = constraint_set(orientations=(orientation(
        (0.0, 0.0, 0.0), (0.1, 0.1, 0.1), parameterization=7),))
    assert not made.empty
    assert 'parameterization 7' in log.recorder.text()


def test_results_in_order(constraint_set):
    """CON-8: one result a constraint, joints first, then positions, then orientations."""
    made = constraint_set(
        joints=(JointConstraint('axis1', 0.0, 0.1, 0.1),),
        positions=(position(Sphere(0.01), (0.7, 0.0, 0.1)),),
        orientations=(orientation((0.0, 0.0, 1.0), (0.1, 0.1, 0.1)),),
    )
    assert [each.satisfied for each in made.evaluate(q(0.0, 0.0, 0.0))] == [True, True, False]


def test_residual_is_zero_where_kept(constraint_set):
    """The residual that projection follows vanishes exactly on the states that keep all."""
    made = constraint_set(positions=(position(Box((0.2, 0.2, 0.2)), (0.6, 0.3, 0.1)),),
                orientations=(orientation((0.0, 0.0, 0.5), (0.1, 0.1, 0.3)),))
    rng = np.random.default_rng(3)
    seen = set()
    for state in rng.uniform(-1.0, 1.0, (400, 3)):
        kept = all(each.satisfied for each in made.evaluate(state))
        assert kept == (np.abs(made.residual(state)).max() <= 1e-9)
        seen.add(kept)
    assert seen == {True, False}
