# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The robot that comes with the package, and streams to it."""

import pytest
from servo_streams import Streamer

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.loading import load_robot_model


@pytest.fixture(scope='session')
def kinematics():
    """Return the robot's kinematics."""
    return KinematicModel(load_robot_model(load_robot_settings('sunday')))


@pytest.fixture
def streamer(kinematics):
    """Return what makes streams."""

    def make(**parameters):
        return Streamer(kinematics, **parameters)

    return make
