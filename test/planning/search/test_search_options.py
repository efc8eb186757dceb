# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of what ompl_planning.yaml says about a search: which one, and for how long."""

import itertools

import pytest
from six_axis_requests import joint_goal, request, RIGHT

from armsim_ros.planning.context import PlanningPipeline, PlanningSettings
from armsim_ros.planning.search import path_search
from armsim_ros.planning.search.planners import PlannerTable


@pytest.fixture
def planned(wall, plan_for, clock):
    """Return a function that plans around the wall with an RRTConnect of some settings."""
    def plan(cancelled=lambda: False, time=1.0, **parameters):
        settings = PlanningSettings({'ompl': PlanningPipeline(planners=PlannerTable(
            {'arm': {'type': 'geometric::RRTConnect', **parameters}}))})
        return plan_for(wall, settings).plan(
            request(joint_goal(RIGHT), allowed_planning_time=time), wall, clock=clock,
            cancelled=cancelled)
    return plan


@pytest.fixture
def without_own_search(monkeypatch):
    """Take away the search of this package."""
    class Missing:
        def __init__(self, *_parts):
            raise AssertionError('the search of this package was asked')

    monkeypatch.setattr(path_search, 'RRTConnect', Missing)


def test_adaptive_domains_are_the_default(planned, without_own_search):
    """RRTConnect is the search of this package unless something else is asked for."""
    with pytest.raises(AssertionError, match='of this package'):
        planned()


@pytest.mark.parametrize('off', [False, 0, 'false'])
def test_without_adaptive_domains(planned, without_own_search, off):
    """With ``adaptive_domains`` off RRTConnect is OMPL's own, and it finds a way, too."""
    assert planned(adaptive_domains=off).success


def test_with_adaptive_domains(planned):
    """With ``adaptive_domains`` on RRTConnect finds a way."""
    assert planned(adaptive_domains=True).success


def test_other_planners_have_no_adaptive_domains(planned, log):
    """A planner that has no such parameter says so."""
    assert planned(type='geometric::RRT', adaptive_domains=True).success
    assert "has no parameter 'adaptive_domains'" in log.recorder.text()


def test_an_answer_comes_at_once(planned):
    """By default the first path is the answer; the allowed time is not used up."""
    assert planned().planning_time < 0.5


@pytest.mark.parametrize('kind', ['AORRTC', 'InformedRRTstar', 'RRTstar'])
def test_a_planner_that_shortens_takes_a_small_part_of_a_long_time(planned, kind):
    """It stops after as many motions as another search that finds nothing."""
    answer = planned(type=f'geometric::{kind}', adaptive_domains=False, time=20.0)
    assert answer.success
    assert answer.planning_time < 2.0


def test_anytime_uses_the_time_for_a_shorter_path(planned):
    """With ``anytime`` the time that is left goes into a path that is no longer."""
    quick, long = planned(), planned(anytime=True)
    assert long.success
    assert long.path_length <= quick.path_length + 1e-9
    assert quick.planning_time < long.planning_time < 1.5


def test_anytime_can_be_cancelled(planned):
    """The search for a shorter path ends when it is cancelled."""
    asked = itertools.count()
    assert planned(lambda: next(asked) > 1500, anytime=True).error_code == -7


@pytest.mark.parametrize('kind', ['PRM', 'PRMstar', 'RRTstar', 'KPIECE', 'RRTConnect'])
@pytest.mark.parametrize('asks', [5, 12, 40, 150])
def test_cancel_in_any_search(planned, kind, asks):
    """A cancel ends every planner's search, those with threads of their own, too."""
    asked = itertools.count()
    response = planned(
        lambda: next(asked) > asks, type=f'geometric::{kind}', adaptive_domains=False)
    assert response.error_code in (-7, 1)


@pytest.mark.parametrize('tolerance', [0.1, 0.005, 0.0])
def test_path_tolerance_bounds_the_way_round_corners(wall, plan_for, clock, tolerance):
    """
    The timed motion is no further from the path's corners than path_tolerance, nor 0.05 rad.

    Upstream: add_time_optimal_parameterization.cpp.
    """
    seen = []
    timed = path_search.time_waypoints

    def spy(*parts, **options):
        seen.append(options['max_deviation'])
        return timed(*parts, **options)

    settings = PlanningSettings({'ompl': PlanningPipeline(path_tolerance=tolerance)})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(path_search, 'time_waypoints', spy)
        answer = plan_for(wall, settings).plan(request(joint_goal(RIGHT)), wall, clock=clock)
    assert answer.success
    assert set(seen) == {min(tolerance, 0.05)}
