# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What feedback and controller_state hold, and what query_state answers."""

from __future__ import annotations

import math

from controller_bench import Bench, nanoseconds, PERIOD, point, seconds, TrajectoryController
import pytest

from armsim_ros.clients.trajectory import SUCCEEDED

statement = pytest.mark.statement
upstream = pytest.mark.upstream


@statement('J1', 'C23')
def test_feedback_comes_with_a_goal_only(arm: TrajectoryController) -> None:
    """It has a stamp, the joints in controller order, desired, actual and error."""
    goal = arm.goal(
        arm.trajectory(point(0.3, [0.1, 0.2]), joints=arm.joints[::-1])
    )
    message = goal.wait_for_feedback(2)[-1]
    assert goal.result().status == SUCCEEDED
    assert list(message.joint_names) == arm.joints
    assert nanoseconds(message.header.stamp) > 0
    for part in (message.desired, message.actual, message.error):
        assert len(part.positions) == 2
        assert list(part.effort) == [0.0, 0.0]
    for desired, actual, error in zip(
        message.desired.positions, message.actual.positions, message.error.positions, strict=True
    ):
        assert error == pytest.approx(desired - actual, abs=1e-9)
    count = len(goal.feedback)
    arm.watch(10)
    assert len(goal.feedback) <= count + 1


@statement('J2')
@upstream('time_from_start_populated')
def test_times_from_start(arm: TrajectoryController) -> None:
    """Desired counts trajectory time at its pace, actual the time that has passed."""
    arm.set_speed(0.5)
    try:
        goal = arm.goal(arm.to([0.2, 0.2], 0.2))
        message = goal.wait_for_feedback(3)[-1]
        assert goal.result().status == SUCCEEDED
    finally:
        arm.set_speed(1.0)
    desired = seconds(message.desired.time_from_start)
    actual = seconds(message.actual.time_from_start)
    assert desired == pytest.approx(0.5 * actual, abs=PERIOD)
    assert 0.0 < desired <= 0.2 + PERIOD


FIELDS = {
    # controller: (feedback and error fields, output fields)
    'arm': (('positions', 'velocities'), ('positions',)),
    'positions_only': (('positions',), ('positions',)),
    'two_levels': (('positions', 'velocities'), ('positions', 'velocities')),
    'three_levels': (
        ('positions', 'velocities', 'accelerations'),
        ('positions', 'velocities', 'accelerations'),
    ),
    'with_effort': (('positions', 'velocities'), ('positions', 'effort')),
    'velocity_drives': (('positions', 'velocities'), ('velocities',)),
    'effort_drives': (('positions', 'velocities'), ('effort',)),
}


@statement('J3', 'C10')
@upstream('state_topic_consistency', 'stateTopicConsistency', 'check_interface_names')
@pytest.mark.parametrize('name', FIELDS)
def test_fields_of_the_state(bench: Bench, name: str) -> None:
    """Feedback and error have the state interfaces, output the commanded ones."""
    states, outputs = FIELDS[name]
    c = bench.use(name, home=False)
    message = c.newest()
    assert list(message.joint_names) == c.joints
    assert message.speed_scaling_factor == 1.0
    for field in ('positions', 'velocities', 'accelerations'):
        assert len(getattr(message.reference, field)) == 2
        assert len(getattr(message.feedback, field)) == 2 * (field in states)
        assert len(getattr(message.error, field)) == 2 * (field in states)
    for field in ('positions', 'velocities', 'accelerations', 'effort'):
        assert len(getattr(message.output, field)) == 2 * (field in outputs)
    for part in (message.reference, message.feedback, message.error):
        assert not part.effort


@statement('J3', 'B2')
@upstream('state_topic_consistency_command_joints_less_than_dof',
          'trajectory_error_command_joints_less_than_dof')
def test_joints_that_are_not_commanded(bench: Bench) -> None:
    """Their output is NaN, their feedback is there; only commanded joints are claimed."""
    c = bench.use('half_commanded', home=False)
    message = c.newest()
    assert math.isfinite(message.output.positions[0])
    assert math.isnan(message.output.positions[1])
    assert len(message.feedback.positions) == 2
    claims = bench.manager.controllers()['half_commanded'].claimed_interfaces
    assert list(claims) == ['axis_1/position']


@statement('J5', 'C10')
def test_the_state_comes_when_idle(arm: TrajectoryController) -> None:
    """It is published without a trajectory too, error near 0."""
    for message in arm.watch(3):
        assert max(map(abs, message.error.positions)) < 2e-3


@statement('J6')
def test_accelerations_of_the_reference(arm: TrajectoryController) -> None:
    """The reference has accelerations while it moves on a quintic."""
    arm.states.clear()
    trajectory = arm.trajectory(point(0.4, [0.4, 0.4], [0.0, 0.0], [0.0, 0.0]))
    assert arm.run(trajectory).status == SUCCEEDED
    assert max(abs(s.reference.accelerations[0]) for s in arm.states.messages) > 1.0


@statement('J7', 'H6')
def test_velocity_error_without_velocity_command(arm: TrajectoryController) -> None:
    """It is there and stays 0."""
    arm.states.clear()
    assert arm.run(arm.to([0.4, 0.4], 0.3)).status == SUCCEEDED
    assert all(set(s.error.velocities) == {0.0} for s in arm.states.messages)


@statement('L1', 'L2')
@upstream('queryStateServiceConsistency')
def test_query_of_a_running_trajectory(arm: TrajectoryController) -> None:
    """Names in controller order, position, velocity and acceleration at an absolute time."""
    goal = arm.goal(arm.to([0.8, 0.4], 4.0))
    message = goal.wait_for_feedback(2)[-1]
    now = nanoseconds(message.header.stamp)
    answer = arm.query(now + 100_000_000)
    assert answer.success, answer.message
    assert list(answer.name) == arm.joints
    expected = message.desired.positions[0] + 0.02
    assert answer.position[0] == pytest.approx(expected, abs=1e-3)
    assert answer.velocity == pytest.approx([0.2, 0.1])
    assert answer.acceleration == pytest.approx([0.0, 0.0])
    goal.cancel()


@statement('L3', 'L4', 'L5', 'C23')
@pytest.mark.parametrize('offset', [-10, 10], ids=['before', 'after'])
def test_query_outside_of_the_trajectory(arm: TrajectoryController, offset: int) -> None:
    """Before the start and after the end success is false; a state and the reason are there."""
    goal = arm.goal(arm.to([0.5, 0.5], 5.0))
    now = nanoseconds(goal.wait_for_feedback(1)[-1].header.stamp)
    answer = arm.query(now + offset * 1_000_000_000)
    assert not answer.success
    assert answer.message
    assert list(answer.name) == arm.joints
    if offset > 0:
        assert list(answer.position) == [0.5, 0.5]
    else:
        assert max(map(abs, answer.position)) < 0.5
    goal.cancel()


@statement('L1', 'L3')
@pytest.mark.parametrize('why', ['no trajectory', 'inactive'])
def test_query_without_a_trajectory(bench: Bench, why: str) -> None:
    """Without a trajectory success is false; an inactive controller gives no state either."""
    bench.activate()
    arm = bench.use('arm')
    now = arm.now_ns()
    if why == 'inactive':
        bench.activate()
    answer = arm.query(now)
    assert not answer.success
    assert answer.message
    assert list(answer.name) == ([] if why == 'inactive' else arm.joints)
