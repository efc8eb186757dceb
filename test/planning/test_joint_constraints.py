# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of joint constraints: intervals, continuous joints, and what two sets have in common."""

import math

import numpy as np
import pytest

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.constraints import ConstraintSet, merged
from armsim_ros.planning.request import Constraints, JointConstraint, MotionPlanRequest
from armsim_ros.planning.scene.planning_scene import PlanningScene


@pytest.mark.parametrize(('value', 'kept'), [(0.5, True), (0.59, True), (0.61, False),
                                             (0.46, True), (0.44, False)])
def test_joint_interval(constraint_set, value, kept):
    """CON-1: a joint is allowed from position - below to position + above."""
    joint = JointConstraint('axis1', 0.5, tolerance_above=0.1, tolerance_below=0.05)
    assert constraint_set(joints=(joint,)).satisfied(np.array([value, 0.0, 0.0])) is kept


def test_usable_constraints_leave_no_error(constraint_set, log):
    """Constraints that can be used give no message and no reason."""
    joint = JointConstraint('axis1', 0.5, tolerance_above=0.1, tolerance_below=0.05)
    assert not constraint_set(joints=(joint,)).unusable
    assert not log.recorder.text()


def test_joint_distance(constraint_set):
    """CON-8: the distance of a joint constraint is the weighted way to its position."""
    made = constraint_set(joints=(JointConstraint('axis2', 0.5, 0.1, 0.1, weight=2.0),))
    result, = made.evaluate(np.array([0.0, 0.8, 0.0]))
    assert not result.satisfied
    assert result.distance == pytest.approx(0.6)


@pytest.mark.parametrize(('target', 'value', 'kept'), [
    (3.5, 2.9, True), (3.5, 2.89, False), (-3.5, -2.9, True), (-3.5, -2.89, False),
    (2.95, 2.86, True), (2.95, 2.84, False),
])
def test_target_beyond_a_limit(constraint_set, target, value, kept):
    """
    A position beyond a limit by more than its tolerance becomes the limit, inner tolerance 0.

    Upstream: kinematic_constraint.cpp, JointConstraint::configure.
    """
    made = constraint_set(joints=(JointConstraint('axis1', target, 0.1, 0.1),))
    assert made.satisfied(np.array([value, 0.0, 0.0])) is kept


def test_target_beyond_a_limit_is_reported(constraint_set, log):
    """The warning of a position beyond a limit names both."""
    constraint_set(joints=(JointConstraint('axis1', 3.5, 0.01, 0.01),))
    assert "3.5000 of joint 'axis1' is outside its limits -2.9000 .. 2.9000" \
        in log.recorder.text()


@pytest.mark.parametrize('tolerances', [(-0.1, 0.1), (0.1, -0.1)])
def test_negative_joint_tolerance_counts_as_satisfied(constraint_set, log, tolerances):
    """
    A joint constraint with a negative tolerance is warned about; the others still hold.

    Upstream: kinematic_constraint.cpp, JointConstraint::configure and decide.
    """
    made = constraint_set(joints=(JointConstraint('axis1', 2.0, *tolerances),
                        JointConstraint('axis2', 0.5, 0.1, 0.1)))
    assert made.satisfied(np.array([0.0, 0.5, 0.0]))
    assert not made.satisfied(np.array([2.0, 0.0, 0.0]))
    assert 'constraint ignored' in log.recorder.text()
    assert [each.satisfied for each in made.evaluate(np.array([0.0, 0.0, 0.0]))] == [True, False]


def test_unknown_joint_is_ignored(constraint_set):
    """An unknown joint cannot be constrained; the warning names the nearest one."""
    made = constraint_set(joints=(JointConstraint('axsi1', 0.0, 0.1, 0.1),))
    assert made.empty
    assert "did you mean 'axis1'" in made.unusable[0]


def test_continuous_joints_wrap(turning, log):
    """CON-1: a continuous joint one turn further satisfies its constraint."""
    scene = PlanningScene(KinematicModel(turning))
    made = ConstraintSet(
        Constraints((JointConstraint('axis1', 0.1, 0.01, 0.01),)), scene, log)
    assert made.satisfied(np.array([0.1 + 2 * math.pi, 0.0, 0.0]))
    assert not made.satisfied(np.array([0.1 + math.pi, 0.0, 0.0]))


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
    assert made.satisfied(np.array([value, 0.0, 0.0])) is kept


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
    """CON-6: a joint whose intervals have no common value is free, with an error; others stay."""
    other = JointConstraint('b', 0.5, 0.1, 0.1)
    both = merged(Constraints((JointConstraint('a', 0.0, 0.1, 0.1),)),
                  Constraints((JointConstraint('a', 1.0, 0.1, 0.1),
                               JointConstraint('a', 1.0, 0.1, 0.1), other)), log)
    assert both.joint_constraints == (other,)
    assert 'no common value' in log.recorder.text()


def test_entries_of_one_list_are_not_merged(log):
    """
    Two entries of a list for a joint both stay.

    Upstream: kinematic_constraints/utils.cpp, mergeConstraints.
    """
    twice = JointConstraint('a', 0.5, 0.01, 0.01), JointConstraint('a', 1.5, 0.01, 0.01)
    assert merged(Constraints(twice), Constraints(), log).joint_constraints == twice
    assert merged(Constraints(), Constraints(twice), log).joint_constraints == twice


def test_a_pair_is_intersected_with_every_entry(log):
    """A joint of the goal keeps to every entry of the path constraints for it."""
    both = merged(Constraints((JointConstraint('a', 0.0, 0.5, 0.5),)),
                  Constraints((JointConstraint('a', 0.0, 0.1, 1.0),
                               JointConstraint('a', 0.0, 1.0, 0.2))), log)
    joint, = both.joint_constraints
    assert joint.position - joint.tolerance_below == pytest.approx(-0.2)
    assert joint.position + joint.tolerance_above == pytest.approx(0.1)


def test_a_joint_named_twice_keeps_to_both(constraint_set):
    """The values of a joint are those that all its constraints allow."""
    made = constraint_set(joints=(JointConstraint('axis1', 0.5, 0.2, 0.2),
                                  JointConstraint('axis1', 0.8, 0.2, 0.2)))
    assert made.satisfiable
    interval, = made.intervals
    assert (interval.lower, interval.upper) == pytest.approx((0.6, 0.7))


def test_constraints_that_meet_in_a_value_but_for_rounding(six_scene, plan_for, clock):
    """
    A goal that names a joint's value twice, with different rounding, is reached.

    Upstream: default_constraint_samplers.cpp, JointConstraintSampler::configure.
    """
    goal = Constraints((JointConstraint('axis1', 0.3, 0.0, 0.0),
                        JointConstraint('axis1', 0.1 + 0.2, 0.0, 0.0)))
    response = plan_for(six_scene).plan(
        MotionPlanRequest('arm', (goal,), seed=1), six_scene, clock=clock)
    assert response.error_code == MoveItErrorCode.SUCCESS, response.message
    assert response.trajectory.positions[-1, 0] == pytest.approx(0.3)


@pytest.mark.parametrize(('second', 'satisfiable'), [(3.1, True), (-3.1, True), (2.8, False)])
def test_a_continuous_joint_named_twice(turning, log, second, satisfiable):
    """The intervals of a continuous joint meet across half a turn."""
    made = ConstraintSet(
        Constraints((JointConstraint('axis1', 3.14, 0.1, 0.1),
                     JointConstraint('axis1', second, 0.1, 0.1))),
        PlanningScene(KinematicModel(turning)), log)
    assert made.satisfiable is satisfiable


CONTRADICTING = Constraints((
    JointConstraint('axis1', 0.5, 0.01, 0.01), JointConstraint('axis1', 1.5, 0.01, 0.01),
    JointConstraint('axis2', 0.2, 0.01, 0.01)))


def test_contradicting_goal_is_refused(six_scene, plan_for, clock):
    """
    A goal that wants a joint at two values is refused, and the message names the joint.

    Upstream: default_constraint_samplers.cpp, JointConstraintSampler::configure.
    """
    response = plan_for(six_scene).plan(
        MotionPlanRequest('arm', (CONTRADICTING,), seed=1), six_scene, clock=clock)
    assert response.error_code == MoveItErrorCode.INVALID_GOAL_CONSTRAINTS
    assert "joint 'axis1'" in response.message


def test_contradicting_goal_is_never_reached(six_scene, plan_for):
    """
    No state satisfies a goal that wants a joint at two values.

    Upstream: planning_scene.cpp, isStateConstrained.
    """
    six_scene.set_positions({'axis2': 0.2})
    request = MotionPlanRequest('arm', (CONTRADICTING,))
    assert not plan_for(six_scene).goal_reached(request, six_scene)
