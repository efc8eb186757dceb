# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gripper goals: reached, stalled, canceled, replaced."""

import numpy as np
import pytest

POSITION = 'position_controllers/GripperActionController'
EFFORT = 'effort_controllers/GripperActionController'
PARALLEL = 'parallel_gripper_action_controller/GripperActionController'


def gripper(r, kind=POSITION, **parameters):
    """Return an active gripper controller of joint a."""
    controller = r.load('gripper', kind, joint='a', **parameters)
    result = r.manager.switch(['gripper'])
    assert result.ok, result.message
    return controller


@pytest.mark.parametrize('kind', [POSITION, PARALLEL])
def test_reaches_the_goal(rig, kind):
    """N1, N2, N3: inside goal_tolerance the goal has succeeded."""
    r = rig(gain=0.1)
    hand = gripper(r, kind)
    goal = hand.send_goal([0.5] if kind == PARALLEL else 0.5).goal
    r.run(1.0)
    assert goal.status.name == 'SUCCEEDED'
    assert goal.result.reached_goal
    assert not goal.result.stalled
    assert abs(goal.result.position - 0.5) < 0.01


@pytest.mark.parametrize(('allowed', 'status'), [(False, 'ABORTED'), (True, 'SUCCEEDED')])
def test_stalls(rig, allowed, status):
    """N3: slow for stall_timeout is stalled; a success only where that is allowed."""
    r = rig()
    hand = gripper(r, allow_stalling=allowed, stall_timeout=0.5)
    goal = hand.send_goal(0.5).goal
    r.hardware.frozen = True
    r.run(0.45)
    assert goal.status.name == 'EXECUTING'
    r.run(0.15)
    assert goal.status.name == status
    assert goal.result.stalled
    assert not goal.result.reached_goal


def test_a_negative_threshold_never_stalls(rig):
    """stall_velocity_threshold has no bounds (gripper_action_controller_parameters.yaml)."""
    r = rig()
    hand = gripper(r, stall_velocity_threshold=-1.0, stall_timeout=0.1)
    goal = hand.send_goal(0.5).goal
    r.hardware.frozen = True
    r.run(1.0)
    assert goal.status.name == 'EXECUTING'


@pytest.mark.parametrize('kind', [POSITION, PARALLEL])
def test_cancel_takes_the_goals_effort_back(rig, kind):
    """After a cancel the parameter's max_effort counts again (set_hold_position)."""
    r = rig(gain=0.05)
    parameters = {'max_effort_interface': 'a/effort'} if kind == PARALLEL else {}
    hand = gripper(r, kind, max_effort=7.0, **parameters)
    goal = hand.close_to(1.0, 3.0).goal
    r.step()
    assert r.hardware.effort_bound[0] == 3.0
    hand.cancel(goal)
    r.step()
    assert r.hardware.effort_bound[0] == 7.0


def test_cancel_holds(rig):
    """N4: CANCELED, and the joint stays where it is."""
    r = rig(gain=0.05)
    hand = gripper(r)
    goal = hand.send_goal(1.0).goal
    r.run(0.1)
    where = r.hardware.state.position[0]
    assert hand.cancel(goal)
    r.run(1.0)
    assert goal.status.name == 'CANCELED'
    assert r.hardware.state.position[0] == pytest.approx(where)


def test_new_goal_replaces(rig):
    """N5: the old goal is CANCELED."""
    r = rig(gain=0.05)
    hand = gripper(r)
    old = hand.send_goal(1.0).goal
    r.step()
    new = hand.send_goal(0.0).goal
    r.step()
    assert old.status.name == 'CANCELED'
    r.run(1.0)
    assert new.status.name == 'SUCCEEDED'


def test_holds_on_activation(rig):
    """Activation commands the measured position."""
    r = rig()
    r.hardware.state.position[0] = 0.3
    gripper(r)
    r.run(0.1)
    assert r.hardware.state.position[0] == 0.3


def test_deactivation_aborts(rig):
    """The goal, and one that is still pending, end when the controller is deactivated."""
    r = rig(gain=0.01)
    hand = gripper(r)
    goal = hand.send_goal(1.0).goal
    r.step()
    pending = hand.send_goal(2.0).goal
    r.manager.switch([], ['gripper'])
    assert goal.status.name == pending.status.name == 'ABORTED'
    assert not hand.send_goal(1.0).accepted


def test_effort_is_bounded_by_the_goal(rig):
    """N1: the effort kind runs a PID within max_effort."""
    r = rig()
    hand = gripper(r, EFFORT, gains={'a': {'p': 100.0, 'd': 5.0}}, max_effort=8.0)
    assert hand.required_command_interfaces == ('a/effort',)
    r.hardware.frozen = True
    hand.send_goal(1.0, 3.0)
    r.step(2)
    assert r.hardware.command.effort[0] == 3.0
    hand.send_goal(1.0)
    r.step(2)
    assert r.hardware.command.effort[0] == 8.0


@pytest.mark.parametrize(('given', 'effort'), [({}, 0.0), ({'i_clamp': 0.4}, 0.4)])
def test_the_integral_part_needs_a_bound(rig, given, effort):
    """
    Without ``i_clamp`` nothing is integrated.

    gripper_controllers/hardware_interface_adapter.hpp: i_clamp is 0 by default.
    """
    r = rig()
    hand = gripper(r, EFFORT, gains={'a': {'i': 1.0, **given}}, max_effort=10.0)
    r.hardware.frozen = True
    hand.send_goal(1.0)
    r.run(0.9)
    assert r.hardware.command.effort[0] == pytest.approx(effort)


@pytest.mark.parametrize('positions', [[], [0.1, 0.2]])
def test_parallel_wants_exactly_one_position(rig, positions):
    """N2: any other number is refused."""
    response = gripper(rig(), PARALLEL).send_goal(positions)
    assert not response.accepted
    assert 'allowed: 1' in response.reason


def test_parallel_bounds_go_to_their_interfaces(rig):
    """N2, D3: the effort bounds the drive; the default counts where an interface is named."""
    r = rig()
    hand = gripper(r, PARALLEL, max_effort_interface='a/effort', max_velocity_interface='')
    assert hand.required_command_interfaces == ('a/position', 'a/effort')
    r.step()
    assert r.hardware.effort_bound[0] == 10.0
    hand.send_goal([5.0], [0.7], [2.5])
    r.hardware.frozen = True
    r.step()
    assert r.hardware.effort_bound[0] == 2.5
    assert np.isnan(r.hardware.command.effort[0])
    r.manager.switch([], ['gripper'])
    assert r.hardware.effort_bound[0] == np.inf


@pytest.mark.parametrize(('velocities', 'fastest'), [((0.2,), 0.2), ((), 0.1)])
def test_parallel_bounds_the_velocity(rig, velocities, fastest):
    """N2: the joint moves no faster than the goal says, or else the parameter, and arrives."""
    r = rig()
    hand = gripper(r, PARALLEL, max_velocity_interface='a/velocity', max_velocity=0.1)
    assert hand.required_command_interfaces == ('a/position', 'a/velocity')
    goal = hand.send_goal([0.3], velocities).goal
    speeds = []
    while not goal.done:
        r.step()
        speeds.append(abs(r.hardware.state.velocity[0]))
        assert np.isnan(r.hardware.command.velocity[0])
    assert goal.status.name == 'SUCCEEDED'
    assert max(speeds) == pytest.approx(fastest)
    r.run(1.0)
    assert r.hardware.state.position[0] == pytest.approx(0.3)


def test_parallel_opens_from_where_the_fingers_are(rig):
    """What was gripped in vain has not to be undone first."""
    r = rig()
    hand = gripper(r, PARALLEL, max_velocity_interface='a/velocity', stall_timeout=0.1)
    r.hardware.frozen = True
    goal = hand.send_goal([0.5], [1.0]).goal
    r.run(1.0)
    assert goal.result.stalled
    assert r.hardware.command.position[0] == pytest.approx(0.5)
    r.hardware.frozen = False
    r.hardware.gain = 0.0
    hand.send_goal([-0.5], [1.0])
    r.step(2)
    assert -0.05 < r.hardware.command.position[0] < 0.0


def test_not_a_number_is_refused(rig):
    """A command that is no number moves nothing."""
    assert 'finite' in gripper(rig()).send_goal(float('nan')).reason


def test_refusal_is_an_event(rig):
    """Every refused goal leaves its reason for the log and the topic of rejected goals."""
    r = rig()
    hand = gripper(r)
    r.manager.poll_events()
    reason = hand.send_goal(float('nan')).reason
    (event,) = r.manager.poll_events()
    assert (event.kind, event.level, event.source) == ('goal_rejected', 'error', 'gripper')
    assert reason in event.text


def test_interface_that_does_not_exist(rig):
    """N2: a bound's interface that the hardware lacks makes activation fail."""
    r = rig()
    r.load('gripper', PARALLEL, joint='a', max_effort_interface='a/set_gripper_max_effort')
    result = r.manager.switch(['gripper'])
    assert not result.ok
    assert 'set_gripper_max_effort' in result.message
