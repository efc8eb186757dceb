# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of servo_node: where they stand, what does not go together."""

import shutil

import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.errors import ConfigError
from armsim_ros.resources import share_folder

FLAT = """
publish_period: 0.02
scale: {linear: 0.2}
lower_singularity_threshold: 20.0
butterworth_filter_coeff: 2.0
use_gazebo: true
"""
NESTED = """
servo_node:
  ros__parameters:
    moveit_servo:
      publish_period: 0.02
      scale.linear: 0.2
      lower_singularity_threshold: 20.0
    butterworth_filter_coeff: 2.0
"""
DOTTED = """
/**:
  servo_node:
    ros__parameters:
      moveit_servo.publish_period: 0.02
      moveit_servo.scale.linear: 0.2
      moveit_servo.lower_singularity_threshold: 20.0
      butterworth_filter_coeff: 2.0
"""


@pytest.fixture
def settings(tmp_path):
    """Return what reads a robot with a servo.yaml."""

    def read(text):
        folder = tmp_path / 'sunday'
        shutil.copytree(share_folder('armsim_ros') / 'config/sunday', folder)
        (folder / 'servo.yaml').write_text(text, encoding='utf-8')
        return load_robot_settings('sunday', config=folder)

    return read


@pytest.mark.parametrize('text', [FLAT, NESTED, DOTTED], ids=['flat', 'nested', 'dotted'])
def test_layouts(settings, text):
    """Flat as upstream's files, nested and dotted say the same."""
    servo = settings(text).servo
    assert servo.moveit_servo.publish_period == 0.02
    assert servo.moveit_servo.scale.linear == 0.2
    assert servo.moveit_servo.scale.rotational == 0.8
    assert servo.moveit_servo.lower_singularity_threshold == 20.0
    assert servo.butterworth_filter_coeff == 2.0


def test_all_mistakes_at_once(settings):
    """What does not go together is told together."""
    with pytest.raises(ConfigError) as caught:
        settings(
            'lower_singularity_threshold: 40.0\n'
            'publish_joint_positions: false\npublish_joint_velocities: false\n'
            'max_expected_latency: 0.02\n'
        )
    text = str(caught.value)
    assert 'hard_stop_singularity_threshold' in text
    assert 'publish_joint_positions' in text
    assert 'max_expected_latency (0.02 s) has to be at least three times publish_period (0' in text


def test_unknown_key(settings):
    """A misspelt key is left out with a remark that has the right one."""
    remarks = ' '.join(str(remark) for remark in settings('publish_perod: 0.02\n').remarks)
    assert "did you mean 'publish_period'" in remarks
