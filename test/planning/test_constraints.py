# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of constraints: which states keep them, and what cannot be used."""

import math

import numpy as np
import pytest

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Cylinder, Mesh, Sphere
from armsim_ros.model.transforms import matrix_from_rpy, pose_matrix, quat_xyzw_from_rpy
from armsim_ros.planning.constraints import ConstraintSet, merged
from armsim_ros.planning.request import (
    Constraints,
    JointConstraint,
    OrientationConstraint,
    PositionConstraint,
    Region,
)
from armsim_ros.planning.scene.planning_scene import PlanningScene


@pytest.fixture
def make(planar_scene, log):
    """Return a function that prepares constraints for the planar arm."""
    def build(*, joints=(), positions=(), orientations=()):
        return ConstraintSet(Constraints(joints, positions, orientations), planar_scene, log)
    return build


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


@pytest.mark.parametrize(('value', 'kept'), [(0.5, True), (0.59, True), (0.61, False),
                                             (0.46, True), (0.44, False)])
def test_joint_interval(make, value, kept):
    """CON-1: a joint is allowed from position - below to position + above."""
    joint = JointConstraint('axis1', 0.5, tolerance_above=0.1, tolerance_below=0.05)
    assert make(joints=(joint,)).satisfied(q(value, 0.0, 0.0)) is kept


def test_usable_constraints_leave_no_error(make, log):
    """Constraints that can be used give no message and no reason."""
    joint = JointConstraint('axis1', 0.5, tolerance_above=0.1, tolerance_below=0.05)
    assert not make(joints=(joint,)).unusable
    assert not log.recorder.text()


def test_joint_distance(make):
    """CON-8: the distance of a joint constraint is the weighted way to its position."""
    made = make(joints=(JointConstraint('axis2', 0.5, 0.1, 0.1, weight=2.0),))
    result, = made.evaluate(q(0.0, 0.8, 0.0))
    assert not result.satisfied
    assert result.distance == pytest.approx(0.6)


@pytest.mark.parametrize(('target', 'value', 'kept'), [
    (3.5, 2.9, True), (3.5, 2.89, False), (-3.5, -2.9, True), (-3.5, -2.89, False),
    (2.95, 2.86, True), (2.95, 2.84, False),
])
def test_target_beyond_a_limit(make, target, value, kept):
    """
    A position beyond a limit by more than its tolerance becomes the limit, inner tolerance 0.

    Upstream: kinematic_constraint.cpp, JointConstraint::configure.
    """
    made = make(joints=(JointConstraint('axis1', target, 0.1, 0.1),))
    assert made.satisfied(q(value, 0.0, 0.0)) is kept


def test_target_beyond_a_limit_is_reported(make, log):
    """The warning of a position beyond a limit names both."""
    make(joints=(JointConstraint('axis1', 3.5, 0.01, 0.01),))
    assert "3.5000 of joint 'axis1' is outside its limits -2.9000 .. 2.9000" \
        in log.recorder.text()


@pytest.mark.parametrize('tolerances', [(-0.1, 0.1), (0.1, -0.1)])
def test_negative_joint_tolerance_counts_as_satisfied(make, log, tolerances):
    """
    A joint constraint with a negative tolerance is warned about; the others still hold.

    Upstream: kinematic_constraint.cpp, JointConstraint::configure and decide.
    """
    made = make(joints=(JointConstraint('axis1', 2.0, *tolerances),
                        JointConstraint('axis2', 0.5, 0.1, 0.1)))
    assert made.satisfied(q(0.0, 0.5, 0.0))
    assert not made.satisfied(q(2.0, 0.0, 0.0))
    assert 'constraint ignored' in log.recorder.text()
    assert [each.satisfied for each in made.evaluate(q(0.0, 0.0, 0.0))] == [True, False]


@pytest.mark.parametrize('constraint', [
    {'joints': (JointConstraint('axis1', math.nan, 0.1, 0.1),)},
    {'joints': (JointConstraint('axis1', 0.0, math.nan, 0.1),)},
    {'positions': (PositionConstraint(
        'tool', (Region(Sphere(9.0), np.eye(4)),), 'base', (math.nan, 0.0, 0.0)),)},
    {'positions': (PositionConstraint('tool', (Region(Sphere(0.0), np.eye(4)),), 'base'),)},
    {'orientations': (OrientationConstraint('tool', (0, 0, 0, math.nan), (9.0,) * 3, 'base'),)},
    {'orientations': (OrientationConstraint('tool', (0, 0, 0, 1), (9, 9, math.nan), 'base'),)},
], ids=['joint', 'joint tolerance', 'offset', 'region', 'orientation', 'tolerance'])
def test_numbers_that_are_none_are_never_satisfied(make, constraint):
    """
    A constraint with a number that is not finite, or a region of no extent, is never satisfied.

    Upstream: kinematic_constraint.cpp, the comparisons in decide.
    """
    made = make(**constraint)
    assert not made.empty
    assert not made.satisfiable
    assert not made.satisfied(q(0.0, 0.0, 0.0))
    assert [each.satisfied for each in made.evaluate(q(0.0, 0.0, 0.0))] == [False]


def test_unknown_joint_is_ignored(make):
    """An unknown joint cannot be constrained; the warning names the nearest one."""
    made = make(joints=(JointConstraint('axsi1', 0.0, 0.1, 0.1),))
    assert made.empty
    assert "did you mean 'axis1'" in made.unusable[0]


def test_continuous_joints_wrap(turning, log):
    """CON-1: a continuous joint one turn further satisfies its constraint."""
    scene = PlanningScene(KinematicModel(turning))
    made = ConstraintSet(
        Constraints((JointConstraint('axis1', 0.1, 0.01, 0.01),)), scene, log)
    assert made.satisfied(q(0.1 + 2 * math.pi, 0.0, 0.0))
    assert not made.satisfied(q(0.1 + math.pi, 0.0, 0.0))


@pytest.mark.parametrize(('target', 'value', 'kept'), [
    (0.0, 0.03, True), (0.0, 0.05, False), (0.0, -0.01, True), (0.0, -0.03, False),
    (3.14, 3.17, True), (3.14, -3.14, True), (3.14, 3.19, False), (3.14, -3.11, True),
    (3.14, -3.09, False), (3.14, 3.13, True), (3.14, 3.11, False), (-3.14, -3.11, True),
    (-3.14, -3.09, False), (-3.14, 3.13, True), (6.28, 0.0, True),
])
def test_wrapped_angles_of_a_continuous_joint(turning, log, target, value, kept):
    """
    A continuous joint is compared the short way round.

    Upstream: test_constraints.cpp, JointConstraintsCont.
    """
    made = ConstraintSet(Constraints((JointConstraint('axis1', target, 0.04, 0.02),)),
                         PlanningScene(KinematicModel(turning)), log)
    assert made.satisfied(q(value, 0.0, 0.0)) is kept


# The tool of the stretched planar arm is at x = 0.7, its end 0.1 further in z.
@pytest.mark.parametrize(('shape', 'xyz', 'kept'), [
    (Sphere(0.05), (0.74, 0.0, 0.1), True),
    (Sphere(0.05), (0.76, 0.0, 0.1), False),
    (Box((0.1, 0.02, 0.02)), (0.74, 0.0, 0.1), True),
    (Box((0.02, 0.1, 0.02)), (0.74, 0.0, 0.1), False),
    (Cylinder(0.03, 0.2), (0.68, 0.0, 0.19), True),
    (Cylinder(0.03, 0.2), (0.68, 0.0, 0.21), False),
])
def test_position_regions(make, shape, xyz, kept):
    """CON-2: spheres, boxes and cylinders as regions."""
    assert make(positions=(position(shape, xyz),)).satisfied(q(0.0, 0.0, 0.0)) is kept


def test_several_regions_are_alternatives(make):
    """CON-2: one region of several is enough."""
    regions = (Region(Sphere(0.01), pose_matrix((0.0, 0.7, 0.1))),
               Region(Sphere(0.01), pose_matrix((0.7, 0.0, 0.1))))
    made = make(positions=(PositionConstraint('tool', regions, 'base'),))
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert made.satisfied(q(math.pi / 2, 0.0, 0.0))
    assert not made.satisfied(q(math.pi / 4, 0.0, 0.0))


def test_mesh_region(make):
    """CON-2: the inside of a closed mesh."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                      [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
    made = make(positions=(position(Mesh(corners, faces), (0.5, -0.5, -0.5)),))
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert not made.satisfied(q(math.pi / 2, 0.0, 0.0))


def test_target_point_offset(make):
    """CON-2: the constrained point is given in the link's frame."""
    there = position(Sphere(0.001), (0.9, 0.0, 0.1), target_point_offset=(0.2, 0.0, 0.0))
    assert make(positions=(there,)).satisfied(q(0.0, 0.0, 0.0))


def test_position_without_frame_is_ignored(make):
    """
    A position constraint with an empty frame is not used.

    Upstream: kinematic_constraint.cpp, PositionConstraint::configure.
    """
    made = make(positions=(PositionConstraint(
        'tool', (Region(Sphere(0.001), np.eye(4)),), ''),))
    assert made.empty
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert 'frame_id is empty' in made.unusable[0]


@pytest.mark.parametrize('kind', ['position', 'orientation'])
def test_unknown_link_is_ignored(make, kind):
    """
    A constraint of an unknown link counts as satisfied.

    Upstream: kinematic_constraint.cpp, configure and decide.
    """
    made = make(
        positions=(PositionConstraint(
            'toll', (Region(Sphere(0.001), np.eye(4)),), 'base'),) if kind == 'position' else (),
        orientations=(OrientationConstraint(
            'toll', (1, 0, 0, 0), (0.1,) * 3, 'base'),) if kind == 'orientation' else ())
    assert made.empty
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert "'toll'" in made.unusable[0]


def test_position_without_a_region_is_ignored(make, log):
    """
    A position constraint whose shapes have no pose counts as satisfied.

    Upstream: kinematic_constraint.cpp, PositionConstraint::configure.
    """
    made = make(positions=(PositionConstraint('tool', (), 'base', left_out=('no pose',)),))
    assert made.empty
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert [each.satisfied for each in made.evaluate(q(0.0, 0.0, 0.0))] == [True]
    assert 'no pose' in log.recorder.text()


def test_unknown_frame_is_the_model_frame(make, log):
    """
    A frame that is not known counts as the model frame, with a warning.

    Upstream: robot_state.cpp, getFrameTransform.
    """
    region = Region(Sphere(0.001), pose_matrix((0.7, 0.0, 0.1)))
    made = make(positions=(PositionConstraint('tool', (region,), 'nowhere'),),
                orientations=(OrientationConstraint(
                    'tool', (0.0, 0.0, 0.0, 1.0), (0.01,) * 3, 'nowhere'),))
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert not made.satisfied(q(0.1, 0.0, 0.0))
    assert "frame 'nowhere' is not known" in log.recorder.text()


def test_orientation_without_frame_is_in_the_model_frame(make):
    """
    An orientation constraint with an empty frame is one in the model frame.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::configure.
    """
    made = make(orientations=(OrientationConstraint(
        'tool', tuple(quat_xyzw_from_rpy((0.0, 0.0, 0.3))), (0.01,) * 3, ''),))
    assert made.satisfied(q(0.3, 0.0, 0.0))
    assert not made.satisfied(q(0.0, 0.0, 0.0))


def test_frame_that_moves(make):
    """CON-5: a region in the frame of a moving link moves with it."""
    region = Region(Sphere(0.001), pose_matrix((0.3, 0.0, 0.1)))
    made = make(positions=(PositionConstraint('tool', (region,), 'segment2'),))
    assert made.satisfied(q(1.0, -0.4, 0.3))


@pytest.mark.parametrize('parameterization', [0, 1])
def test_orientation_tolerance_axes(make, parameterization):
    """Each axis has a tolerance of its own."""
    made = make(orientations=(orientation(
        (0.0, 0.0, 0.0), (0.01, 0.01, 0.5), parameterization=parameterization),))
    assert made.satisfied(q(0.4, 0.0, 0.0))
    assert not made.satisfied(q(0.6, 0.0, 0.0))


# The wanted orientation's x axis points along the frame's z axis: turning the arm about its
# axis is a turn about x in the first, about z in the second.
@pytest.mark.parametrize(('parameterization', 'free', 'kept'), [
    (0, 0, True), (0, 2, False), (1, 0, False), (1, 2, True)])
def test_whose_axes_tolerances_are_about(make, parameterization, free, kept):
    """
    Euler angles are about the axes of the desired orientation, a rotation vector the frame's.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::decide.
    """
    desired = (0.0, -math.pi / 2, 0.0)
    tolerances = [0.01, 0.01, 0.01]
    tolerances[free] = 0.5
    term, = make(orientations=(orientation(
        desired, tuple(tolerances), parameterization=parameterization),)).orientations
    poses = {link: np.eye(4) for link in (term.target.link, term.frame.link)}
    poses[term.target.link] = pose_matrix(rpy=(0.0, 0.0, 0.4)) @ pose_matrix(rpy=desired) \
        @ np.linalg.inv(term.target.offset)
    assert term.evaluate(poses).satisfied is kept


def test_orientation_tolerances_have_no_sign(make):
    """
    Tolerances of an orientation are taken by absolute value.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::configure.
    """
    made = make(orientations=(orientation((0.0, 0.0, 0.0), (-0.01, 0.01, -0.5)),))
    assert made.satisfied(q(0.4, 0.0, 0.0))
    assert not made.satisfied(q(0.6, 0.0, 0.0))


def test_orientation_distance(make):
    """
    The distance of an orientation is the weighted sum of its angles; weight 0 counts as 1.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::decide.
    """
    made = make(orientations=(
        orientation((0.0, 0.0, 0.3), (0.1, 0.1, 0.1), weight=2.0),
        orientation((0.2, 0.0, 0.0), (0.1, 0.1, 0.1), weight=0.0)))
    first, second = made.evaluate(q(0.0, 0.0, 0.0))
    assert first.distance == pytest.approx(0.6)
    assert second.distance == pytest.approx(0.2)


def test_position_distance(make):
    """
    The distance is that to the first region that holds the point, else to the last region.

    Upstream: kinematic_constraint.cpp, PositionConstraint::decide.
    """
    def regions(*spheres):
        return tuple(Region(Sphere(r), pose_matrix((x, 0.0, 0.1))) for r, x in spheres)
    made = make(positions=(
        PositionConstraint('tool', regions((0.01, 0.0), (0.5, 0.5), (0.5, 0.7)), 'base'),
        PositionConstraint('tool', regions((0.01, 0.6), (0.01, 0.4)), 'base', weight=2.0)))
    held, outside = made.evaluate(q(0.0, 0.0, 0.0))
    assert (held.satisfied, held.distance) == (True, pytest.approx(0.2))
    assert (outside.satisfied, outside.distance) == (False, pytest.approx(0.6))


@pytest.mark.parametrize(('pitch', 'tolerances', 'kept'), [
    (math.pi / 2, (0.3, 2.0, 0.3), True), (-math.pi / 2, (0.3, 2.0, 0.3), True),
    (math.pi / 2, (0.3, 2.0, 0.1), False), (math.pi / 2, (0.1, 2.0, 0.3), False),
])
def test_gimbal_lock(make, pitch, tolerances, kept):
    """
    At a pitch of a right angle the sum of roll and yaw has to be within both tolerances.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::decide.
    """
    term, = make(orientations=(orientation((0.0, 0.0, 0.0), tolerances),)).orientations
    turned = (matrix_from_rpy((0.2, 0.0, 0.0)) @ matrix_from_rpy((0.0, pitch, 0.0)))
    poses = {term.frame.link: np.eye(4)}
    poses[term.target.link] = np.eye(4)
    poses[term.target.link][:3, :3] = turned @ term.target.offset[:3, :3].T
    assert term.evaluate(poses).satisfied is kept


def test_free_axis(make):
    """A tolerance of 3.14 rad or more leaves an axis free."""
    made = make(orientations=(orientation((0.0, 0.0, 0.0), (0.01, 0.01, 3.1416)),))
    assert made.satisfied(q(2.9, 0.2, 0.0))


def test_quaternion_that_is_not_unit_reads_as_identity(make, log):
    """CON-3: a quaternion off by more than 1e-3 counts as the identity, with a warning."""
    made = make(orientations=(OrientationConstraint(
        'tool', (0.0, 0.0, 0.0, 0.0), (0.1, 0.1, 0.1), 'base'),))
    assert made.satisfied(q(0.0, 0.0, 0.0))
    assert 'not of length 1' in log.recorder.text()


def test_unknown_parameterization(make, log):
    """CON-3: an unknown parameterization counts as Euler angles, with a warning."""
    made = make(orientations=(orientation(
        (0.0, 0.0, 0.0), (0.1, 0.1, 0.1), parameterization=7),))
    assert not made.empty
    assert 'parameterization 7' in log.recorder.text()


def test_results_in_order(make):
    """CON-8: one result a constraint, joints first, then positions, then orientations."""
    made = make(
        joints=(JointConstraint('axis1', 0.0, 0.1, 0.1),),
        positions=(position(Sphere(0.01), (0.7, 0.0, 0.1)),),
        orientations=(orientation((0.0, 0.0, 1.0), (0.1, 0.1, 0.1)),),
    )
    assert [each.satisfied for each in made.evaluate(q(0.0, 0.0, 0.0))] == [True, True, False]


def test_residual_is_zero_where_kept(make):
    """The residual that projection follows vanishes exactly on the states that keep all."""
    made = make(positions=(position(Box((0.2, 0.2, 0.2)), (0.6, 0.3, 0.1)),),
                orientations=(orientation((0.0, 0.0, 0.5), (0.1, 0.1, 0.3)),))
    rng = np.random.default_rng(3)
    seen = set()
    for state in rng.uniform(-1.0, 1.0, (400, 3)):
        kept = all(each.satisfied for each in made.evaluate(state))
        assert kept == (np.abs(made.residual(state)).max() <= 1e-9)
        seen.add(kept)
    assert seen == {True, False}


def test_merging_intersects_intervals(log):
    """CON-6: two intervals of one joint become their common part."""
    both = merged(Constraints((JointConstraint('a', 0.0, 0.5, 0.5),)),
                  Constraints((JointConstraint('a', 0.4, 0.3, 0.2),)), log)
    joint, = both.joint_constraints
    assert joint.position - joint.tolerance_below == pytest.approx(0.2)
    assert joint.position + joint.tolerance_above == pytest.approx(0.5)


def test_merging_weights_positions(log):
    """
    The merged position is the weighted mean, within the common part.

    Upstream: kinematic_constraints/utils.cpp, mergeConstraints.
    """
    both = merged(Constraints((JointConstraint('a', 0.0, 0.5, 0.5, weight=3.0),)),
                  Constraints((JointConstraint('a', 0.4, 0.5, 0.5, weight=1.0),)), log)
    joint, = both.joint_constraints
    assert (joint.position, joint.weight) == (pytest.approx(0.1), 2.0)


def test_merging_without_common_part(log):
    """CON-6: intervals without a common value are both dropped, with an error."""
    both = merged(Constraints((JointConstraint('a', 0.0, 0.1, 0.1),)),
                  Constraints((JointConstraint('a', 1.0, 0.1, 0.1),)), log)
    assert both.empty
    assert 'no common value' in log.recorder.text()
