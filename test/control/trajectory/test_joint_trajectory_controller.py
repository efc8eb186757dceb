# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How the joint trajectory controller follows, holds and tells."""

import math

import numpy as np
import pytest

from armsim_ros.errors import ControllerError
from armsim_ros.model.robot_model import JointType

MOVE = (1.0, [0.4, 0.0], [0, 0], [0, 0])


def test_holds_on_activation(rig):
    """C3, C10: activation moves nothing; the reference is where the joints are, error 0."""
    r = rig()
    r.hardware.state.position[:] = [0.3, -0.2]
    arm = r.arm()
    r.run(0.5)
    snapshot = arm.snapshot()
    np.testing.assert_array_equal(snapshot.reference.positions, [0.3, -0.2])
    np.testing.assert_array_equal(snapshot.error.positions, [0.0, 0.0])
    np.testing.assert_array_equal(r.hardware.state.position, [0.3, -0.2])


@pytest.mark.parametrize(('last_command', 'expected'), [(True, 0.5), (False, 0.3)])
def test_activation_prefers_the_last_command(rig, last_command, expected):
    """C3, B11: the last command is held where there is one, unless the parameter says no."""
    r = rig()
    r.hardware.state.position[:] = 0.3
    r.hardware.command.position[:] = 0.5
    arm = r.arm(set_last_command_interface_value_as_state_on_activation=last_command)
    assert arm.snapshot().reference.positions[0] == expected


def test_command_leads_the_reference_by_a_period(rig, trajectory):
    """E1, E3: it starts with the next update; the output is the reference one period ahead."""
    r = rig()
    arm = r.arm()
    arm.send_goal(trajectory((1.0, [1.0, 0.0])))
    r.step()
    first = arm.snapshot()
    assert first.reference.positions[0] == 0.0
    assert first.output.positions[0] == pytest.approx(0.01)
    r.step()
    assert arm.snapshot().reference.positions[0] == pytest.approx(0.01)


def test_feedforward_tells_how_the_command_moves(rig, trajectory):
    """Velocity and acceleration of the command go with it, and rest after the end."""
    r = rig()
    arm = r.arm()
    arm.send_goal(trajectory(MOVE))
    r.run(0.5)
    assert r.hardware.feedforward.velocity[0] == pytest.approx(0.75, rel=1e-3)
    r.run(1.0)
    assert r.hardware.feedforward.velocity[0] == 0.0


def test_empty_message_stops_in_ros1(rig, trajectory):
    """D16: an empty goal with the right names stops the arm and succeeds."""
    r = rig()
    arm = r.arm(compat='ros1')
    moving = arm.send_goal(trajectory(MOVE)).goal
    r.run(0.5)
    stopping = arm.send_goal(trajectory()).goal
    r.step()
    assert (moving.status.name, stopping.status.name) == ('CANCELED', 'SUCCEEDED')
    arm.send_goal(trajectory(MOVE))
    r.run(0.3)
    assert arm.set_trajectory(trajectory()) is None
    r.step()
    where = r.hardware.state.position.copy()
    r.run(1.0)
    np.testing.assert_allclose(r.hardware.state.position, where)


def test_speed_scaling(rig, trajectory):
    """K8: the pace scales the time of the trajectory; 0 pauses; it is reported."""
    r = rig()
    arm = r.arm()
    assert arm.set_speed_scaling(0.5)
    goal = arm.send_goal(trajectory((1.0, [1.0, 0.0]))).goal
    r.run(1.0)
    snapshot = arm.snapshot()
    assert snapshot.reference.positions[0] == pytest.approx(0.495)
    assert snapshot.speed_scaling_factor == 0.5
    assert snapshot.desired_time_from_start == pytest.approx(0.495)
    assert snapshot.actual_time_from_start == pytest.approx(0.99)
    arm.set_speed_scaling(0.0)
    r.run(1.0)
    assert arm.snapshot().reference.positions[0] == pytest.approx(0.5)
    assert goal.status.name == 'EXECUTING'
    arm.set_speed_scaling(2.0)
    r.run(0.3)
    assert goal.status.name == 'SUCCEEDED'


def test_bad_speed_scaling_is_ignored(rig):
    """K8, A5: negative factors, and controllers that command more than positions."""
    r = rig()
    arm = r.arm(speed_scaling={'initial_scaling_factor': 0.7})
    assert not arm.set_speed_scaling(-0.5)
    assert not arm.set_speed_scaling(math.nan)
    r.step()
    assert arm.snapshot().speed_scaling_factor == 0.7
    other = rig().arm(command_interfaces=['position', 'velocity'])
    assert not other.subscribes_speed_scaling
    assert not other.set_speed_scaling(0.5)


def test_the_pace_is_passed_on_to_the_hardware(rig):
    """
    The factor is written to the command interface at each update.

    joint_trajectory_controller.cpp, update.
    """
    r = rig()
    r.hardware.other_commands['pace/factor'] = math.nan
    arm = r.arm(speed_scaling={'command_interface': 'pace/factor', 'initial_scaling_factor': 0.7})
    assert r.hardware.other_commands['pace/factor'] == 0.7
    arm.set_speed_scaling(0.5)
    r.step()
    assert r.hardware.other_commands['pace/factor'] == 0.5


def test_the_initial_factor_counts_for_positions_alone(rig):
    """With other command interfaces the pace is 1, with a warning (on_configure)."""
    r = rig()
    arm = r.arm(command_interfaces=['position', 'velocity'],
                speed_scaling={'initial_scaling_factor': 0.7})
    assert arm.snapshot().speed_scaling_factor == 1.0
    assert any('initial_scaling_factor' in text for text in r.texts())


def test_command_joints_in_place_of_joints(rig, trajectory):
    """
    As many command_joints as joints may be others: each gets the trajectory of its place.

    joint_trajectory_controller.cpp, on_configure: map_cmd_to_joints_.
    """
    kinds = dict.fromkeys(('a', 'b', 'c', 'd'), JointType.REVOLUTE)
    r = rig(kinds)
    arm = r.arm(joints=['a', 'b'], command_joints=['c', 'd'])
    assert arm.required_command_interfaces == ('c/position', 'd/position')
    arm.send_goal(trajectory((0.2, [0.1, 0.3])))
    r.run(0.5)
    np.testing.assert_allclose(r.hardware.state.position, [0.0, 0.0, 0.1, 0.3])


def test_fewer_command_joints_in_another_order(rig, trajectory):
    """Fewer command joints than joints are found by their names (on_configure, mapping)."""
    kinds = dict.fromkeys(('a', 'b', 'c'), JointType.REVOLUTE)
    r = rig(kinds)
    arm = r.arm(command_joints=['c', 'a'])
    joints = ('a', 'b', 'c')
    arm.send_goal(trajectory((0.2, [0.1, 0.2, 0.3]), joints=joints))
    r.run(0.5)
    np.testing.assert_allclose(r.hardware.state.position, [0.1, 0.0, 0.3])
    np.testing.assert_allclose(arm.snapshot().error.positions, [0.0, 0.2, 0.0], atol=1e-12)


def test_unknown_scaling_interface_fails_activation(rig):
    """B15: an interface that does not exist makes activation fail, with its name."""
    r = rig()
    r.load('arm', 'joint_trajectory_controller/JointTrajectoryController', joints=['a'],
           speed_scaling={'state_interface': 'speed/factor'})
    result = r.manager.switch(activate=['arm'])
    assert not result.ok
    assert 'speed/factor' in result.message
    assert not r.manager.controllers['arm'].active


def test_command_timeout_holds(rig, trajectory):
    """K9: after the last waypoint and cmd_timeout the arm holds where it is."""
    r = rig(gain=0.001)
    arm = r.arm(cmd_timeout=0.3)
    arm.set_trajectory(trajectory((0.1, [0.2, 0.0])))
    r.run(0.35)
    assert arm.snapshot().reference.positions[0] == 0.2
    r.run(0.1)
    assert arm.snapshot().reference.positions[0] < 0.1


def test_command_timeout_below_goal_time_is_off(rig, trajectory):
    """B14: a warning tells, and nothing is held early."""
    r = rig()
    arm = r.arm(cmd_timeout=0.3, constraints={'goal_time': 0.5})
    assert any('cmd_timeout' in text for text in r.texts())
    arm.set_trajectory(trajectory((0.1, [0.2, 0.0])))
    r.run(1.0)
    assert arm.snapshot().reference.positions[0] == 0.2


def test_errors_of_continuous_joints_are_wrapped(rig):
    """G2, J4: the error of a continuous joint is the short way, of others the difference."""
    r = rig({'a': JointType.CONTINUOUS, 'b': JointType.REVOLUTE})
    arm = r.arm()
    r.hardware.frozen = True
    r.hardware.state.position[:] = 6.0
    r.step()
    np.testing.assert_allclose(arm.snapshot().error.positions, [2 * math.pi - 6.0, -6.0])


def test_mimic_joint_cannot_be_claimed(rig):
    """G7: a joint without command interface makes activation fail, by its name."""
    r = rig({'a': JointType.REVOLUTE, 'f': JointType.PRISMATIC}, mimics=('f',))
    r.load('arm', 'joint_trajectory_controller/JointTrajectoryController', joints=['a', 'f'])
    result = r.manager.switch(activate=['arm'])
    assert not result.ok
    assert 'f/position' in result.message


def test_query_state(rig, trajectory):
    """L1, L2: sampled while there is a trajectory."""
    r = rig()
    arm = r.arm()
    start = r.now_ns
    arm.send_goal(trajectory(MOVE))
    r.run(0.3)
    answer = arm.query_state(start + 500_000_000)
    assert (answer.success, answer.message) == (True, '')
    assert answer.names == ('a', 'b')
    np.testing.assert_allclose(answer.positions, [0.2, 0.0])
    np.testing.assert_allclose(answer.velocities, [0.75, 0.0], atol=1e-12)
    assert arm.query_state(start + 100_000_000).success


def test_query_state_that_fails_has_a_state(rig, trajectory):
    """
    Before the start it is the measured state, after the end the last point, else the held one.

    The message says why (L3); an inactive controller names no joint
    (joint_trajectory_controller.cpp, query_state_service).
    """
    r = rig(gain=0.5)
    arm = r.arm()
    held = arm.query_state(r.now_ns)
    assert 'held' in held.message
    assert held.names == ('a', 'b')
    np.testing.assert_array_equal(held.positions, [0.0, 0.0])
    start = r.now_ns
    arm.send_goal(trajectory(MOVE))
    r.run(0.3)
    before = arm.query_state(start - 1_000_000)
    assert 'before' in before.message
    np.testing.assert_array_equal(before.positions, arm.snapshot().feedback.positions)
    np.testing.assert_array_equal(before.velocities, arm.snapshot().feedback.velocities)
    after = arm.query_state(start + 1_100_000_000)
    assert 'after the last' in after.message
    np.testing.assert_array_equal(after.positions, [0.4, 0.0])
    assert [answer.success for answer in (held, before, after)] == [False] * 3
    assert before.names == after.names == ('a', 'b')
    r.manager.switch(deactivate=['arm'])
    inactive = arm.query_state(start + 500_000_000)
    assert 'not active' in inactive.message
    assert not inactive.names


def test_efforts_of_a_goals_feedback(rig, trajectory):
    """
    There is an effort for each joint: desired, and commanded; 0 without the interface.

    joint_trajectory_controller.cpp, read_state_from_state_interfaces; the reference of
    controller_state has none (publish_state).
    """
    r = rig()
    arm = r.arm(command_interfaces=['position', 'effort'])
    arm.send_goal(trajectory((1.0, [0.1, 0.1], [], [], [2.0, 3.0])))
    r.run(1.1)
    snapshot = arm.snapshot()
    np.testing.assert_allclose(snapshot.desired_effort, [2.0, 3.0])
    np.testing.assert_allclose(snapshot.commanded_effort, [2.0, 3.0])
    assert len(snapshot.reference.effort) == 0
    snapshot = rig().arm().snapshot()
    np.testing.assert_array_equal(snapshot.desired_effort, [0.0, 0.0])
    np.testing.assert_array_equal(snapshot.commanded_effort, [0.0, 0.0])


def test_snapshot_has_the_fields_of_the_interfaces(rig):
    """J3, J7: only interfaces that there are; velocity errors stay 0 for position commands."""
    snapshot = rig().arm(state_interfaces=['position']).snapshot()
    assert len(snapshot.feedback.velocities) == 0
    assert len(snapshot.error.velocities) == 0
    assert len(snapshot.output.velocities) == 0
    assert len(snapshot.reference.accelerations) == 2
    np.testing.assert_array_equal(rig().arm().snapshot().error.velocities, [0.0, 0.0])


def test_fewer_command_joints(rig):
    """J3, B2: output is NaN for joints that are not commanded."""
    r = rig()
    arm = r.arm(command_joints=['b'])
    assert arm.required_command_interfaces == ('b/position',)
    np.testing.assert_array_equal(np.isnan(arm.snapshot().output.positions), [True, False])
    assert np.isnan(r.hardware.command.position[0])


@pytest.mark.parametrize(
    ('parameters', 'word'),
    [
        ({'joints': ['a', 'c']}, "'c'"),
        ({'joints': ['a', 'b'], 'command_joints': ['c']}, "'c'"),
        ({'joints': ['a'], 'command_joints': ['c']}, "'c'"),
        ({'joints': ['a'], 'command_interfaces': ['effort'], 'state_interfaces': ['position']},
         'velocity'),
    ],
)
def test_configure_refuses(rig, parameters, word):
    """B2, B5: what does not fit is found when the controller is configured."""
    with pytest.raises(ControllerError, match=word):
        rig().load('arm', 'joint_trajectory_controller/JointTrajectoryController', **parameters)


def test_publish_rate_follows_simulated_time(rig):
    """U3, A15: controller_state is due at state_publish_rate of simulated time."""
    r = rig()
    arm = r.arm(state_publish_rate=25)
    due = 0
    for _ in range(100):
        r.step()
        due += arm.publish_due(arm.snapshot().time_ns)
    assert due == 25


def test_state_goes_on_while_idle(rig):
    """J5: every update leaves a state, with or without a trajectory."""
    r = rig()
    arm = r.arm()
    first = arm.snapshot()
    r.step(20)
    assert arm.snapshot().sequence == first.sequence + 20


def test_interpolation_none(rig, trajectory):
    """F9, B13: with the method none the command goes from point to point."""
    r = rig()
    arm = r.arm(interpolation_method='none')
    arm.send_goal(trajectory((0.5, [0.1, 0.0]), (1.0, [0.2, 0.0])))
    r.run(0.4)
    assert r.hardware.command.position[0] == 0.0
    r.run(0.2)
    assert r.hardware.command.position[0] == 0.2


def test_integration_of_velocities(rig, trajectory):
    """B7, F10: points with velocities alone move the arm from where it is."""
    r = rig()
    r.hardware.state.position[:] = [1.0, 0.0]
    arm = r.arm(allow_integration_in_goal_trajectories=True)
    goal = arm.send_goal(trajectory((1.0, [], [0.4, 0.0]), (2.0, [], [0.0, 0.0]))).goal
    r.run(2.1)
    assert goal.status.name == 'SUCCEEDED'
    np.testing.assert_allclose(r.hardware.state.position, [1.4, 0.0])
