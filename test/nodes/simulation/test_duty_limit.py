# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How much a thread of real-time priority may compute."""

from types import SimpleNamespace

import pytest

from armsim_ros.nodes.simulation import threads as priority_watch
from armsim_ros.nodes.simulation.threads import DutyLimit


@pytest.fixture
def clocks(monkeypatch):
    """Give clocks that the test moves, and the rests that were taken."""
    clocks = SimpleNamespace(wall=100.0, used=5.0, rests=[])
    monkeypatch.setattr(priority_watch, 'time', SimpleNamespace(
        monotonic=lambda: clocks.wall, thread_time=lambda: clocks.used, sleep=clocks.rests.append
    ))
    return clocks


def run(limit, clocks, wall, used):
    """Let time pass and look."""
    clocks.wall += wall
    clocks.used += used
    limit.rest()


def test_a_busy_thread_rests(clocks):
    """Who computes all the time has to sleep until it comes down to the share."""
    limit = DutyLimit(share=0.8, window=0.1)
    limit.rest()
    run(limit, clocks, 0.15, 0.15)
    assert clocks.rests == [pytest.approx(0.0375)]


def test_an_idle_thread_does_not_rest(clocks):
    """It computes less than the share, has just begun, or was not asked for a while."""
    limit = DutyLimit(share=0.8, window=0.1)
    limit.rest()
    run(limit, clocks, 0.05, 0.05)
    assert clocks.rests == []
    run(limit, clocks, 0.1, 0.02)
    run(limit, clocks, 0.25, 0.25)
    assert clocks.rests == []
