# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A six-axis arm as scripts see it, without a node."""

import pytest

from armsim_ros.config.robot_folder import find_files
from moveit.core.planning_scene import PlanningScene
from moveit.core.robot_model import RobotModel
from moveit.core.robot_state import RobotState


def pytest_configure(config):
    """Register the mark that names a statement."""
    config.addinivalue_line('markers', 'statement(*names): the statements that a test checks')


@pytest.fixture(scope='session')
def model():
    """Return the Panda of the package, from its files."""
    files = find_files('panda')
    return RobotModel(urdf_xml_path=str(files.urdf_file), srdf_xml_path=str(files.srdf_file))


@pytest.fixture
def ready(model):
    """Return a state in the pose 'ready'."""
    state = RobotState(model)
    assert state.set_to_default_values('panda_arm', 'ready')
    return state


@pytest.fixture
def scene(model, ready):
    """Return a scene without objects in which the robot is ready."""
    made = PlanningScene(model)
    made.current_state = ready
    return made
