# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Goals: cancel, replacement, several clients, topic against action."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

from action_msgs.msg import GoalStatus, GoalStatusArray
from controller_bench import Bench, point, Result, seconds, tolerance, TrajectoryController
import pytest

from armsim_ros.clients.client_node import ClientNode, LATCHED
from armsim_ros.clients.trajectory import ABORTED, CANCELED, SUCCEEDED, TrajectoryClient

statement = pytest.mark.statement
upstream = pytest.mark.upstream


@pytest.fixture(scope='module')
def other(bench: Bench) -> Iterator[TrajectoryClient]:
    """Give a second client in a participant of its own, with discovery behind it."""
    arm = bench.use('arm')
    with ClientNode(bench.domain, 'other_client') as node:
        client = TrajectoryClient(node, arm.controller)
        client.wait_for_server()
        # The server knows this client too, once it has answered it.
        assert not client.send(arm.trajectory()).accepted()
        yield client


@statement('I1', 'C6')
@upstream('test_cancel_hold_position', 'cancelActionGoal')
def test_cancel_holds_the_position(arm: TrajectoryController) -> None:
    """CANCELED, code 0, no text; the arm holds where it was."""
    goal = arm.goal(arm.to([2.0, 2.0], 1.0))
    goal.wait_for_feedback(2)
    assert goal.cancel()
    outcome = goal.result()
    assert (outcome.status, outcome.error_code, outcome.error_string) == (CANCELED, 0, '')
    arm.settle()
    held = arm.newest().reference.positions
    assert 0.0 < held[0] < 1.9
    assert all(list(s.reference.positions) == list(held) for s in arm.watch(5))


@statement('I2')
@pytest.mark.parametrize('which', ['ended', 'preempted'])
def test_cancel_of_a_goal_that_is_not_active(arm: TrajectoryController, which: str) -> None:
    """It is refused and changes nothing."""
    old = arm.goal(arm.to([0.1, 0.1], 0.1 if which == 'ended' else 1.0))
    if which == 'ended':
        old.result()
    else:
        old.wait_for_feedback()
    new = arm.goal(arm.to([0.3, 0.3], 0.4))
    assert new.accepted()
    old.result()
    assert not old.cancel()
    assert new.result().status == SUCCEEDED
    assert arm.reaches([0.3, 0.3])


@statement('I3', 'I4')
@upstream('preempted_goal_receives_aborted_result', 'actionReplacesActionTraj',
          'blend_action_preempt_aborts_old_goal')
def test_a_second_client_preempts(
    arm: TrajectoryController, other: TrajectoryClient
) -> None:
    """The old goal is ABORTED with INVALID_GOAL and told so, the new one succeeds."""
    first = arm.goal(arm.to([1.0, 1.0], 1.0))
    first.wait_for_feedback()
    second = other.send(arm.to([0.1, 0.1], 0.3))
    outcome = first.result()
    assert outcome.status == ABORTED
    assert outcome.error_code == Result.INVALID_GOAL
    assert 'preempted' in outcome.error_string
    assert second.result().status == SUCCEEDED
    assert arm.reaches([0.1, 0.1])


@statement('I4')
def test_a_rejected_goal_of_a_second_client(
    arm: TrajectoryController, other: TrajectoryClient
) -> None:
    """A goal that is rejected does not disturb the running one."""
    running = arm.goal(arm.to([0.4, 0.4], 0.4))
    running.wait_for_feedback()
    assert not other.send(arm.trajectory()).accepted()
    assert running.result().status == SUCCEEDED


@statement('I5', 'E7')
@upstream('test_trajectory_replace', 'blend_immediate_full_goal', 'blend_successive_blends')
def test_replacement_makes_no_step(arm: TrajectoryController) -> None:
    """The rest of the old trajectory is forgotten; the reference goes on from where it was."""
    arm.states.clear()
    for target in ([1.0, 0.0], [0.0, 1.0], [0.5, 0.5]):
        goal = arm.goal(arm.to(target, 0.5))
        goal.wait_for_feedback(1)
    assert goal.result().status == SUCCEEDED
    assert arm.reaches([0.5, 0.5])
    for before, after in pairwise(arm.states.messages):
        time = seconds(after.header.stamp) - seconds(before.header.stamp)
        step = abs(after.reference.positions[0] - before.reference.positions[0])
        assert step <= 4.0 * time + 1e-6  # the quickest of the three needs 4 rad/s at most


@statement('I5', 'K8')
@upstream('blend_no_position_jump_under_speed_scaling')
def test_replacement_at_another_pace_makes_no_step(arm: TrajectoryController) -> None:
    """At half the pace the reference goes on from where it was, too."""
    arm.set_speed(0.5)
    try:
        arm.states.clear()
        for target in ([1.0, 0.0], [0.0, 1.0]):
            goal = arm.goal(arm.to(target, 0.3))
            goal.wait_for_feedback(2)
        assert goal.result().status == SUCCEEDED
    finally:
        arm.set_speed(1.0)
    for before, after in pairwise(arm.states.messages):
        time = seconds(after.header.stamp) - seconds(before.header.stamp)
        assert abs(after.reference.positions[0] - before.reference.positions[0]) <= 2.0 * time


@statement('I6')
@upstream('topicReplacesTopicTraj', 'test_trajectory_replace')
def test_topic_replaces_topic(arm: TrajectoryController) -> None:
    """A second message replaces the first."""
    arm.publish(arm.to([1.0, 1.0], 1.0))
    arm.next_state(lambda s: s.reference.positions[0] > 0.05)
    arm.publish(arm.to([0.1, 0.2], 0.2))
    assert arm.reaches([0.1, 0.2])


@statement('I7')
@upstream('actionReplacesTopicTraj')
def test_action_replaces_topic(arm: TrajectoryController) -> None:
    """A goal replaces a topic trajectory and is monitored."""
    arm.publish(arm.to([1.0, 1.0], 1.0))
    arm.next_state(lambda s: s.reference.positions[0] > 0.05)
    assert arm.run(arm.to([0.2, 0.1], 0.2)).status == SUCCEEDED
    assert arm.reaches([0.2, 0.1])


@statement('I8')
@upstream('topicReplacesActionTraj')
def test_topic_replaces_action(arm: TrajectoryController) -> None:
    """A message during a goal replaces its trajectory; the goal still comes to an end."""
    goal = arm.goal(arm.to([1.0, 1.0], 1.0))
    goal.wait_for_feedback()
    arm.publish(arm.to([0.1, 0.2], 0.2))
    assert goal.result().status in (SUCCEEDED, CANCELED)
    assert arm.reaches([0.1, 0.2])


@statement('I9')
def test_a_stop_ramp_of_ros_1(bench: Bench, load: Callable[..., bool]) -> None:
    """stop_trajectory_duration D: it comes to rest 0.625 v D further on, without a step."""
    assert load('ramping', stop_trajectory_duration=0.3)
    assert bench.manager.configure('ramping')
    c = bench.use('ramping')
    goal = c.goal(c.to([1.0, 0.0], 1.0))
    goal.wait_for_feedback(3)
    c.states.clear()
    assert goal.cancel()
    assert goal.result().status == CANCELED
    rest = c.next_state(lambda s: set(s.reference.velocities) == {0.0}).reference.positions[0]
    before = [s for s in c.states.messages if abs(s.reference.velocities[0] - 1.0) < 1e-9]
    if before:
        last = before[-1].reference.positions[0]
        assert rest - last == pytest.approx(0.625 * 0.3, abs=0.1)
    bench.activate()


@statement('I10')
def test_an_old_violation_never_hits_a_new_goal(arm: TrajectoryController) -> None:
    """Goals that arrive while the old one fails are judged by their own tolerances."""
    for _ in range(5):
        failing = arm.goal(arm.to([2.0, 2.0], 0.6), path_tolerance=[tolerance('axis_1', 1e-9)])
        good = arm.goal(arm.to([0.0, 0.0], 0.2))
        assert failing.result().status == ABORTED
        assert good.result().status == SUCCEEDED


@statement('I11', 'A13')
def test_the_ways_of_the_status(bench: Bench, arm: TrajectoryController) -> None:
    """A goal goes from accepted or executing to one terminal state and stays there."""
    topic = f'{arm.controller}/follow_joint_trajectory/_action/status'
    collector = bench.client.collect(topic, GoalStatusArray, LATCHED)
    collector.wait(1)
    known = {bytes(s.goal_info.goal_id.uuid) for s in collector.messages[-1].status_list}
    ended = arm.goal(arm.to([0.1, 0.1], 0.1))
    ended.result()
    canceled = arm.goal(arm.to([1.0, 1.0], 1.0))
    canceled.wait_for_feedback()
    canceled.cancel()
    canceled.result()
    collector.wait_for(
        lambda m: len(m.status_list) > 0 and m.status_list[-1].status == GoalStatus.STATUS_CANCELED
        and bytes(m.status_list[-1].goal_info.goal_id.uuid) not in known
    )
    ways: dict[bytes, list[int]] = {}
    for message in collector.messages:
        for status in message.status_list:
            way = ways.setdefault(bytes(status.goal_info.goal_id.uuid), [])
            if not way or way[-1] != status.status:
                way.append(status.status)
    collector.close()
    new = [way for goal, way in ways.items() if goal not in known]
    assert len(new) == 2
    for way in new:
        assert way == sorted(way)
        assert sum(code >= GoalStatus.STATUS_SUCCEEDED for code in way) == 1


@statement('H14', 'I1')
def test_goals_after_a_cancel(arm: TrajectoryController) -> None:
    """The next goal is taken at once, with no activation in between."""
    goal = arm.goal(arm.trajectory(point(1.0, [1.0, 1.0])))
    goal.wait_for_feedback()
    goal.cancel()
    assert arm.run(arm.to([0.0, 0.0], 0.2)).status == SUCCEEDED
