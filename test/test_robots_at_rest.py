# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The robots of the package hold their poses."""

import pytest

from armsim_ros import ArmSim
from armsim_ros.resources import cell_names, robot_names

#: How far a joint may move in three seconds [rad or m].
MOST = 2e-4


def moved(sim):
    """Return how far the joints move in three seconds, and the joint that moves most."""
    before = sim.joint_positions
    most = (0.0, '')
    for _ in range(30):
        sim.run_until(sim.time + 0.1)
        most = max(most, *((abs(value - before[name]), name)
                           for name, value in sim.joint_positions.items()))
    return most


@pytest.mark.parametrize('robot', [*robot_names(), *cell_names()])
def test_no_joint_sags(robot):
    """Neither at the start, nor in a named state that it has moved to."""
    sim = ArmSim(robot)
    assert moved(sim) < (MOST, ''), 'start'
    for group, states in sim.model.semantic.named_states.items():
        for state in states:
            sim.execute(sim.plan(state, group))
            sim.run_until(sim.time + 0.5)
            assert moved(sim) < (MOST, ''), state
