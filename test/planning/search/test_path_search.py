# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of what a search keeps from objects, and of when it searches once more."""

import numpy as np
import pytest

from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.planning.budget import Budget
from armsim_ros.planning.collision.state_validity import CLEARANCE, HULL_CLEARANCE
from armsim_ros.planning.context import PlanningContext
from armsim_ros.planning.request import Constraints, JointConstraint, MotionPlanRequest
from armsim_ros.planning.scene.update import StartState
from armsim_ros.planning.search import path_search
from armsim_ros.planning.search.path_search import search, SearchProblem, stages
from armsim_ros.planning.search.planners import PlannerChoice
from armsim_ros.planning.search.shortening import path_length

STRAIGHT = np.zeros(3)
LEFT, RIGHT = np.array([-0.9, 0.2, 0.2]), np.array([0.9, 0.2, 0.2])
TIP = 0.86
"""Distance [m] of the last link's end from the base, its half width aside."""


@pytest.fixture
def validity(planar_scene, log):
    """Return what judges the planar arm's states; boxes may be added before."""
    return PlanningContext(planar_scene, log=log).validity(planar_scene, 'arm')


@pytest.fixture
def post(planar_scene, add_box):
    """Put a post between LEFT and RIGHT."""
    add_box(planar_scene, 'post', (0.05, 0.05, 0.3), (0.55, 0.0, 0.0))


@pytest.fixture
def problem(validity, clock, log):
    """Return a function that makes a problem of a start and a goal."""
    def make(seed=0, start=LEFT, goal=RIGHT):
        validity.keep_clear([start, goal])
        return SearchProblem(
            validity, start, (goal,), PlannerChoice(), np.random.default_rng(seed),
            Budget(clock, 5.0, lambda: False), log)
    return make


@pytest.fixture
def found(problem):
    """Return a function that searches by one stage after another: (waypoints, stage)."""
    def find(seed, start=LEFT, goal=RIGHT):
        asked = problem(seed, start, goal)
        return next(
            (path, stage) for stage in stages(asked)
            if (path := search(asked, stage)) is not None)
    return find


@pytest.fixture
def planned(planar_scene, post, plan_for, clock):
    """Return a function that plans from LEFT to RIGHT."""
    names = ('axis1', 'axis2', 'axis3')

    def plan():
        goal = Constraints(tuple(
            JointConstraint(name, value, 1e-4, 1e-4)
            for name, value in zip(names, RIGHT, strict=True)))
        request = MotionPlanRequest(
            'arm', (goal,), StartState(names, tuple(LEFT)), allowed_planning_time=100.0, seed=1)
        return plan_for(planar_scene).plan(request, planar_scene, clock=clock)
    return plan


@pytest.mark.parametrize(('gap', 'clearances'), [
    (0.02, [CLEARANCE, HULL_CLEARANCE, CLEARANCE, CLEARANCE]),
    (0.003, [CLEARANCE, CLEARANCE, CLEARANCE]),
    (0.0005, [0.0, 0.0, 0.0]),
])
def test_motions_keep_what_their_ends_keep(planar_scene, add_box, problem, gap, clearances):
    """A path stays clear of objects, but of none more than its start and its goal do."""
    add_box(planar_scene, 'ahead', (0.1, 0.1, 0.1), (TIP + gap + 0.05, 0.0, 0.0))
    asked = list(stages(problem(0, np.array([1.5, 0.0, 0.0]), STRAIGHT)))
    first = next(k for k, stage in enumerate(asked) if stage.last)
    assert asked[0].straight
    assert [stage.clearance for stage in asked[:first + 1]] == clearances


def test_stages_look_closer_and_closer(problem):
    """Hulls come before shapes, and what was found is checked in ever smaller steps."""
    asked = list(stages(problem()))
    first = next(k for k, stage in enumerate(asked) if stage.last)
    assert [stage.exact for stage in asked[:first + 1]] == [False] * first + [True]
    fine = [stage.fine_step for stage in asked]
    assert fine == sorted(fine, reverse=True)


def test_hulls_are_kept_away_from_farther(planar_scene, add_box, validity):
    """A motion that passes an object at 3 mm is blocked on hulls and free on exact shapes."""
    corner = float(np.hypot(TIP, 0.02))
    add_box(planar_scene, 'ahead', (0.1, 0.02, 0.1), (corner + 0.003 + 0.05, 0.0, 0.0))
    first, second = np.array([-0.4, 0.0, 0.0]), np.array([0.4, 0.0, 0.0])
    assert not validity.motion_free(first, second, exact=False, clearance=HULL_CLEARANCE)
    assert validity.motion_free(first, second, exact=False, clearance=CLEARANCE)
    assert validity.motion_free(first, second)


def test_a_straight_line_may_be_closer(planar_scene, add_box, found):
    """Only a search keeps half a centimetre away; a straight line that is free is taken."""
    corner = float(np.hypot(TIP, 0.02))
    add_box(planar_scene, 'ahead', (0.1, 0.02, 0.1), (corner + 0.003 + 0.05, 0.0, 0.0))
    first, second = np.array([-0.4, 0.0, 0.0]), np.array([0.4, 0.0, 0.0])
    waypoints, stage = found(0, first, second)
    assert stage.straight
    assert np.array_equal(waypoints, [first, second])


def test_closer_where_there_is_no_way_otherwise(monkeypatch, post, found):
    """Where no way was found half a centimetre from everything, one is found closer by."""
    monkeypatch.setattr(path_search, '_FEW_MOTIONS', 0)
    waypoints, stage = found(0)
    assert len(waypoints) > 2
    assert not stage.exact
    assert stage.clearance == CLEARANCE


def test_a_detour_is_searched_twice(monkeypatch, post, found):
    """A second search of a path that is a detour never makes it longer, and often shorter."""
    twice = np.array([path_length(found(seed)[0]) for seed in range(12)])
    monkeypatch.setattr(path_search, '_DETOUR', np.inf)
    once = np.array([path_length(found(seed)[0]) for seed in range(12)])
    assert np.all(twice <= once + 1e-9)
    assert np.any(twice < 0.99 * once)


@pytest.mark.parametrize(('failures', 'code'), [
    (4, MoveItErrorCode.SUCCESS), (100, MoveItErrorCode.INVALID_MOTION_PLAN)])
def test_a_motion_that_is_not_free_is_searched_again(monkeypatch, planned, failures, code):
    """Where the motion along a path is not free others are searched, finely, for a while."""
    steps = []
    time_waypoints = path_search.time_waypoints

    def refuse(path, validity, limits, speed_limit, step, rough, **options):
        steps.append(step)
        if len(steps) <= failures:
            raise PlanningError(MoveItErrorCode.INVALID_MOTION_PLAN, 'not free', 'test')
        return time_waypoints(path, validity, limits, speed_limit, step, rough, **options)

    monkeypatch.setattr(path_search, 'time_waypoints', refuse)
    response = planned()
    assert response.error_code == code
    assert steps == sorted(steps, reverse=True)
    assert 2 < len(steps) < 80
