# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The robot that comes with the package, and streams to it."""

import pytest
from servo_streams import Streamer

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.loading import load_robot_model


@pytest.fixture(scope='session')
def kinematics():
    """Return the robot's kinematics."""
    settings = load_robot_settings('sunday')
    return KinematicModel(planning_robot(load_robot_model(settings), settings.joint_limits))


@pytest.fixture
def streamer(kinematics):
    """Return what makes streams."""

    def make(**parameters):
        return Streamer(kinematics, **parameters)

    return make
