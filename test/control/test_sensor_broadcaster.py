# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Broadcasters of sensors and of the speed, and a trajectory controller that keeps to it."""

import numpy as np
import pytest

from armsim_ros.control.mailbox import GoalStatus
from armsim_ros.errors import ControllerError

WRENCH = 'force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster'
IMU = 'imu_sensor_broadcaster/IMUSensorBroadcaster'
POSE = 'pose_broadcaster/PoseBroadcaster'
STATES = 'state_interfaces_broadcaster/StateInterfacesBroadcaster'
SPEED = 'ur_controllers/SpeedScalingStateBroadcaster'
SCALED = 'ur_controllers/ScaledJointTrajectoryController'
FACTOR = 'speed_scaling/speed_scaling_factor'
FORCES = {f'wrist/{kind}.{axis}': 1.0 + i for i, (kind, axis) in enumerate(
    (kind, axis) for kind in ('force', 'torque') for axis in 'xyz')}


def active(rig, kind, states=(), **parameters):
    """Return joints and an active broadcaster of states."""
    made = rig()
    for name, value in dict(states).items():
        made.hardware.given_states[name] = value
    broadcaster = made.load('sensor', kind, **parameters)
    result = made.manager.switch(activate=['sensor'])
    assert result.ok, result.message
    return made, broadcaster


def samples(broadcaster):
    """Return all samples that wait."""
    return list(iter(broadcaster.poll, None))


def test_wrench_of_a_sensor(rig):
    """Six interfaces of one sensor; offsets are added, then the factors taken."""
    made, broadcaster = active(
        rig, WRENCH, FORCES, sensor_name='wrist', frame_id='tool', publish_rate=0.0,
        offset={'force': {'x': 10.0}}, multiplier={'force': {'x': 2.0}, 'torque': {'z': -1.0}},
    )
    made.step(3)
    found = samples(broadcaster)
    assert len(found) == 3
    np.testing.assert_allclose(found[-1].values, [22.0, 2.0, 3.0, 4.0, 5.0, -6.0])


def test_a_tare_shows_the_present_load_as_zero(rig):
    """What is added later shows; an offset does not come back; inactive it is refused."""
    made, broadcaster = active(
        rig, WRENCH, FORCES, sensor_name='wrist', frame_id='tool', publish_rate=0.0,
        offset={'force': {'x': 10.0}})
    assert broadcaster.tare() == ''
    made.step()
    made.hardware.given_states['wrist/force.x'] += 10.0
    made.step()
    found = samples(broadcaster)
    np.testing.assert_allclose(found[0].values, np.zeros(6))
    np.testing.assert_allclose(found[1].values, [10.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    made.manager.switch(deactivate=['sensor'])
    assert 'not active' in broadcaster.tare()


def test_axes_without_an_interface_are_nan(rig):
    """Where interfaces are named one by one, the others are not a number."""
    made, broadcaster = active(
        rig, WRENCH, FORCES, interface_names={'force': {'z': 'wrist/force.z'}}, frame_id='tool')
    assert broadcaster.required_state_interfaces == ('wrist/force.z',)
    made.step()
    (sample,) = samples(broadcaster)
    np.testing.assert_array_equal(sample.values, [np.nan, np.nan, 3.0] + [np.nan] * 3)


def test_the_effort_of_a_joint_as_a_torque(rig):
    """Re-enacts force_torque_sensor_broadcaster.cpp: interface_names are any state interfaces."""
    made, broadcaster = active(
        rig, WRENCH, interface_names={'torque': {'z': 'a/effort'}}, frame_id='tool')
    made.hardware.state.effort[0] = 2.5
    made.step()
    (sample,) = samples(broadcaster)
    np.testing.assert_array_equal(sample.values, [np.nan] * 5 + [2.5])


def test_another_sensor_from_configure_on(rig):
    """Re-enacts force_torque_sensor_broadcaster.cpp: configure reads names, update the offset."""
    made, broadcaster = active(
        rig, WRENCH, FORCES, sensor_name='wrist', frame_id='tool', publish_rate=0.0)
    broadcaster.set_parameters({
        'sensor_name': '', 'interface_names.force.z': 'a/position', 'offset.force.z': 10.0})
    made.step()
    (sample,) = samples(broadcaster)
    np.testing.assert_allclose(sample.values, [1.0, 2.0, 13.0, 4.0, 5.0, 6.0])
    made.manager.switch(deactivate=['sensor'])
    made.manager.configure('sensor')
    assert broadcaster.required_state_interfaces == ('a/position',)


def test_any_states_in_their_order(rig):
    """Re-enacts state_interfaces_broadcaster.cpp: update."""
    made, broadcaster = active(
        rig, STATES, FORCES, interfaces=['wrist/force.z', 'b/position', 'a/effort'])
    made.hardware.state.position[1], made.hardware.state.effort[0] = 0.5, 2.5
    made.step()
    (sample,) = samples(broadcaster)
    np.testing.assert_array_equal(sample.values, [3.0, 0.5, 2.5])


@pytest.mark.parametrize(('kind', 'parameters', 'words'), [
    (WRENCH, {'frame_id': 'tool'}, "'sensor_name'"),
    (WRENCH, {'sensor_name': 'wrist'}, "'frame_id'"),
    (WRENCH, {'sensor_name': 'wrist', 'interface_names': {'force': {'x': 'a/b'}}}, 'exclude'),
    (IMU, {'frame_id': 'tool'}, "'sensor_name'"),
    (IMU, {'sensor_name': 'a', 'frame_id': 'b', 'static_covariance_orientation': [1.0]},
     'static_covariance_orientation'),
    (POSE, {'frame_id': 'world'}, "'pose_name'"),
    (STATES, {}, "'interfaces'"),
    (STATES, {'interfaces': []}, "'interfaces'"),
])
def test_what_is_missing_is_named(rig, kind, parameters, words):
    """A parameter that is needed, or wrong, is told of by its name."""
    with pytest.raises(ControllerError, match=words):
        rig().load('sensor', kind, **parameters)


@pytest.mark.parametrize(('kind', 'parameters', 'lacking'), [
    (IMU, {'sensor_name': 'wrist', 'frame_id': 'tool'}, 'wrist/orientation.x'),
    (STATES, {'interfaces': ['a/position', 'a/colour']}, 'a/colour'),
])
def test_a_sensor_that_is_not_there(rig, kind, parameters, lacking):
    """Activation names the interface."""
    made = rig()
    made.load('sensor', kind, **parameters)
    result = made.manager.switch(activate=['sensor'])
    assert not result.ok
    assert lacking in result.message


def test_rate(rig):
    """So many samples a second, in the rhythm of simulated time."""
    made, broadcaster = active(rig, WRENCH, FORCES, sensor_name='wrist', frame_id='tool',
                               publish_rate=20.0)
    made.run(1.0)
    assert len(samples(broadcaster)) == 20


def test_speed_in_percent(rig):
    """The factor is there without hardware that has it; it is told in percent."""
    made, broadcaster = active(rig, SPEED)
    made.step()
    made.hardware.given_states[FACTOR] = 0.25
    made.step()
    assert [sample.values.tolist() for sample in samples(broadcaster)] == [[100.0], [25.0]]


def test_time_of_trajectories_goes_at_the_speed(rig, trajectory):
    """Half the speed takes twice the time; 0 freezes without an abort; then it goes on."""
    made = rig()
    arm = made.load('arm', SCALED, joints=['a', 'b'])
    assert FACTOR in arm.required_state_interfaces
    assert made.manager.switch(activate=['arm']).ok
    goal = arm.send_goal(trajectory((1.0, [1.0, 0.5]))).goal
    assert arm.set_speed_scaling(0.5)
    made.run(1.0)
    assert made.hardware.state.position[0] == pytest.approx(0.5, abs=0.02)
    made.hardware.given_states[FACTOR] = 0.0
    made.run(0.1)
    stopped = made.hardware.state.position.copy()
    made.run(3.0)
    np.testing.assert_allclose(made.hardware.state.position, stopped)
    assert not goal.done
    made.hardware.given_states[FACTOR] = 1.0
    made.run(1.0)
    assert goal.status is GoalStatus.SUCCEEDED


def test_no_interface_no_scaling(rig, trajectory):
    """An empty name switches the reading off."""
    made = rig()
    arm = made.load('arm', SCALED, joints=['a', 'b'], speed_scaling_interface_name='')
    assert made.manager.switch(activate=['arm']).ok
    made.hardware.given_states[FACTOR] = 0.0
    goal = arm.send_goal(trajectory((0.5, [1.0, 0.5]))).goal
    made.run(1.0)
    assert goal.status is GoalStatus.SUCCEEDED
