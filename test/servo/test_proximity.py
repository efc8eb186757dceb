# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How much slower a motion is near a collision, and what need not be looked at again."""

import numpy as np
import pytest
from servo_streams import ELBOW_UP, GROUP, Streamer

from armsim_ros.servo.commands import ServoStatus
from armsim_ros.servo.speed_limits import Proximity

THRESHOLDS = (0.01, 0.02)


@pytest.fixture
def made(kinematics):
    """Return an arm between boxes."""
    made = Streamer(kinematics)
    made.add_box('left', (0.1, 0.1, 0.4), (0.3, 0.3, 1.4))
    made.add_box('right', (0.1, 0.1, 0.4), (0.3, -0.4, 1.4))
    made.add_box('table', (1.5, 1.5, 0.03), (0.0, 0.0, 1.0))
    return made


def proximity(made):
    """Return what has looked at nothing yet."""
    return Proximity(made.checker, GROUP, *THRESHOLDS)


def walk(made, count):
    """Yield robot states in small steps, among which some touch."""
    random, joints = np.random.default_rng(7), np.array(ELBOW_UP)
    velocity = np.zeros(len(joints))
    for _ in range(count):
        velocity = 0.9 * velocity + random.uniform(-0.02, 0.02, len(joints))
        joints = np.clip(joints + velocity, -1.8, 1.8)
        yield made.kinematics.insert(made.kinematics.default(), GROUP, joints)


def test_what_was_proved_is_true(made):
    """Who remembers states that were clear finds the same as who looks at every one."""
    remembers = proximity(made)
    found = []
    before = made.q
    for q in walk(made, 300):
        factor, finding = remembers.factor(before, q)
        assert (factor, finding) == proximity(made).factor(before, q)
        found.append(factor)
        before = q
    assert min(found) == 0.0
    assert max(found) == 1.0
    assert any(0.0 < factor < 1.0 for factor in found)


def test_clear_states_are_not_looked_at_again(made, monkeypatch):
    """A small motion where nothing is near asks for no distance."""
    remembers, q = proximity(made), made.q
    assert remembers.factor(q, q) == (1.0, None)
    monkeypatch.setattr(made.checker, 'pair_distances', None)
    assert remembers.factor(q, q + 1e-3) == (1.0, None)
    with pytest.raises(TypeError):
        remembers.factor(q, q + 1.0)


def test_an_object_that_comes_is_seen_at_once(made):
    """What was proved holds for one scene only."""
    remembers, q = proximity(made), made.q
    assert remembers.factor(q, q) == (1.0, None)
    tip = made.tip[:3, 3]
    made.add_box('new', (0.05, 0.05, 0.05), tip)
    factor, finding = remembers.factor(q, q)
    assert (factor, finding.code) == (0.0, ServoStatus.HALT_FOR_COLLISION)
    assert "'new'" in finding.detail
