# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A simulation by the arguments of ros2_control_node."""

from pathlib import Path

import pytest
import yaml

from armsim_ros.nodes.originals.node_parameters import read_node_arguments
from armsim_ros.nodes.originals.ros2_control_node import simulation_words

CONTROLLERS = """
controller_manager:
  ros__parameters:
    states: {type: joint_state_broadcaster/JointStateBroadcaster}
    arm: {type: joint_trajectory_controller/JointTrajectoryController}
"""


@pytest.mark.parametrize(('told', 'spawned'), [('true', ['states']), ('false', [])])
def test_the_broadcaster_that_no_spawner_starts_is_active_at_once(tmp_path, told, spawned):
    """Controllers wait for spawners; a broadcaster that the launch lacks one for does not."""
    file = tmp_path / 'controllers.yaml'
    file.write_text(CONTROLLERS)
    arguments = read_node_arguments(
        ['--params-file', str(file), '-p', f'armsim.joint_states:={told}'], 'controller_manager')
    words = simulation_words('<robot name="r"/>', arguments, tmp_path)
    folder = Path(words[0].removeprefix('robot:='))
    content = yaml.safe_load((folder / 'config' / 'simulation.yaml').read_text())
    assert content['spawn'] == spawned
