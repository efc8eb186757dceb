# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The warning that simulated time is not the wall clock's any more."""

import time

import pytest

from armsim_ros.nodes.simulation.sim_time import ClockHint
from armsim_ros.sim.clock import SimClock


@pytest.mark.parametrize(('ahead', 'words'), [
    (-60, ['60.0 s behind', 'use_sim_time:=true']), (60, ['60.0 s ahead']), (0, [])])
def test_a_difference_is_reported_once(monkeypatch, ahead, words):
    """Its size, its direction and the remedy, in a single warning."""
    now_ns = 10**18
    monkeypatch.setattr(time, 'time_ns', lambda: now_ns)
    texts = []
    hint = ClockHint(SimClock(1_000_000, now_ns + ahead * 10**9), texts.append)
    for _ in range(3):
        hint.look()
    assert len(texts) == bool(words)
    assert all(word in texts[0] for word in words)
