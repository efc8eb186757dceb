# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Arms whose trajectories are run."""

import pytest
from small_arms import planar_arm, turning_arm

from armsim_ros.kinematics.kinematic_model import KinematicModel


@pytest.fixture(scope='session')
def planar():
    """Return the kinematics of the planar arm."""
    return KinematicModel(planar_arm())


@pytest.fixture(scope='session')
def turning():
    """Return a planar arm whose joints turn without end."""
    return turning_arm()
