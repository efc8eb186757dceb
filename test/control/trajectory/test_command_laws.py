# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What reaches the command interfaces, and how motions are stopped."""

import math

import numpy as np
import pytest

from armsim_ros.config.controllers.pid_controller import PidGains
from armsim_ros.control.command_writer import Pid
from armsim_ros.control.trajectory.sampling import deceleration, stop_ramp

MOVE = (1.0, [0.4, 0.0], [0, 0], [0, 0])
GAINS = {'a': {'p': 50.0, 'd': 10.0}, 'b': {'p': 50.0, 'd': 10.0}}


def test_position_ignores_gains(rig, trajectory):
    """K2: the reference is forwarded, whatever the gains say."""
    r = rig()
    arm = r.arm(gains={'a': {'p': 1000.0}, 'b': {'p': 1000.0}})
    arm.send_goal(trajectory(MOVE))
    r.run(0.5)
    assert r.hardware.command.position[0] == arm.snapshot().output.positions[0]


def test_position_velocity_acceleration_are_forwarded(rig, trajectory):
    """K2, B3: every commanded derivative is forwarded, and reported."""
    r = rig()
    arm = r.arm(command_interfaces=['position', 'velocity', 'acceleration'])
    arm.send_goal(trajectory(MOVE))
    r.run(0.25)
    output = arm.snapshot().output
    assert r.hardware.command.velocity[0] == output.velocities[0] > 0.0
    assert r.hardware.command.acceleration[0] == output.accelerations[0] > 0.0
    assert len(output.effort) == 0


def test_velocity_feeds_forward_and_back(rig, trajectory):
    """K3: u = ff * v_d + PID(e, v_d - v); the arm follows."""
    r = rig()
    gains = {j: {'p': 10.0, 'ff_velocity_scale': 1.0} for j in 'ab'}
    arm = r.arm(command_interfaces=['velocity'], gains=gains)
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.run(0.5)
    snapshot = arm.snapshot()
    expected = 10.0 * snapshot.error.positions[0]
    assert snapshot.output.velocities[0] - expected == pytest.approx(0.75, rel=1e-2)
    r.run(1.0)
    assert goal.status.name == 'SUCCEEDED'
    assert r.hardware.state.position[0] == pytest.approx(0.4, abs=1e-3)
    r.manager.switch(deactivate=['arm'])
    assert r.hardware.command.velocity[0] == 0.0


def test_open_loop_velocity_has_no_pid(rig, trajectory):
    """B10: open_loop_control forwards the desired velocity alone."""
    r = rig()
    arm = r.arm(command_interfaces=['velocity'], gains=GAINS, open_loop_control=True)
    arm.send_goal(trajectory(MOVE))
    r.hardware.frozen = True
    r.run(0.5)
    assert r.hardware.command.velocity[0] == pytest.approx(0.75, rel=1e-2)


def test_effort_closes_the_loop(rig, trajectory):
    """K4: PID plus the trajectory's effort; deactivation takes the effort away."""
    r = rig()
    arm = r.arm(command_interfaces=['effort'], gains=GAINS)
    push = (1.0, [0.0, 0.0], [0, 0], [0, 0], [2.0, 0.0])
    arm.send_goal(trajectory(push))
    r.hardware.frozen = True
    r.run(0.5)
    assert r.hardware.command.effort[0] == pytest.approx(1.0)
    assert arm.snapshot().output.effort[0] == r.hardware.command.effort[0]
    r.manager.switch(deactivate=['arm'])
    assert r.hardware.command.effort[0] == 0.0


def test_position_and_effort_are_forwarded(rig, trajectory):
    """K5: both go on unchanged, without PID and without feed-forward of ours."""
    r = rig()
    arm = r.arm(command_interfaces=['position', 'effort'], gains=GAINS)
    arm.send_goal(trajectory((1.0, [0.4, 0.0], [0, 0], [0, 0], [3.0, 0.0])))
    r.run(2.0)
    assert r.hardware.command.effort[0] == 3.0
    assert r.hardware.command.position[0] == 0.4
    assert np.isnan(r.hardware.feedforward.velocity).all()


def test_order_of_command_interfaces_is_free(rig):
    """B3: the set counts, not its order."""
    arm = rig().arm(command_interfaces=['effort', 'position'])
    assert arm.required_command_interfaces == (
        'a/effort', 'a/position', 'b/effort', 'b/position',
    )


def pid(**gains):
    """Return a PID with gains."""
    return Pid(PidGains(**gains))


def test_pid_terms():
    """K6: p*e + I + d*(v_d - v)."""
    assert pid(p=2.0, d=0.5).compute(1.0, 4.0, 0.1) == 4.0
    one = pid(i=2.0)
    assert [one.compute(1.0, 0.0, 0.1) for _ in range(3)] == pytest.approx([0.2, 0.4, 0.6])


def test_pid_clamps():
    """K6: i_clamp is symmetric, explicit bounds win, 0 switches the integral off, u is clamped."""
    assert pid(i=10.0, i_clamp=0.0).compute(1.0, 0.0, 1.0) == 0.0
    assert pid(i=10.0, i_clamp=0.5).compute(-1.0, 0.0, 1.0) == -0.5
    assert pid(i=10.0, i_clamp=0.5, i_clamp_max=0.7).compute(1.0, 0.0, 1.0) == 0.7
    assert pid(p=10.0, u_clamp_max=3.0, u_clamp_min=-2.0).compute(1.0, 0.0, 1.0) == 3.0
    assert pid(p=10.0, u_clamp_max=3.0, u_clamp_min=-2.0).compute(-1.0, 0.0, 1.0) == -2.0


def test_pid_of_bad_input():
    """K6: no time repeats the last output; an error that is no number gives none."""
    one = pid(p=1.0, i=1.0)
    first = one.compute(1.0, 0.0, 0.5)
    assert one.compute(7.0, 0.0, 0.0) == first
    assert math.isnan(one.compute(math.nan, 0.0, 0.5))
    assert one.compute(0.0, 0.0, 0.5) == 0.5


@pytest.mark.parametrize('strategy', ['back_calculation', 'conditional_integration'])
def test_anti_windup(strategy):
    """K6: saturated for long, the output leaves saturation soon after the error changes sign."""
    gains = {'p': 1.0, 'i': 1.0, 'u_clamp_max': 1.0, 'u_clamp_min': -1.0}
    kept = pid(antiwindup_strategy=strategy, **gains)
    wound = pid(antiwindup_strategy='none', **gains)
    for _ in range(1000):
        kept.compute(2.0, 0.0, 0.01)
        wound.compute(2.0, 0.0, 0.01)
    assert kept.compute(-0.5, 0.0, 0.01) < 1.0
    assert wound.compute(-0.5, 0.0, 0.01) == 1.0


def test_integrators_are_cleared_on_activation(rig, trajectory):
    """C9: after a pause the integral part is gone."""
    r = rig()
    r.arm(command_interfaces=['effort'], gains={'a': {'i': 10.0}, 'b': {}})
    r.hardware.frozen = True
    r.hardware.state.position[0] = 0.5
    r.run(1.0)
    assert r.hardware.command.effort[0] < -1.0
    r.manager.switch(deactivate=['arm'])
    r.manager.switch(activate=['arm'])
    r.step()
    assert r.hardware.command.effort[0] == 0.0


def test_gains_change_while_active(rig):
    """B16: gains are dynamic."""
    r = rig()
    arm = r.arm(command_interfaces=['velocity'])
    r.hardware.frozen = True
    r.hardware.state.position[0] = -0.5
    arm.set_parameters({'gains.a.p': 4.0})
    r.step()
    assert r.hardware.command.velocity[0] == pytest.approx(2.0)


def test_deceleration():
    """K1: v .5 with a 2 takes .25 s and .0625 rad; each joint by itself, both directions."""
    m = deceleration(np.array([1.0, 0.0]), np.array([0.5, -1.0]), np.array([2.0, 2.0]), 6)
    assert m.end == 0.5
    np.testing.assert_allclose(m.at(0.0), [1.0, 0.0, 0.5, -1.0, -2.0, 2.0])
    np.testing.assert_allclose(m.at(0.25)[:4], [1.0625, -0.1875, 0.0, -0.5], atol=1e-12)
    np.testing.assert_allclose(m.at(0.5)[:4], [1.0625, -0.25, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(m.at(0.9), [1.0625, -0.25, 0, 0, 0, 0])


def test_stop_ramp():
    """I9: the stop distance of the quintic is 0.625 * v * D."""
    m = stop_ramp(np.array([0.0]), np.array([0.5]), 0.5, 3)
    np.testing.assert_allclose(m.at(0.0), [0.0, 0.5, 0.0], atol=1e-12)
    np.testing.assert_allclose(m.at(0.5)[0], 0.15625)
    np.testing.assert_allclose(m.at(1.0), [0.15625, 0.0, 0.0])


def test_cancel_decelerates(rig, trajectory):
    """K1: with decelerate_on_cancel the arm brakes from where it is and how fast."""
    r = rig()
    brakes = {j: {'max_deceleration_on_cancel': 2.0} for j in 'ab'}
    arm = r.arm(constraints={'decelerate_on_cancel': True, **brakes})
    goal = arm.send_goal(trajectory((2.0, [1.0, 0.0]))).goal
    r.run(1.0)
    at = r.hardware.state.position[0]
    arm.cancel(goal)
    r.run(1.0)
    assert goal.status.name == 'CANCELED'
    assert r.hardware.state.position[0] == pytest.approx(at + 0.0625, abs=1e-6)


@pytest.mark.parametrize(
    'parameters',
    [
        {'constraints': {'decelerate_on_cancel': True}},
        {
            'constraints': {
                'decelerate_on_cancel': True,
                'a': {'max_deceleration_on_cancel': 1.0},
                'b': {'max_deceleration_on_cancel': 1.0},
            },
            'state_interfaces': ['position'],
        },
    ],
)
def test_deceleration_falls_back(rig, trajectory, parameters):
    """K1: where something for it is missing, a warning tells and a cancel stops at once."""
    r = rig()
    arm = r.arm(**parameters)
    assert any('decelerate_on_cancel is not possible' in text for text in r.texts())
    goal = arm.send_goal(trajectory((2.0, [1.0, 0.0]))).goal
    r.run(1.0)
    at = r.hardware.state.position[0]
    arm.cancel(goal)
    r.run(1.0)
    assert r.hardware.state.position[0] == at


def test_cancel_ramps(rig, trajectory):
    """I9, U3: stop_trajectory_duration ramps from the desired state to rest."""
    r = rig()
    arm = r.arm(stop_trajectory_duration=0.5)
    goal = arm.send_goal(trajectory((2.0, [1.0, 0.0]))).goal
    r.run(1.0)
    arm.cancel(goal)
    r.step()
    at = arm.snapshot().reference.positions[0]
    r.run(1.0)
    assert r.hardware.state.position[0] == pytest.approx(at + 0.15625, abs=1e-9)


def test_a_timeout_decelerates(rig, trajectory):
    """
    After cmd_timeout the joints brake as after a cancel; the velocity command ends at 0.

    joint_trajectory_controller.cpp, decelerate_to_hold_position.
    """
    r = rig()
    r.hardware.frozen = True
    constraints = {'decelerate_on_cancel': True}
    arm = r.arm(command_interfaces=['position', 'velocity'], cmd_timeout=0.1, constraints={
        **constraints, **{j: {'max_deceleration_on_cancel': 10.0} for j in 'ab'}})
    arm.set_trajectory(trajectory((0.25, [0.0, 0.0], [0.0, 0.0])))
    r.run(0.3)
    r.hardware.step = lambda period: None
    r.hardware.state.velocity[:] = 0.2
    r.run(0.2)
    np.testing.assert_allclose(r.hardware.command.velocity, [0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(r.hardware.command.position, [0.002, 0.002])
