# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When a trajectory begins, where it begins, and when it ends."""

from __future__ import annotations

from controller_bench import (
    Bench,
    feedback_samples,
    nanoseconds,
    PERIOD,
    point,
    seconds,
    TrajectoryController,
)
import numpy as np
import pytest

from armsim_ros.clients.trajectory import ABORTED, SUCCEEDED

statement = pytest.mark.statement
upstream = pytest.mark.upstream


@statement('E1')
@upstream('test_success_single_point_sendgoal', 'topicSingleTraj', 'actionSingleTraj')
@pytest.mark.parametrize('way', ['action', 'topic'])
def test_without_a_stamp_it_starts_now(arm: TrajectoryController, way: str) -> None:
    """A stamp of 0 starts at once."""
    if way == 'action':
        assert arm.run(arm.to([0.1, 0.2], 0.2)).status == SUCCEEDED
    else:
        arm.publish(arm.to([0.1, 0.2], 0.2))
    assert arm.reaches([0.1, 0.2])


@statement('E2')
def test_trajectory_time_advances_by_the_period(sampled: TrajectoryController) -> None:
    """Between two messages trajectory time and the stamps advance alike, in whole periods."""
    goal = sampled.goal(sampled.to([0.3, 0.3], 0.4))
    assert goal.result().status == SUCCEEDED
    shown = goal.feedback[1:]
    starts = [seconds(m.header.stamp) - seconds(m.desired.time_from_start) for m in shown]
    assert max(starts) - min(starts) < 1e-4


@statement('E3')
def test_output_leads_the_reference_by_one_period(sampled: TrajectoryController) -> None:
    """The command is the trajectory one update ahead of the reference."""
    sampled.states.clear()
    assert sampled.run(sampled.to([0.6, 0.3], 0.6)).status == SUCCEEDED
    leads = [
        s.output.positions[0] - s.reference.positions[0]
        for s in sampled.states.messages
        if 0.05 < seconds(s.reference.time_from_start) < 0.55
        and 0.0 < s.reference.positions[0] < 0.6
    ]
    assert leads
    assert leads == pytest.approx([PERIOD] * len(leads), abs=1e-6)


@statement('E4')
@upstream('test_execute_partial_traj_in_future', 'executeParitalActionTrajInFuture',
          'blend_onto_not_yet_started_trajectory_holds_the_reference')
@pytest.mark.parametrize('way', ['action', 'topic'])
def test_a_stamp_in_the_future(arm: TrajectoryController, way: str) -> None:
    """It holds until the stamp, and is at the first point at stamp + t1."""
    stamp = arm.now_ns() + 400_000_000
    arm.states.clear()
    trajectory = arm.to([0.2, 0.1], 0.2, stamp_ns=stamp)
    if way == 'action':
        assert arm.run(trajectory).status == SUCCEEDED
    else:
        arm.publish(trajectory)
    assert arm.reaches([0.2, 0.1])
    for state in arm.states.messages:
        time = (nanoseconds(state.header.stamp) - stamp) * 1e-9
        expected = float(np.interp(time, [0.0, 0.2], [0.0, 0.2]))
        assert state.reference.positions[0] == pytest.approx(expected, abs=1.1 * PERIOD)


@statement('E4')
def test_a_first_point_at_a_future_stamp(arm: TrajectoryController) -> None:
    """It moves at once, and is at the first point at the stamp and not before."""
    stamp = arm.now_ns() + 400_000_000
    arm.states.clear()
    assert arm.run(arm.trajectory(point(0.0, [0.2, 0.1]), stamp_ns=stamp)).status == SUCCEEDED
    early = [
        state.reference.positions[0] for state in arm.states.messages
        if nanoseconds(state.header.stamp) < stamp - 2e9 * PERIOD
    ]
    assert max(early) < 0.2
    assert any(0.05 < position < 0.15 for position in early)
    assert arm.reaches([0.2, 0.1])


@statement('E4')
@upstream('blend_action_replaces_action_with_future_stamp')
def test_the_old_trajectory_goes_on_until_the_stamp(arm: TrajectoryController) -> None:
    """A goal with a stamp in the future lets the running motion go on until then."""
    first = arm.goal(arm.to([0.8, 0.0], 0.8))
    first.wait_for_feedback()
    stamp = arm.now_ns() + 200_000_000
    second = arm.goal(arm.to([0.0, 0.0], 0.3, stamp_ns=stamp))
    assert first.result().status == ABORTED
    arm.states.clear()
    assert second.result().status == SUCCEEDED
    assert arm.reaches([0.0, 0.0])
    for state in arm.states.messages:
        if nanoseconds(state.header.stamp) < stamp and seconds(state.reference.time_from_start):
            assert state.reference.velocities[0] == pytest.approx(1.0)


@statement('E5')
@upstream('test_ignore_partial_old_trajectory', 'ignorePartiallyOldActionTraj')
def test_a_stamp_in_the_past(arm: TrajectoryController) -> None:
    """Points that are over are left out without a jump; it ends at stamp + t_end."""
    stamp = arm.now_ns() - 300_000_000
    arm.states.clear()
    goal = arm.goal(
        arm.trajectory(
            point(0.1, [0.5, 0.5]), point(1.0, [0.2, 0.1]), stamp_ns=stamp,
        )
    )
    assert goal.result().status == SUCCEEDED
    assert arm.reaches([0.2, 0.1])
    positions = [s.reference.positions[0] for s in arm.states.messages]
    assert max(positions) < 0.2 + 1e-9
    assert all(
        seconds(state.header.stamp) >= stamp * 1e-9 + 1.0 - 2 * PERIOD
        for state in arm.states.messages
        if state.reference.positions[0] > 0.2 - 1e-9
    )


@statement('E6')
def test_a_first_point_at_time_zero_where_the_arm_is(sampled: TrajectoryController) -> None:
    """The client-safe form starts without a step."""
    sampled.states.clear()
    trajectory = sampled.trajectory(point(0.0, [0.0, 0.0]), point(0.2, [0.2, 0.2]))
    assert sampled.run(trajectory).status == SUCCEEDED
    assert sampled.reaches([0.2, 0.2])


@statement('E7', 'B9', 'I5')
@upstream('test_no_jump_when_state_tracking_error_not_updated')
def test_it_starts_from_the_desired_state(bench: Bench) -> None:
    """The lead-in begins at the reference, so replacing a trajectory makes no step."""
    c = bench.use('remembering')
    c.goal(c.to([1.5, 0.0], 0.5)).wait_for_feedback(2)
    before = c.newest()
    goal = c.goal(c.to([1.5, 0.0], 0.5))
    assert goal.result().status == SUCCEEDED
    first = feedback_samples(goal)[0]
    start = first.positions[0] - first.time * (1.5 - first.positions[0]) / (0.5 - first.time)
    assert start >= before.reference.positions[0] - 1e-3


@statement('E7', 'B9')
@upstream('test_jump_when_state_tracking_error_updated')
def test_it_may_start_from_the_measured_state(bench: Bench) -> None:
    """With interpolate_from_desired_state false the lead-in begins where the joints are."""
    c = bench.use('measured')
    c.goal(c.to([1.5, 0.0], 0.5)).wait_for_feedback(2)
    assert c.run(c.to([0.2, 0.0], 0.3)).status == SUCCEEDED
    assert c.reaches([0.2, 0.0])


@statement('E9')
def test_the_result_comes_at_the_end(sampled: TrajectoryController) -> None:
    """No success earlier than one period before the nominal end."""
    goal = sampled.goal(sampled.to([0.3, 0.3], 0.4))
    first = goal.wait_for_feedback()[0]
    end = seconds(first.header.stamp) - seconds(first.desired.time_from_start) + 0.4
    assert goal.result().status == SUCCEEDED
    assert seconds(sampled.newest().header.stamp) >= end - PERIOD


@statement('E10')
@upstream('test_success_single_point_with_velocity_sendgoal')
def test_one_point_is_enough(arm: TrajectoryController) -> None:
    """A trajectory of one point is legal, with and without velocity."""
    assert arm.run(arm.to([0.1, 0.1], 0.1)).status == SUCCEEDED
    trajectory = arm.trajectory(point(0.1, [0.2, 0.2], [0.0, 0.0]))
    assert arm.run(trajectory).status == SUCCEEDED


@statement('E10', 'J1')
@upstream('test_success_multi_point_sendgoal', 'test_success_multi_point_with_velocity_sendgoal')
@pytest.mark.parametrize('velocities', [(), [0.0, 0.0]], ids=['positions', 'velocities'])
def test_many_points(sampled: TrajectoryController, velocities: list[float]) -> None:
    """Many points are followed to the last, and feedback arrives."""
    goal = sampled.goal(
        sampled.trajectory(
            *(point(0.1 * (i + 1), [0.05 * (i + 1), 0.1], velocities) for i in range(4))
        )
    )
    assert goal.result().status == SUCCEEDED
    assert goal.wait_for_feedback(2)
    assert sampled.reaches([0.2, 0.1])
