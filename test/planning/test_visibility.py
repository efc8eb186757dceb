# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of visibility constraints; upstream's are in moveit_core's test_constraints.cpp."""

from dataclasses import replace
import math

import numpy as np
import pytest
from trajectory_judge import between

from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.request import (
    Constraints,
    JointConstraint,
    MotionPlanRequest,
    VisibilityConstraint,
)
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, ObjectShape
from armsim_ros.planning.scene.update import StartState

DOWN = (math.pi, 0.0, 0.0)
STRAIGHT, ASIDE = np.zeros(3), np.array([1.0, 0.0, 0.0])
#: A camera above the middle of the arm's second segment, and a disc below it.
ABOVE = VisibilityConstraint(
    0.05, pose_matrix((0.55, 0.0, -0.5)), 'base', pose_matrix((0.55, 0.0, 1.0), DOWN), 'base', 10)


@pytest.fixture
def evaluate(constraint_set):
    """Return a function that evaluates a visibility constraint in a state of the planar arm."""
    def at(given, q=ASIDE):
        made = constraint_set(visibilities=(given,))
        result, = made.evaluate(q)
        assert made.satisfied(q) is result.satisfied
        assert bool(made.violation(q)) is not result.satisfied
        return result
    return at


def test_a_link_in_the_cone(evaluate):
    """
    A link between sensor and target violates it, by how far it reaches in; beside it is free.

    Upstream: VisibilityConstraintsPR2.
    """
    assert evaluate(ABOVE, ASIDE).satisfied
    result = evaluate(ABOVE, STRAIGHT)
    assert not result.satisfied
    assert result.distance > 0.01
    assert "'segment2' is between the sensor" in result.text


def test_a_link_that_fills_the_cone(evaluate):
    """A link around the whole cone, or wholly inside of it, is in between."""
    assert not evaluate(replace(ABOVE, target_radius=1e-4), STRAIGHT).satisfied
    assert not evaluate(replace(ABOVE, target_radius=3.0), ASIDE).satisfied


@pytest.mark.parametrize(('tilt', 'kept'), [(0.0, True), (0.06, True), (0.12, False),
                                            (math.pi, False)])
def test_view_angle(evaluate, tilt, kept):
    """
    The disc faces the sensor within max_view_angle.

    Upstream: VisibilityConstraintsSimple.
    """
    given = replace(ABOVE, target_pose=pose_matrix((0.55, 0.0, -0.5), (0.0, tilt, 0.0)))
    assert evaluate(given).satisfied
    assert evaluate(replace(given, max_view_angle=0.1)).satisfied is kept


@pytest.mark.parametrize(('aside', 'kept'), [(0.1, True), (0.2, False)])
def test_range_angle(evaluate, aside, kept):
    """The disc is within max_range_angle of the sensor's axis, and not behind the sensor."""
    given = replace(ABOVE, max_range_angle=0.1,
                    target_pose=pose_matrix((0.55 + aside, 0.0, -0.5)))
    assert evaluate(given).satisfied is kept
    behind = replace(ABOVE, max_range_angle=3.0, target_pose=pose_matrix((0.55, 0.0, 2.0)))
    assert not evaluate(behind).satisfied


@pytest.mark.parametrize(('direction', 'rpy'), [
    (0, DOWN), (1, (-0.5 * math.pi, 0.0, 0.0)), (2, (0.0, 0.5 * math.pi, 0.0))])
def test_axis_of_view(evaluate, direction, rpy):
    """sensor_view_direction 0, 1, 2 is the sensor's z, y, x axis."""
    given = replace(ABOVE, sensor_view_direction=direction, max_view_angle=0.01,
                    sensor_pose=pose_matrix((0.55, 0.0, 1.0), rpy))
    assert evaluate(given).satisfied
    assert not evaluate(replace(given, sensor_view_direction=(direction + 1) % 3)).satisfied


def test_the_links_of_sensor_and_target_may_be_in_the_cone(evaluate):
    """
    A target on a link sees past that link; a larger disc meets the next one.

    Upstream: VisibilityConstraintsPR2, the end; kinematic_constraint.cpp, decideContact.
    """
    on_last = replace(ABOVE, target_frame_id='segment3', target_pose=pose_matrix((0.1, 0.0, 0.0)))
    for q in (STRAIGHT, ASIDE):
        assert evaluate(on_last, q).satisfied
        assert not evaluate(replace(on_last, target_radius=0.2), q).satisfied


def test_an_attached_object_does_not_block(planar_scene, evaluate):
    """
    What the arm carries is not in the way, nor is the world.

    Upstream: kinematic_constraint.cpp, decideContact.
    """
    for name, place in (('carried', (0.55, 0.0, 0.4)), ('wall', (0.55, 0.0, 0.6))):
        planar_scene.apply_object(CollisionObject(
            name, 0, 'base', pose=pose_matrix(place), shapes=(ObjectShape(Box((0.1,) * 3)),)))
    planar_scene.apply_attached(AttachedObject('tool', CollisionObject('carried')))
    assert evaluate(ABOVE).satisfied


def test_what_cannot_be_used(constraint_set, log):
    """
    Without radius and angles it counts as satisfied; a number that is none never does.

    Upstream: kinematic_constraint.cpp, enabled; VisibilityConstraintsSimple, the beginning.
    """
    for given, kept, text in (
        (replace(ABOVE, target_radius=0.0), True, 'are 0'),
        (replace(ABOVE, target_radius=math.nan), False, 'not finite'),
        (replace(ABOVE, sensor_view_direction=3), False, 'is not 0 (z)'),
    ):
        made = constraint_set(visibilities=(given,))
        assert made.satisfied(STRAIGHT) is kept
        assert text in made.unusable[0]
    few = replace(ABOVE, target_radius=-0.05, cone_sides=0)
    made = constraint_set(visibilities=(few,))
    assert 'using 3' in log.recorder.text()
    assert not made.satisfied(STRAIGHT)


@pytest.mark.parametrize('seed', range(3))
def test_a_plan_keeps_the_view_free(planar, planar_scene, plan_for, constraint_set, clock, seed):
    """
    A plan whose straight way crosses the view goes around it.

    Motions are checked in steps: between two of them a link may touch the cone.
    """
    joints = ('axis1', 'axis2', 'axis3')
    start, end = (-0.6, 0.0, 0.0), (0.6, 0.0, 0.0)
    kept = Constraints(visibility_constraints=(ABOVE,))
    goal = Constraints(tuple(
        JointConstraint(name, value, 1e-3, 1e-3)
        for name, value in zip(joints, end, strict=True)))
    request = MotionPlanRequest(
        'arm', (goal,), StartState(joints, start), path_constraints=kept, seed=seed)
    response = plan_for(planar_scene).plan(request, planar_scene, clock=clock)
    assert response.success, response.message
    made = constraint_set(visibilities=(ABOVE,))
    assert not made.satisfied(STRAIGHT)
    for t in np.linspace(0.0, response.trajectory.duration, 200):
        q = planar.vector(dict(zip(joints, between(response.trajectory, t), strict=True)))
        result, = made.evaluate(q)
        assert result.satisfied or result.distance < 1e-3, result.text


@pytest.mark.parametrize('sides', [3, 4, 5])
def test_the_cone_has_its_sides_all_around(evaluate, sides):
    """Turned by the angle between two of its sides it is the same cone."""
    beside = pose_matrix((0.55, 0.06, 1.0), DOWN)
    given = replace(ABOVE, target_radius=0.2, cone_sides=sides, sensor_pose=beside)
    found = [evaluate(replace(given, target_pose=pose_matrix(
        (0.55, 0.13, -0.5), (0.0, 0.0, 2.0 * math.pi * turn / sides))), STRAIGHT)
        for turn in range(sides)]
    assert len({result.satisfied for result in found}) == 1
    assert np.ptp([result.distance for result in found]) < 1e-3
