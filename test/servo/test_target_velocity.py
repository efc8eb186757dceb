# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint velocities of a twist, and what they make of it."""

import numpy as np
import pytest
from servo_streams import twist

from armsim_ros.model.transforms import pose_matrix
from armsim_ros.servo.commands import PoseTarget


def test_progress_is_the_share_of_the_twist_and_the_speed_along_its_way(streamer):
    """A turn beside the way does not count as length of the way."""
    made = streamer(command_in_type='speed_units')
    target, parameters = made.stream.target, made.parameters
    command = twist((0.03, 0.0, 0.04), (0.1, 0.0, 0.0), frame=target.base)
    velocity = target.wanted(command, made.q, parameters).velocity
    assert target.progress(command, made.q, velocity, parameters) == pytest.approx(
        (1.0, 0.05), rel=0.01)
    assert target.progress(command, made.q, 0.5 * velocity, parameters) == pytest.approx(
        (0.5, 0.025), rel=0.01)


@pytest.mark.parametrize('distance', [0.02, 0.05, 0.1])
def test_the_speed_towards_a_pose_allows_to_stop_there(streamer, distance):
    """Braking with 0.4 m/s^2 from there on: v^2 = 2 a d."""
    made = streamer(command_in_type='speed_units', scale={'linear': 0.0, 'rotational': 0.0})
    target = made.stream.target
    command = PoseTarget(target.tip, pose_matrix((0.0, 0.0, -distance)))
    velocity = target.wanted(command, made.q, made.parameters).velocity
    tip, period = made.tip, 1e-6
    moved = made.kinematics.link_pose(made.kinematics.insert(
        made.q, made.group, made.positions[-1] + period * velocity), target.tip)
    speed = np.linalg.norm(moved[:3, 3] - tip[:3, 3]) / period
    assert speed == pytest.approx((2.0 * 0.4 * distance)**0.5, rel=0.01)
