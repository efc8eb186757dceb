# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sensors on links: what they measure of the physics."""

import numpy as np
import pytest

from armsim_ros.errors import SimulationError
from armsim_ros.model.transforms import matrix_from_quat_xyzw
from armsim_ros.stack import ArmSim

SENSORS = {
    'wrist': {'type': 'force_torque', 'link': 'link_6'},
    'imu': {'type': 'imu', 'link': 'link_3'},
    'tcp': {'type': 'pose', 'link': 'link_6'},
}


@pytest.fixture(scope='module')
def sim():
    """Return an arm with one sensor of each kind."""
    made = ArmSim('sunday', overrides={'simulation.sensors': SENSORS})
    made.run_until(0.3)
    return made


def read(sim, *names):
    """Return the values of some interfaces."""
    return np.array([sim.simulation.other_states[name] for name in names])


def vector(sim, sensor, quantity, parts='xyz'):
    """Return a quantity of a sensor."""
    return read(sim, *(f'{sensor}/{quantity}.{part}' for part in parts))


def test_weight_pulls_down(sim):
    """At rest the wrist carries the weight of all that is beyond it, in its own axes."""
    robot = sim.model
    beyond, weight = {'link_6'}, 0.0
    for joint in robot.joints.values():
        if joint.parent in beyond:
            beyond.add(joint.child)
    for link in beyond:
        inertial = robot.links[link].inertial
        weight += inertial.mass * 9.8 if inertial is not None else 0.0
    axes = sim.simulation.link_pose('link_6')[:3, :3]
    np.testing.assert_allclose(
        axes @ vector(sim, 'wrist', 'force'), [0.0, 0.0, -weight], atol=0.02 * weight + 1e-3)


def test_push_is_felt(sim):
    """A push at the hand shows as such, and as its torque about the sensor."""
    before, torque = vector(sim, 'wrist', 'force'), vector(sim, 'wrist', 'torque')
    sim.simulation.apply_wrench('link_6', force=(5.0, 0.0, 0.0))
    sim.step(500)
    felt = vector(sim, 'wrist', 'force') - before
    turned = vector(sim, 'wrist', 'torque') - torque
    sim.simulation.apply_wrench('link_6')
    axes = sim.simulation.link_pose('link_6')[:3, :3]
    np.testing.assert_allclose(axes @ felt, [5.0, 0.0, 0.0], atol=0.1)
    lever = sim.model.links['link_6'].inertial.origin[:3, 3]
    np.testing.assert_allclose(turned, np.cross(lever, felt), atol=0.02)


def test_gravity_and_rotation(sim):
    """At rest an IMU measures what holds it up, and no rotation."""
    sim.run_until(sim.time + 0.5)
    turn = matrix_from_quat_xyzw(vector(sim, 'imu', 'orientation', 'xyzw'))
    np.testing.assert_allclose(
        turn[:3, :3] @ vector(sim, 'imu', 'linear_acceleration'), [0.0, 0.0, 9.8], atol=0.01)
    np.testing.assert_allclose(vector(sim, 'imu', 'angular_velocity'), 0.0, atol=1e-3)


def test_turning_is_measured(sim):
    """A turn about the upright first joint shows about the upright axis."""
    goals = sim.send_trajectory(sim.plan({'joint_1': 0.6}, velocity=0.5))
    sim.step(200)
    turn = matrix_from_quat_xyzw(vector(sim, 'imu', 'orientation', 'xyzw'))
    speed = turn[:3, :3] @ vector(sim, 'imu', 'angular_velocity')
    measured = sim.simulation.state.velocity[sim.simulation.index['joint_1']]
    np.testing.assert_allclose(np.abs(speed), [0.0, 0.0, abs(measured)], atol=0.02)
    assert abs(measured) > 0.05
    sim.run_until(lambda: all(goal.done for goal in goals))


def test_pose_in_the_model_frame(sim):
    """A pose is that of forward kinematics."""
    pose = sim.link_pose('link_6')
    np.testing.assert_allclose(vector(sim, 'tcp', 'position'), pose[:3, 3], atol=1e-6)
    turn = matrix_from_quat_xyzw(vector(sim, 'tcp', 'orientation', 'xyzw'))
    np.testing.assert_allclose(turn[:3, :3], pose[:3, :3], atol=1e-6)


def test_reading_changes_nothing():
    """A run in which sensors are read is the same as one in which nobody looks."""
    digests = []
    for looks in (False, True):
        made = ArmSim('sunday', overrides={'simulation.sensors': SENSORS})
        for _ in range(20):
            made.step(10)
            if looks:
                assert np.isfinite(list(made.simulation.other_states.values())).all()
        digests.append(made.digest())
    assert digests[0] == digests[1]


def test_unknown_link():
    """The message names the sensor, the link and the nearest one that exists."""
    with pytest.raises(SimulationError, match=r"'wrist' sits on 'link_66'.*link_6"):
        ArmSim('sunday', overrides={
            'simulation.sensors': {'wrist': {'type': 'imu', 'link': 'link_66'}}})
