# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Command laws, deceleration, pace and timeouts."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

from controller_bench import Bench, nanoseconds, PERIOD, point, seconds, TrajectoryController
import pytest

from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.clients.trajectory import CANCELED, SUCCEEDED

statement = pytest.mark.statement
upstream = pytest.mark.upstream


def stop_at_speed(c: TrajectoryController, velocity: float) -> tuple[float, float]:
    """Cancel a motion at a constant velocity; where it was cancelled and where it came to rest."""
    c.states.clear()
    goal = c.goal(c.to([velocity * 2.0, 0.0], 2.0))
    last = seconds(goal.wait_for_feedback(4)[-1].header.stamp)
    goal.cancel()
    assert goal.result().status == CANCELED
    rest = c.states.wait_for(
        lambda s: seconds(s.header.stamp) > last
        and set(s.reference.velocities) == {0.0}
        and abs(s.feedback.velocities[0]) < 1e-3
    )
    moving = [
        s.reference.positions[0]
        for s in c.states.messages
        if abs(s.reference.velocities[0] - velocity) < 1e-6
    ]
    return max(moving, key=abs), rest.reference.positions[0]


@statement('K1', 'I1')
@upstream('test_cancel_decelerate_to_hold_position', 'decelerate_to_hold_position_positive',
          'decelerate_to_hold_position_negative')
@pytest.mark.parametrize('velocity', [1.0, -1.0])
def test_deceleration_on_cancel(bench: Bench, velocity: float) -> None:
    """From v with deceleration a it comes to rest v^2 / (2 a) further on."""
    c = bench.use('braking')
    last, rest = stop_at_speed(c, velocity)
    expected = velocity * abs(velocity) / (2.0 * 4.0)
    assert rest - last == pytest.approx(expected, abs=6.0 * PERIOD)


@statement('K1')
@upstream('test_cancel_decelerate_fallback', 'decelerate_to_hold_position_fallback')
def test_deceleration_that_is_not_possible(bench: Bench) -> None:
    """With a joint that has no max_deceleration a cancel holds at once."""
    c = bench.use('half_braking')
    last, rest = stop_at_speed(c, 1.0)
    assert rest - last == pytest.approx(0.0, abs=6.0 * PERIOD)


@statement('K2')
def test_position_commands_are_the_reference(arm: TrajectoryController) -> None:
    """Positions are passed on as they are; at rest output and reference are the same."""
    arm.go([0.3, 0.1])
    for state in arm.watch(3):
        assert list(state.output.positions) == list(state.reference.positions)


@statement('K3', 'B16')
@upstream('use_closed_loop_pid', 'jointVelocityFeedForward')
def test_velocity_commands(bench: Bench) -> None:
    """U = ff * v_d + p * e with the velocity of the next update, and the joint arrives."""
    c = bench.use('velocity_drives')
    c.states.clear()
    goal = c.goal(c.to([0.5, 0.5], 0.5))
    assert goal.accepted()
    assert goal.result().status == SUCCEEDED
    checked = 0
    moving = [s for s in c.states.messages if s.reference.velocities[0] > 0.9]
    for state, following in pairwise(moving):
        if nanoseconds(following.header.stamp) - nanoseconds(state.header.stamp) == PERIOD * 1e9:
            law = following.reference.velocities[0] + 5.0 * state.error.positions[0]
            assert state.output.velocities[0] == pytest.approx(law, abs=1e-6)
            checked += 1
    assert checked
    c.next_state(lambda s: max(abs(e) for e in s.error.positions) < 0.01)


@statement('K4', 'K6', 'B16')
@upstream('use_closed_loop_pid')
def test_effort_commands(bench: Bench) -> None:
    """U = p * e + d * (v_d - v): the joint arrives and the output follows the law."""
    c = bench.use('effort_drives')
    goal = c.goal(c.trajectory(point(0.4, [0.5, 0.5], [0.0, 0.0])))
    c.states.clear()
    assert goal.result().status == SUCCEEDED
    checked = 0
    for state in c.states.messages:
        law = 200.0 * state.error.positions[0] + 10.0 * (
            state.reference.velocities[0] - state.feedback.velocities[0]
        )
        assert state.output.effort[0] == pytest.approx(law, abs=0.3 + 0.1 * abs(law))
        checked += 1
    assert checked
    c.next_state(lambda s: max(abs(e) for e in s.error.positions) < 0.01)


@statement('K5')
def test_position_and_effort_are_passed_on(bench: Bench) -> None:
    """With {position, effort} the efforts of the trajectory are the efforts commanded."""
    c = bench.use('with_effort')
    c.states.clear()
    trajectory = c.trajectory(
        point(0.05, [0.0, 0.0], effort=[1.5, 0.0]), point(0.3, [0.0, 0.0], effort=[1.5, 0.0])
    )
    assert c.run(trajectory).status == SUCCEEDED
    assert max(s.output.effort[0] for s in c.states.messages) == pytest.approx(1.5)


@statement('K6', 'B16')
@upstream('update_dynamic_parameters')
def test_gains_are_live(bench: Bench) -> None:
    """gains.<joint>.p changes in the next update; u_clamp bounds the output."""
    c = bench.use('effort_drives')
    for name, value in (('u_clamp_max', 0.5), ('u_clamp_min', -0.5)):
        assert c.parameters.set(f'gains.drive_1.{name}', value) == ''
    try:
        c.watch(1)
        c.states.clear()
        c.run(c.to([1.0, 0.0], 0.2))
        outputs = [abs(s.output.effort[0]) for s in c.states.messages]
        assert max(outputs) == pytest.approx(0.5)
    finally:
        for name, value in (('u_clamp_max', 200.0), ('u_clamp_min', -200.0)):
            assert c.parameters.set(f'gains.drive_1.{name}', value) == ''
    c.next_state(lambda s: max(abs(e) for e in s.error.positions) < 0.02)


@statement('K7')
def test_velocity_ff_of_ros_1(bench: Bench, load: Callable[..., bool]) -> None:
    """velocity_ff/<joint> is gains.<joint>.ff_velocity_scale."""
    assert load(
        'ros1_drives',
        joints=['drive_1', 'drive_2'],
        command_interfaces=['velocity'],
        velocity_ff={'drive_1': 0.75},
    )
    parameters = ParameterClient(bench.client, bench.name('ros1_drives'))
    assert parameters.get('gains.drive_1.ff_velocity_scale') == 0.75


@statement('K8', 'A5', 'J3')
@upstream('setting_scaling_factor_works_correctly', 'test_scaling_sampling_is_correct')
@pytest.mark.parametrize('factor', [0.25, 0.765, 2.0])
def test_pace(arm: TrajectoryController, factor: float) -> None:
    """Trajectory time advances by factor * period; the factor is published."""
    arm.set_speed(factor)
    try:
        goal = arm.goal(arm.to([0.2, 0.2], 0.4 * max(factor, 0.5)))
        first, *_, last = goal.wait_for_feedback(2)
        assert goal.result().status == SUCCEEDED
        last = goal.feedback[-1]
    finally:
        arm.set_speed(1.0)
    passed = (nanoseconds(last.header.stamp) - nanoseconds(first.header.stamp)) * 1e-9
    gone = seconds(last.desired.time_from_start) - seconds(first.desired.time_from_start)
    assert gone == pytest.approx(factor * passed, abs=factor * PERIOD * 1.1)


@statement('K8')
@upstream('setting_scaling_factor_works_correctly')
def test_pace_zero_pauses(arm: TrajectoryController) -> None:
    """At 0 the goal stays active and stands, then goes on."""
    goal = arm.goal(arm.to([0.5, 0.5], 0.5))
    goal.wait_for_feedback()
    arm.set_speed(0.0)
    try:
        standing = {tuple(s.reference.positions) for s in arm.watch(5)}
    finally:
        arm.set_speed(1.0)
    assert len(standing) == 1
    assert goal.result().status == SUCCEEDED


@statement('K8')
@upstream('setting_scaling_factor_works_correctly')
def test_a_negative_pace_is_ignored(arm: TrajectoryController) -> None:
    """A negative factor changes nothing."""
    arm.scale_speed(-0.5)
    assert all(s.speed_scaling_factor == 1.0 for s in arm.watch(5))


@statement('K8', 'B15')
@upstream('scaling_factor_from_param')
def test_the_first_pace_is_a_parameter(bench: Bench) -> None:
    """speed_scaling.initial_scaling_factor is the pace at the start."""
    c = bench.use('half_speed', home=False)
    assert c.newest().speed_scaling_factor == 0.5


@statement('K9', 'B14')
@upstream('accept_correct_cmd_timeout', 'timeout')
def test_a_timeout_holds(bench: Bench) -> None:
    """After cmd_timeout without a new command it holds; the next goal works."""
    c = bench.use('timed')
    c.publish(c.to([0.2, 0.2], 0.1))
    assert c.reaches([0.2, 0.2])
    c.watch(40)
    c.settle()
    assert c.run(c.to([0.0, 0.0], 0.2)).status == SUCCEEDED


@statement('K9', 'B14')
@upstream('decline_false_cmd_timeout', 'no_timeout')
def test_a_timeout_below_goal_time_is_off(bench: Bench) -> None:
    """cmd_timeout <= goal_time is switched off with a warning."""
    c = bench.use('untimed')
    assert c.run(c.to([0.2, 0.2], 0.1)).status == SUCCEEDED
    c.watch(30)
    assert c.reaches([0.2, 0.2])


@statement('K10')
def test_the_tracking_error_comes_from_the_plant(arm: TrajectoryController) -> None:
    """While moving the measured position differs from the reference by little."""
    arm.states.clear()
    assert arm.run(arm.to([1.0, 1.0], 0.5)).status == SUCCEEDED
    errors = [abs(s.error.positions[0]) for s in arm.states.messages]
    assert max(errors) < 0.2
