# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tolerances on the way and at the goal, their sources, and what a violation does."""

from __future__ import annotations

from collections.abc import Callable
import re

from controller_bench import Bench, duration, point, Result, tolerance, TrajectoryController
import pytest
from trajectory_msgs.msg import JointTrajectory

from armsim_ros.clients.trajectory import ABORTED, Outcome, SUCCEEDED

statement = pytest.mark.statement
upstream = pytest.mark.upstream
#: Less than any plant's error: a violation on purpose, for a server without fault hooks.
TINY = 1e-12


@pytest.fixture
def constrained(bench: Bench) -> TrajectoryController:
    """Give the controller with constraints in its file."""
    return bench.use('constrained')


def quick(c: TrajectoryController) -> JointTrajectory:
    """Return a motion that leaves a tracking error."""
    return c.to([0.6, 0.6], 0.3)


def over_time(outcome: Outcome) -> float:
    """Return the time since the last waypoint that the text of an abort gives [s]."""
    found = re.search(r'\b(\d+\.\d{6}) s\b', outcome.error_string)
    assert found, outcome
    return float(found[1])


def assert_path_violated(outcome: Outcome) -> None:
    """Look at status, code and text."""
    assert outcome.status == ABORTED, outcome
    assert outcome.error_code == Result.PATH_TOLERANCE_VIOLATED
    assert 'path tolerance' in outcome.error_string


def assert_goal_violated(outcome: Outcome) -> None:
    """Look at status, code and text."""
    assert outcome.status == ABORTED, outcome
    assert outcome.error_code == Result.GOAL_TOLERANCE_VIOLATED
    assert 'goal_time_tolerance' in outcome.error_string


@statement('H1', 'H6')
@upstream('test_goal_tolerances_single_point_success', 'test_goal_tolerances_multi_point_success')
def test_inside_the_default_tolerances(constrained: TrajectoryController) -> None:
    """Constraints of the file that are kept let a goal succeed."""
    assert constrained.run(constrained.to([0.3, 0.3], 0.3)).status == SUCCEEDED
    trajectory = constrained.trajectory(point(0.15, [0.2, 0.2]), point(0.3, [0.0, 0.0]))
    assert constrained.run(trajectory).status == SUCCEEDED


@statement('H1', 'B17', 'B23')
@upstream('update_dynamic_tolerances', 'test_state_tolerances_fail')
@pytest.mark.parametrize('kind', ['trajectory', 'goal'])
def test_defaults_come_from_parameters(constrained: TrajectoryController, kind: str) -> None:
    """constraints.<joint>.trajectory and .goal are the default tolerances, live."""
    parameters = constrained.parameters
    name = f'constraints.axis_2.{kind}'
    before = parameters.get(name)
    assert parameters.set(name, TINY) == ''
    try:
        outcome = constrained.run(quick(constrained))
    finally:
        assert parameters.set(name, before) == ''
    (assert_path_violated if kind == 'trajectory' else assert_goal_violated)(outcome)
    assert 'axis_2' in outcome.error_string
    assert constrained.run(constrained.to([0.0, 0.0], 0.2)).status == SUCCEEDED


@statement('H1')
def test_zero_is_unchecked(arm: TrajectoryController) -> None:
    """The default of 0 checks nothing."""
    assert arm.parameters.get('constraints.axis_1.trajectory') == 0.0
    assert arm.run(quick(arm)).status == SUCCEEDED


@statement('H2', 'H7')
@upstream('test_get_segment_tolerances', 'pathToleranceViolation',
          'pathToleranceViolationSingleJoint', 'test_tolerances_via_actions')
def test_a_path_tolerance_of_the_goal(constrained: TrajectoryController) -> None:
    """A goal's own path tolerance is kept for the joint it names, in any order."""
    outcome = constrained.run(
        quick(constrained), path_tolerance=[tolerance('axis_2', TINY), tolerance('axis_1', 1.0)]
    )
    assert_path_violated(outcome)
    assert 'axis_2' in outcome.error_string


@statement('H2', 'H10')
@upstream('test_get_segment_tolerances', 'goalToleranceViolation',
          'goalToleranceViolationSingleJoint')
def test_a_goal_tolerance_of_the_goal(constrained: TrajectoryController) -> None:
    """A goal's own goal tolerance is kept; the text gives the time since the last waypoint."""
    outcome = constrained.run(
        quick(constrained), goal_tolerance=[tolerance('axis_2', TINY), tolerance('axis_1', 1.0)]
    )
    assert_goal_violated(outcome)
    assert 'axis_2' in outcome.error_string


@statement('H2')
@upstream('test_deactivate_tolerances')
@pytest.mark.parametrize('kind', ['path', 'goal'])
def test_minus_one_erases(constrained: TrajectoryController, kind: str) -> None:
    """-1 switches a default tolerance off, 0 keeps it."""
    parameters = constrained.parameters
    name = f'constraints.axis_1.{"trajectory" if kind == "path" else "goal"}'
    before = parameters.get(name)
    assert parameters.set(name, TINY) == ''
    try:
        erased = constrained.run(
            quick(constrained), **{f'{kind}_tolerance': [tolerance('axis_1', -1.0)]}
        )
        constrained.goal(constrained.to([0.0, 0.0], 0.2),
                         path_tolerance=[tolerance('axis_1', -1.0)],
                         goal_tolerance=[tolerance('axis_1', -1.0)]).result()
        kept = constrained.run(
            quick(constrained), **{f'{kind}_tolerance': [tolerance('axis_1', 0.0)]}
        )
    finally:
        assert parameters.set(name, before) == ''
    assert erased.status == SUCCEEDED
    assert kept.status == ABORTED


@statement('H2', 'H11')
def test_goal_time_of_the_goal(bench: Bench) -> None:
    """goal_time_tolerance of the goal wins over the parameter; -1 s waits without limit."""
    bench.use('arm')  # both joints at 0
    c = bench.use('half_constrained')
    outcome = c.run(c.to([0.1, 0.5], 0.1), goal_time_tolerance=duration(0.02))
    assert_goal_violated(outcome)
    assert over_time(outcome) < 0.1
    waiting = c.goal(c.to([0.1, 0.5], 0.1), goal_time_tolerance=duration(-1.0))
    waiting.wait_for_feedback(8)  # 0.4 s
    assert waiting.cancel()
    assert waiting.result().error_code == 0


@statement('H11')
def test_goal_time_zero_waits(bench: Bench) -> None:
    """With goal_time 0 a goal outside its tolerance waits until it is cancelled."""
    bench.use('arm')  # both joints at 0
    c = bench.use('half_commanded')
    goal = c.goal(c.to([0.1, 0.5], 0.1), goal_tolerance=[tolerance('axis_2', 0.1)])
    goal.wait_for_feedback(10)
    assert goal.cancel()
    assert goal.result().error_code == 0


@statement('H3')
@upstream('test_invalid_tolerances')
@pytest.mark.parametrize('field', ['position', 'velocity', 'acceleration'])
def test_other_negative_tolerances_mean_defaults(
    constrained: TrajectoryController, field: str
) -> None:
    """A negative number other than -1: accepted, all tolerances are the defaults."""
    outcome = constrained.run(
        quick(constrained),
        path_tolerance=[tolerance('axis_1', TINY), tolerance('axis_2', **{field: -123.0})],
    )
    assert outcome.status == SUCCEEDED


@statement('H3')
@upstream('test_invalid_joints_path_tolerance', 'test_invalid_joints_goal_tolerance')
@pytest.mark.parametrize('kind', ['path_tolerance', 'goal_tolerance'])
def test_unknown_joints_mean_defaults(constrained: TrajectoryController, kind: str) -> None:
    """A tolerance for an unknown joint: accepted, all tolerances are the defaults."""
    outcome = constrained.run(
        quick(constrained), **{kind: [tolerance('axis_1', TINY), tolerance('nobody', 0.1)]}
    )
    assert outcome.status == SUCCEEDED


@statement('H4', 'H14')
@upstream('test_tolerances_via_actions')
def test_tolerances_hold_for_one_goal(constrained: TrajectoryController) -> None:
    """The next goal starts from the defaults and is accepted at once."""
    assert constrained.run(
        quick(constrained), path_tolerance=[tolerance('axis_1', TINY)]
    ).status == ABORTED
    assert constrained.run(constrained.to([0.0, 0.0], 0.2)).status == SUCCEEDED


@statement('H5')
@upstream('test_no_time_from_start_state_tolerance_fail')
def test_a_point_at_time_zero_is_checked(arm: TrajectoryController) -> None:
    """A single point at time 0 that is far away violates the path tolerance."""
    bounds = [tolerance('axis_1', 0.1), tolerance('axis_2', 0.1)]
    outcome = arm.run(arm.to([4.0, 4.0], 0.0), path_tolerance=bounds)
    assert_path_violated(outcome)


@statement('H6')
def test_velocity_tolerances_are_inert_with_position_commands(
    constrained: TrajectoryController,
) -> None:
    """A position-only controller computes no velocity error."""
    velocity = [tolerance('axis_1', 0.0, TINY, TINY)]
    outcome = constrained.run(
        quick(constrained), path_tolerance=velocity, goal_tolerance=velocity
    )
    assert outcome.status == SUCCEEDED


@statement('H6')
@upstream('velocity_error')
def test_velocity_tolerances_act_where_velocity_is_commanded(bench: Bench) -> None:
    """With a velocity command the velocity error is judged."""
    c = bench.use('two_levels')
    outcome = c.run(
        c.trajectory(point(0.3, [0.6, 0.6], [0.0, 0.0])),
        path_tolerance=[tolerance('axis_1', 0.0, TINY)],
    )
    assert_path_violated(outcome)
    assert 'velocity' in outcome.error_string


@statement('H7', 'C6')
@upstream('test_state_tolerances_fail')
def test_a_violation_holds_the_arm(arm: TrajectoryController) -> None:
    """After a violation on the way it holds the measured position; the text tells how much."""
    outcome = arm.run(
        arm.to([2.0, 2.0], 0.4),
        path_tolerance=[tolerance('axis_1', 1e-4)],
    )
    assert_path_violated(outcome)
    assert 'axis_1' in outcome.error_string
    assert any(character.isdigit() for character in outcome.error_string)
    arm.settle()
    assert arm.newest().reference.positions[0] < 1.9
    assert set(arm.newest().reference.velocities) == {0.0}


@statement('H8')
@upstream('test_state_tolerances_fail')
def test_a_violation_without_a_goal_holds_too(constrained: TrajectoryController) -> None:
    """A trajectory of the topic that leaves its tolerance is stopped, with an error logged."""
    parameters = constrained.parameters
    assert parameters.set('constraints.axis_1.trajectory', TINY) == ''
    try:
        constrained.watch(1)
        constrained.publish(constrained.to([2.0, 2.0], 1.0))
        constrained.next_state(
            lambda s: 0.0 < abs(s.reference.positions[0]) < 1.0
            and set(s.reference.velocities) == {0.0}
        )
    finally:
        assert parameters.set('constraints.axis_1.trajectory', 0.2) == ''


@statement('C24')
def test_a_topic_trajectory_is_given_up_later(
    constrained: TrajectoryController, bias: Callable[[float], None]
) -> None:
    """
    Long after its end a joint outside the goal tolerance is held where it is measured.

    joint_trajectory_controller.cpp, update.
    """
    constrained.watch(1)
    constrained.publish(constrained.to([0.2, 0.2], 0.2))
    constrained.reaches([0.2, 0.2])
    constrained.watch(30)
    bias(0.3)
    constrained.next_state(lambda s: s.reference.positions[0] > 0.25)
    bias(0.0)


@statement('C22')
def test_negative_tolerances_are_unchecked(constrained: TrajectoryController) -> None:
    """A tolerance parameter below 0 is as 0 (tolerances.hpp, check_state_tolerance_per_joint)."""
    parameters = constrained.parameters
    assert parameters.set('constraints.axis_1.trajectory', -1.0) == ''
    try:
        assert constrained.run(constrained.to([0.1, 0.1], 0.1)).status == SUCCEEDED
    finally:
        assert parameters.set('constraints.axis_1.trajectory', 0.2) == ''


@statement('H9', 'H13')
@upstream('test_success_single_point_sendgoal')
def test_success_has_code_and_text(constrained: TrajectoryController) -> None:
    """SUCCEEDED comes with code 0 and a text that contains success."""
    outcome = constrained.run(constrained.to([0.1, 0.1], 0.1))
    assert outcome.status == SUCCEEDED
    assert outcome.error_code == Result.SUCCESSFUL
    assert 'success' in outcome.error_string


@statement('H10')
@upstream('test_goal_tolerances_fail')
def test_a_goal_that_is_not_reached_in_time(constrained: TrajectoryController) -> None:
    """ABORTED with -5, the time in seconds with 6 decimals; then it holds."""
    outcome = constrained.run(
        constrained.to([0.2, 0.2], 0.1), goal_tolerance=[tolerance('axis_1', TINY)]
    )
    assert_goal_violated(outcome)
    assert over_time(outcome) >= 0.1
    constrained.settle()


@statement('H12')
def test_without_constraints_the_end_is_success(arm: TrajectoryController) -> None:
    """Without goal tolerances a goal succeeds at its end."""
    assert arm.run(quick(arm)).error_code == 0


@statement('H15')
def test_a_goals_tolerances_do_not_reach_the_topic(constrained: TrajectoryController) -> None:
    """Topic trajectories are judged by the defaults, whatever the last goal had."""
    constrained.run(quick(constrained), path_tolerance=[tolerance('axis_1', TINY)])
    constrained.home()
    constrained.publish(constrained.to([0.3, 0.3], 0.2))
    assert constrained.reaches([0.3, 0.3])


@statement('H16', 'K9')
@upstream('timeout')
def test_a_timeout_while_a_goal_waits_aborts(bench: Bench) -> None:
    """cmd_timeout that fires before a goal has settled aborts it, never a success."""
    bench.use('arm')  # both joints at 0
    c = bench.use('half_timed')
    outcome = c.run(
        c.to([0.1, 0.5], 0.1),
        goal_tolerance=[tolerance('axis_2', 0.1)],
        goal_time_tolerance=duration(-1.0),
    )
    assert outcome.status == ABORTED
    assert outcome.error_code == Result.GOAL_TOLERANCE_VIOLATED


@statement('H17')
@upstream('test_scaling_execution_time_succeeds')
def test_scaled_time_counts(constrained: TrajectoryController) -> None:
    """At a lower pace errors are those of the scaled reference."""
    constrained.set_speed(0.5)
    try:
        assert constrained.run(constrained.to([0.3, 0.3], 0.15)).status == SUCCEEDED
    finally:
        constrained.set_speed(1.0)


@statement('H18')
def test_a_result_needs_no_long_wait(sampled: TrajectoryController) -> None:
    """The result arrives though nothing more is sent, soon after the deciding update."""
    goal = sampled.goal(sampled.to([0.1, 0.1], 0.1))
    assert goal.result(5.0).status == SUCCEEDED
