# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``compat: ros1``: what a controller of ROS 1 does otherwise."""

from __future__ import annotations

from controller_bench import Bench, Result, tolerance, TrajectoryController
import pytest
from trajectory_msgs.msg import JointTrajectory

from armsim_ros.clients.trajectory import ABORTED, CANCELED, SUCCEEDED

statement = pytest.mark.statement
upstream = pytest.mark.upstream


@pytest.fixture
def old(bench: Bench) -> TrajectoryController:
    """Give a controller in the manner of ROS 1, whose second joint never moves."""
    bench.use('arm')  # which brings both joints back
    controller = bench.use('old')
    if 'compat' not in controller.parameters.names():
        pytest.skip('the server has no parameter compat')
    return controller


def stopped(c: TrajectoryController) -> bool:
    """Wait until the reference stands, on the way."""
    state = c.next_state(lambda s: set(s.reference.velocities) == {0.0})
    return 0.0 < state.reference.positions[0] < 1.9


@statement('U2', 'D16')
@upstream('emptyTopicCancelsTopicTraj', 'emptyTopicCancelsActionTraj')
@pytest.mark.parametrize('moved_by', ['topic', 'action'])
def test_an_empty_message_stops(old: TrajectoryController, moved_by: str) -> None:
    """An empty message on the topic stops the joints; a goal is CANCELED."""
    motion = old.to([2.0, 0.0], 1.0)
    goal = old.goal(motion) if moved_by == 'action' else old.publish(motion)
    old.next_state(lambda s: s.reference.positions[0] > 0.1)
    old.publish(JointTrajectory())
    if goal is not None:
        assert goal.result().status == CANCELED
    assert stopped(old)


@statement('U2', 'D16')
@upstream('emptyActionCancelsTopicTraj', 'emptyActionCancelsActionTraj')
@pytest.mark.parametrize('moved_by', ['topic', 'action'])
def test_an_empty_goal_stops(old: TrajectoryController, moved_by: str) -> None:
    """An empty goal with the right joints stops the joints and SUCCEEDS."""
    motion = old.to([2.0, 0.0], 1.0)
    goal = old.goal(motion) if moved_by == 'action' else old.publish(motion)
    old.next_state(lambda s: s.reference.positions[0] > 0.1)
    assert old.run(old.trajectory()).status == SUCCEEDED
    if goal is not None:
        assert goal.result().status == CANCELED
    assert stopped(old)


@statement('U2', 'I8')
@upstream('topicReplacesActionTraj')
def test_a_message_cancels_the_goal(old: TrajectoryController) -> None:
    """A trajectory on the topic cancels the goal that runs, and is followed."""
    goal = old.goal(old.to([2.0, 0.0], 1.0))
    goal.wait_for_feedback()
    old.publish(old.to([0.3, 0.0], 0.2))
    assert goal.result().status == CANCELED
    assert old.reaches([0.3, 0.0])


@statement('U2', 'I4')
@upstream('actionReplacesActionTraj')
def test_a_preempted_goal_is_canceled(old: TrajectoryController) -> None:
    """A second goal makes the first one CANCELED instead of ABORTED."""
    first = old.goal(old.to([2.0, 0.0], 1.0))
    first.wait_for_feedback()
    second = old.goal(old.to([0.2, 0.0], 0.2))
    assert first.result().status == CANCELED
    assert second.result().status == SUCCEEDED


@statement('U2', 'H11')
def test_goal_time_zero_leaves_no_grace(old: TrajectoryController) -> None:
    """With goal_time 0 a joint that is not there at the end fails the goal at once."""
    outcome = old.run(old.to([0.1, 0.5], 0.1), goal_tolerance=[tolerance('axis_2', 0.1)])
    assert outcome.status == ABORTED
    assert outcome.error_code == Result.GOAL_TOLERANCE_VIOLATED
