# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""SRV-10: arms that cannot turn and move their tip in every way."""

import numpy as np
import pytest
from servo_streams import Streamer, twist

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.loading import load_robot_model
from armsim_ros.servo.commands import ServoStatus

FREE = {'command_in_type': 'speed_units', 'check_collisions': False}


@pytest.fixture(scope='module')
def arm():
    """Return the kinematics of an arm of five joints, its group, and a posture with a bend."""
    settings = load_robot_settings('bot')
    kinematics = KinematicModel(
        planning_robot(load_robot_model(settings), settings.joint_limits))
    assert len(kinematics.group_indices('arm')) == 5
    return kinematics, 'arm', np.array([0.2, -1.0, 1.6, 0.9, 0.2])


@pytest.fixture
def fewer(arm):
    """Return a stream for it."""
    kinematics, group, start = arm
    return Streamer(kinematics, start, group, **FREE)


def test_it_moves_and_says_nothing_is_wrong(fewer):
    """A twist that it can do is done, with status 0 and not a halt for a singularity."""
    jacobian = fewer.kinematics.jacobian(fewer.q, fewer.stream.target.tip, fewer.group)
    wanted = jacobian @ (0.05 * (-1.0) ** np.arange(jacobian.shape[1]))
    base = fewer.kinematics.link_pose(fewer.q, fewer.stream.target.base)[:3, :3]
    before = fewer.tip
    fewer.run(twist(base.T @ wanted[:3], base.T @ wanted[3:], fewer.stream.target.base), 0.5)
    moved = fewer.tip[:3, 3] - before[:3, 3]
    assert fewer.codes() <= {ServoStatus.NO_WARNING}
    assert moved @ wanted[:3] > 0.8 * np.linalg.norm(moved) * np.linalg.norm(wanted[:3])


@pytest.mark.parametrize('axis', range(3))
def test_translation_comes_before_rotation(fewer, axis):
    """What cannot be had together is given up in the rotation first."""
    jacobian = fewer.kinematics.jacobian(fewer.q, fewer.stream.target.tip, fewer.group)
    wanted = 0.03 * np.eye(3)[axis]
    base = fewer.kinematics.link_pose(fewer.q, fewer.stream.target.base)[:3, :3]
    fewer.run(twist(base.T @ wanted, (0, 0, 0), fewer.stream.target.base), 0.3)
    speed = jacobian @ fewer.cycles[-1].velocities
    best = jacobian @ np.linalg.lstsq(jacobian, [*wanted, 0, 0, 0], rcond=None)[0]
    assert np.linalg.norm(speed[:3] - wanted) <= np.linalg.norm(best[:3] - wanted) + 3e-3
