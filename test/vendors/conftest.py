# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arm of the tests of its program and its slider."""

from types import SimpleNamespace

import pytest
from ur_arm import JOINTS, PACE, SCALED

from armsim_ros.stack import ArmSim


@pytest.fixture
def sim():
    """Return an arm of Universal Robots with a scaled controller beside its own."""
    sim = ArmSim('sunday', overrides={'simulation.hardware.vendor': 'ur'})
    sim.manager.load(SimpleNamespace(
        name=SCALED, type='ur_controllers/ScaledJointTrajectoryController', parameters={
            'joints': JOINTS, 'command_interfaces': ['position'],
            'state_interfaces': ['position', 'velocity'],
            'speed_scaling_interface_name': PACE}))
    sim.manager.configure(SCALED)
    return sim
