# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of constraints: which states keep them, and what cannot be used."""

import math

import numpy as np
import pytest

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Cylinder, Mesh, Sphere
from armsim_ros.model.transforms import euler_xyz, matrix_from_rpy, pose_matrix, quat_xyzw_from_rpy
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


def test_joint_distance(make):
    """CON-8: the distance of a joint constraint is the weighted way to its position."""
    made = make(joints=(JointConstraint('axis2', 0.5, 0.1, 0.1, weight=2.0),))
    result, = made.evaluate(q(0.0, 0.8, 0.0))
    assert not result.satisfied
    assert result.distance == pytest.approx(0.6)


def test_target_beyond_the_limits_is_clamped(make, log):
    """CON-1: a position beyond the limits counts as the limit, with a warning."""
    made = make(joints=(JointConstraint('axis1', 3.5, 0.01, 0.01),))
    assert made.satisfied(q(2.9, 0.0, 0.0))
    assert 'outside its limits' in log.recorder.text()


@pytest.mark.parametrize('tolerances', [(-0.1, 0.1), (0.1, -0.1), (math.nan, 0.1)])
def test_negative_tolerance_drops_the_constraint(make, log, tolerances):
    """CON-1: a negative tolerance makes that constraint invalid; it is dropped and said."""
    made = make(joints=(JointConstraint('axis1', 0.0, *tolerances),))
    assert made.empty
    assert 'constraint ignored' in log.recorder.text()


def test_unknown_joint_is_dropped(make):
    """CON-1: an unknown joint cannot be constrained; the reason names the nearest one."""
    made = make(joints=(JointConstraint('axsi1', 0.0, 0.1, 0.1),))
    assert made.empty
    assert "did you mean 'axis1'" in made.dropped[0]


def test_continuous_joints_wrap(turning, log):
    """CON-1: a continuous joint one turn further satisfies its constraint."""
    scene = PlanningScene(KinematicModel(turning))
    made = ConstraintSet(
        Constraints((JointConstraint('axis1', 0.1, 0.01, 0.01),)), scene, log)
    assert made.satisfied(q(0.1 + 2 * math.pi, 0.0, 0.0))
    assert not made.satisfied(q(0.1 + math.pi, 0.0, 0.0))


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


def test_position_without_frame_is_invalid(make):
    """CON-2: an empty frame makes a position constraint invalid."""
    made = make(positions=(PositionConstraint(
        'tool', (Region(Sphere(1.0), np.eye(4)),), ''),))
    assert made.empty
    assert 'frame_id is empty' in made.dropped[0]


def test_position_of_an_unknown_link(make):
    """CON-2: an unknown link makes the constraint invalid."""
    made = make(positions=(PositionConstraint(
        'toll', (Region(Sphere(1.0), np.eye(4)),), 'base'),))
    assert "'toll'" in made.dropped[0]


def test_frame_that_moves(make):
    """CON-5: a region in the frame of a moving link moves with it."""
    region = Region(Sphere(0.001), pose_matrix((0.3, 0.0, 0.1)))
    made = make(positions=(PositionConstraint('tool', (region,), 'segment2'),))
    assert made.satisfied(q(1.0, -0.4, 0.3))


@pytest.mark.parametrize('parameterization', [0, 1])
def test_orientation_tolerance_axes(make, parameterization):
    """CON-3: each axis of the constraint frame has a tolerance of its own."""
    made = make(orientations=(orientation(
        (0.0, 0.0, 0.0), (0.01, 0.01, 0.5), parameterization=parameterization),))
    assert made.satisfied(q(0.4, 0.0, 0.0))
    assert not made.satisfied(q(0.6, 0.0, 0.0))


def test_tolerance_axes_are_those_of_the_constraint_frame(make):
    """CON-3: a wanted orientation that is turned does not turn the tolerance axes."""
    made = make(orientations=(orientation(
        (0.0, 0.0, math.pi / 2), (0.01, 0.01, 0.5)),))
    assert made.satisfied(q(math.pi / 2 + 0.4, 0.0, 0.0))


def test_free_axis(make):
    """CON-3: a tolerance of pi or more leaves an axis free."""
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


def test_rotation_errors_by_their_definition():
    """CON-3: Euler angles multiply back as x, y, z."""
    a, b, c = 0.3, -0.7, 1.1
    rotation = (matrix_from_rpy((a, 0, 0)) @ matrix_from_rpy((0, b, 0))
                @ matrix_from_rpy((0, 0, c)))
    assert euler_xyz(rotation) == pytest.approx((a, b, c))


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


def test_merging_without_common_part(log):
    """CON-6: intervals without a common value are both dropped, with an error."""
    both = merged(Constraints((JointConstraint('a', 0.0, 0.1, 0.1),)),
                  Constraints((JointConstraint('a', 1.0, 0.1, 0.1),)), log)
    assert both.empty
    assert 'no common value' in log.recorder.text()
