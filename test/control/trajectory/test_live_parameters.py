# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that are set while a controller is inactive, or at work."""

import pytest

EFFORT_GRIPPER = 'effort_controllers/GripperActionController'
PID = {'command_interfaces': ['effort'], 'state_interfaces': ['position', 'velocity']}


def pushes(r):
    """Return the effort of joint a after one update with an error of 0.1 rad."""
    r.hardware.state.position[:] = r.hardware.state.velocity[:] = 0.0
    r.manager.update(r.now_ns, 0.01)
    return r.hardware.command.effort[0]


def held_at_a_tenth(r, **parameters):
    """Return an effort controller that holds joint a at 0.1 rad, and is inactive."""
    r.hardware.state.position[:] = 0.1
    arm = r.arm(**PID, gains={'a': {'p': 10.0}, 'b': {'p': 10.0}}, **parameters)
    return arm


@pytest.mark.parametrize('inactive', [False, True])
def test_gains_reach_the_next_update_or_activation(rig, inactive):
    """Gains that are set are those of the next update, also if they were set while inactive."""
    r = rig()
    arm = held_at_a_tenth(r)
    assert pushes(r) == pytest.approx(1.0)
    if inactive:
        assert r.manager.switch(deactivate=['arm']).ok
    arm.set_parameters({'gains.a.p': 30.0})
    if inactive:
        r.hardware.state.position[:] = 0.1
        assert r.manager.switch(activate=['arm']).ok
    assert pushes(r) == pytest.approx(3.0)


def test_a_timeout_set_while_inactive_is_in_force_after_activation(rig, trajectory):
    """cmd_timeout is read at activation, from the parameters of that moment."""
    r = rig()
    arm = r.arm(constraints={'a': {'goal': 0.01}, 'goal_time': 0.0})
    assert r.manager.switch(deactivate=['arm']).ok
    arm.set_parameters({'cmd_timeout': 0.5})
    assert r.manager.switch(activate=['arm']).ok
    r.step()
    r.hardware.frozen = True
    goal = arm.send_goal(trajectory((0.1, [0.2, 0.0]))).goal
    r.run(1.0)
    assert 'cmd_timeout' in goal.result.message


def test_messages_to_an_inactive_controller_do_not_pile_up(rig):
    """Of a thousand speed factors the last one counts; cancels of nothing are forgotten."""
    r = rig()
    arm = r.arm()
    assert r.manager.switch(deactivate=['arm']).ok
    for i in range(1000):
        assert arm.set_speed_scaling(0.001 * i)
        arm.cancel_all()
    assert r.manager.switch(activate=['arm']).ok
    r.step()
    assert arm.snapshot().speed_scaling_factor == pytest.approx(0.999)


def test_gains_of_position_commands_go_to_the_drives(rig):
    """Only the joints whose gains have changed are told to the hardware, once."""
    r = rig()
    told = []
    r.hardware.set_gains = lambda gains: told.append({n: g.p for n, g in gains.items()})
    arm = r.arm()
    arm.set_parameters({'gains.a.p': 500.0})
    r.step(3)
    arm.set_parameters({'constraints.goal_time': 2.0})
    r.step()
    assert told == [{'a': 500.0}]


def test_gains_of_an_effort_gripper_are_live(rig):
    """The next update works with the new gains."""
    r = rig()
    hand = r.load('hand', EFFORT_GRIPPER, joint='a', gains={'a': {'p': 10.0}}, max_effort=50.0)
    assert r.manager.switch(activate=['hand']).ok
    hand.send_goal(0.1, 50.0)
    assert pushes(r) == pytest.approx(1.0)
    hand.set_parameters({'gains.a.p': 30.0})
    assert pushes(r) == pytest.approx(3.0)
