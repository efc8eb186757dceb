# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the process that plans beside a request that takes long."""

import os
import signal
import time

import pytest
from six_axis_requests import joint_goal, LEFT, request, RIGHT

from armsim_ros.planning import search
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.settings import PlanningSettings

LONG = 60.0
SUCCESS, TIMED_OUT, PREEMPTED = 1, -6, -7


@pytest.fixture
def endless(monkeypatch):
    """Let the search in this process never find anything; the other one's is as it is."""
    def find(_search, _start, _goals, stop):
        while not stop():
            time.sleep(1e-4)

    monkeypatch.setattr(search.RRTConnect, 'find', find)


@pytest.fixture
def planner(wall, log, request):
    """Return a planner; its delay can be given."""
    delay = getattr(request, 'param', 0.01)
    made = MotionPlanner(wall, log=log, second_attempt_delay=delay)
    yield made
    made.close()


@pytest.fixture
def planned(planner, wall):
    """Return a function that plans around the wall, within a time [s]."""
    def plan(seconds=LONG, cancelled=lambda: False, **parts):
        parts = {'seed': -1, 'allowed_planning_time': seconds, **parts}
        return planner.plan(
            request(joint_goal(RIGHT), **parts), wall.snapshot(), clock=time.monotonic,
            cancelled=cancelled)
    return plan


def pid(planner):
    """Return the number of the other process, None for none."""
    return planner._second.pid


def ended(process):
    """Return whether a process is gone, or dead and not buried yet."""
    try:
        with open(f'/proc/{process}/stat', encoding='ascii') as file:
            return file.read().rpartition(')')[2].split()[0] == 'Z'
    except FileNotFoundError:
        return True


def test_the_other_process_answers(endless, planned, planner):
    """Where the search here finds nothing the other process's trajectory is the answer."""
    response = planned()
    assert response.success, response.message
    first, last = response.trajectory.points[0], response.trajectory.points[-1]
    assert first.positions == pytest.approx(LEFT)
    assert last.positions == pytest.approx(RIGHT, abs=1e-3)
    assert 0.0 < response.planning_time < LONG
    assert pid(planner) is not None


def test_it_plans_in_the_scene_as_it_is_now(endless, planned, planner, wall, add_box):
    """Every request takes its own scene to the same process."""
    low = planned()
    process = pid(planner)
    add_box(wall, 'beam', (1.2, 0.3, 0.05), (0.5, 0.0, 0.75))
    high = planned()
    assert low.success
    assert high.success
    assert pid(planner) == process
    assert planner.path_fault(high.trajectory, 0.0, wall, 'arm') == ''


@pytest.mark.parametrize('planner', [LONG], indirect=True)
def test_quick_requests_start_nothing(planned, planner):
    """No process is started for a request that takes no longer than the delay."""
    assert planned().success
    assert pid(planner) is None


@pytest.mark.parametrize('where', ['request', 'settings'])
def test_a_seed_is_repeatable(endless, planned, planner, where):
    """What a seed makes repeatable does not depend on which process is quicker."""
    if where == 'settings':
        planner.settings = PlanningSettings(seed=1)
    assert planned(0.3, seed=1 if where == 'request' else -1).error_code == TIMED_OUT
    assert pid(planner) is None


@pytest.mark.parametrize('planner', [0.0], indirect=True)
def test_without_a_delay_there_is_none(endless, planned, planner):
    """A delay of 0 means no second attempt at all."""
    assert planned(0.3).error_code == TIMED_OUT
    assert pid(planner) is None


@pytest.mark.parametrize('planner', [1e-9], indirect=True)
@pytest.mark.parametrize('parts', [
    {'planner_id': 'RRTstar'},
    {'pipeline_id': 'pilz_industrial_motion_planner', 'planner_id': 'PTP'}])
def test_planners_that_would_win_nothing(planned, planner, parts):
    """What takes its time anyway, or knows no chance, is planned in one process."""
    planned(0.3, **parts)
    assert pid(planner) is None


def test_a_cancel_counts_more_than_an_answer(endless, planned):
    """A cancelled request is cancelled, whatever the other process does."""
    began = time.monotonic()
    response = planned(cancelled=lambda: time.monotonic() > began + 0.5)
    assert response.error_code == PREEMPTED
    assert time.monotonic() - began < 0.5 * LONG


def test_a_cancelled_attempt_leaves_the_process_free(endless, planned, planner):
    """A request that was given up does not hold up the next one."""
    assert planned().success
    process, began = pid(planner), time.monotonic()
    planned(cancelled=lambda: time.monotonic() > began + 0.05)
    assert planned().success
    assert pid(planner) == process


def test_a_process_that_dies_is_replaced(endless, planned, planner):
    """When the other process is killed, another one is started at the next need."""
    assert planned().success
    process = pid(planner)
    os.kill(process, signal.SIGKILL)
    assert planned().success
    assert pid(planner) not in (None, process)


def test_a_process_that_does_not_start_is_given_up(endless, planned, planner, log, monkeypatch):
    """Where no process can be started one line says so, and requests are planned without."""
    monkeypatch.setattr('armsim_ros.planning.second_attempt._PROGRAM', 'raise SystemExit(1)')
    assert planned(2.0).error_code == TIMED_OUT
    assert planned(0.3).error_code == TIMED_OUT
    assert log.recorder.text().count('does not start') == 1
    assert pid(planner) is None


def test_a_process_that_ended_is_buried(endless, planned, planner):
    """No dead process is left once there is another request, be it one that needs none."""
    assert planned().success
    process = planner._second._process
    process.kill()
    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
    planned(0.01, seed=1)
    assert pid(planner) is None
    assert not os.path.exists(f'/proc/{process.pid}')


@pytest.mark.parametrize('kind', ['RRTConnect', 'PRM'])
def test_what_cannot_be_told_to_the_process(endless, planned, planner, log, monkeypatch, kind):
    """Trouble with the process ends no search, in whatever thread it shows: one line tells it."""
    def refuse(_file, _message):
        raise TypeError('cannot pickle')

    monkeypatch.setattr('armsim_ros.planning.second_attempt.send', refuse)
    planner._second._delay = 1e-9
    monkeypatch.setattr(planner._second, '_ready', True)
    assert planned(2.0, planner_id=kind).error_code in (SUCCESS, TIMED_OUT)
    assert planned(0.3).error_code == TIMED_OUT
    assert log.recorder.text().count('cannot pickle') == 1
    assert pid(planner) is None


def test_it_ends_with_its_parent(endless, planned, planner):
    """A planner that is closed, and an end of file, end the process."""
    assert planned().success
    process = pid(planner)
    planner.close()
    assert ended(process)
    assert planned().success
    process = planner._second._process
    process.stdin.close()
    assert process.wait(LONG) == 0
