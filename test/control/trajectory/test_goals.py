# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Goals of the joint trajectory controller, from their acceptance to their end."""


import numpy as np
import pytest

MOVE = (1.0, [0.4, 0.0], [0, 0], [0, 0])


def test_success(rig, trajectory):
    """H9, C5, E9, I11: EXECUTING, then SUCCEEDED at the end; the reference stays there."""
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory((0.5, [0.1, 0.1]), MOVE)).goal
    assert goal.status.name == 'ACCEPTED'
    r.run(0.99)
    assert goal.status.name == 'EXECUTING'
    r.step(3)
    assert goal.status.name == 'SUCCEEDED'
    r.run(1.0)
    np.testing.assert_array_equal(arm.snapshot().reference.positions, [0.4, 0.0])


def test_done_callbacks_come_once(rig, trajectory):
    """I11: a goal ends once; who asks late is called at once."""
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory(MOVE)).goal
    calls = []
    goal.add_done_callback(calls.append)
    r.run(1.1)
    goal.add_done_callback(calls.append)
    assert calls == [goal, goal]
    assert not arm.cancel(goal)


def test_cancel_holds_the_measured_position(rig, trajectory):
    """I1, C6: CANCELED with code 0 and no text; the reference is where the arm is."""
    r = rig(gain=0.5)
    arm = r.arm()
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.run(0.5)
    measured = r.hardware.state.position.copy()
    assert arm.cancel(goal)
    assert goal.status.name == 'CANCELING'
    r.step()
    assert goal.status.name == 'CANCELED'
    assert (goal.result.code, goal.result.message) == (0, '')
    np.testing.assert_array_equal(arm.snapshot().reference.positions, measured)
    r.run(1.0)
    np.testing.assert_allclose(r.hardware.state.position, measured, atol=1e-6)


def test_cancel_of_an_old_goal_changes_nothing(rig, trajectory):
    """I2: only the active goal can be canceled."""
    r = rig()
    arm = r.arm()
    old = arm.send_goal(trajectory(MOVE)).goal
    r.step()
    new = arm.send_goal(trajectory(MOVE)).goal
    r.step()
    assert not arm.cancel(old)
    r.run(1.1)
    assert new.status.name == 'SUCCEEDED'


def test_cancel_before_the_loop_took_it_up(rig, trajectory):
    """I1, I10: a pending goal can be canceled."""
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory(MOVE)).goal
    arm.cancel(goal)
    r.run(1.0)
    assert goal.status.name == 'CANCELED'
    np.testing.assert_array_equal(r.hardware.state.position, [0.0, 0.0])


def test_new_goal_preempts(rig, trajectory):
    """I3, I4, I5, E7: the old goal is ABORTED with -1; the motion goes on without a step."""
    r = rig()
    arm = r.arm()
    old = arm.send_goal(trajectory(MOVE)).goal
    r.run(0.5)
    before = arm.snapshot().output.positions[0]
    new = arm.send_goal(trajectory((1.0, [-0.4, 0.0], [0, 0], [0, 0]))).goal
    r.step()
    assert (old.status.name, old.result.code) == ('ABORTED', -1)
    assert 'preempted' in old.result.message
    snapshot = arm.snapshot()
    assert snapshot.reference.positions[0] == before
    assert snapshot.reference.velocities[0] == pytest.approx(0.75, rel=1e-2)
    r.run(1.1)
    assert new.status.name == 'SUCCEEDED'
    np.testing.assert_allclose(r.hardware.state.position, [-0.4, 0.0])


def test_preempted_goal_is_canceled_in_ros1(rig, trajectory):
    """I4, U2: with compat ros1 the old goal is CANCELED."""
    r = rig()
    arm = r.arm(compat='ros1')
    old = arm.send_goal(trajectory(MOVE)).goal
    r.step()
    arm.send_goal(trajectory(MOVE))
    r.step()
    assert old.status.name == 'CANCELED'


def test_topic_during_goal_keeps_the_goal(rig, trajectory):
    """I8: the goal stays and is judged on the new trajectory, to its end."""
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.run(0.5)
    arm.set_trajectory(trajectory((2.0, [-0.4, 0.0])))
    r.run(1.0)
    assert goal.status.name == 'EXECUTING'
    r.run(1.1)
    assert goal.status.name == 'SUCCEEDED'
    np.testing.assert_allclose(r.hardware.state.position, [-0.4, 0.0])


def test_topic_during_goal_cancels_it_in_ros1(rig, trajectory):
    """I8, U2: with compat ros1 the goal is CANCELED."""
    r = rig()
    arm = r.arm(compat='ros1')
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.step()
    arm.set_trajectory(trajectory((1.0, [-0.4, 0.0])))
    r.step()
    assert goal.status.name == 'CANCELED'
    r.run(1.1)
    np.testing.assert_allclose(r.hardware.state.position, [-0.4, 0.0])


def test_deactivation_aborts(rig, trajectory):
    """C7, C8: the goal ends with -1, the position stays, and nothing is resumed."""
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory(MOVE)).goal
    pending = None
    r.run(0.5)
    pending = arm.send_goal(trajectory(MOVE)).goal
    r.manager.switch(deactivate=['arm'])
    assert (goal.status.name, goal.result.code) == ('ABORTED', -1)
    assert 'deactivat' in goal.result.message
    assert pending.status.name == 'ABORTED'
    command = r.hardware.command.position.copy()
    r.run(0.2)
    np.testing.assert_array_equal(r.hardware.command.position, command)
    assert np.isnan(r.hardware.feedforward.velocity).all()
    r.manager.switch(activate=['arm'])
    r.run(1.0)
    np.testing.assert_array_equal(arm.snapshot().reference.positions, command)


def test_command_timeout_aborts_a_waiting_goal(rig, trajectory):
    """H16: a goal that still waits for its tolerance is aborted with -5."""
    r = rig()
    arm = r.arm(cmd_timeout=0.3, constraints={'a': {'goal': 0.01}})
    r.hardware.frozen = True
    goal = arm.send_goal(trajectory((0.1, [0.2, 0.0]))).goal
    r.run(0.5)
    assert goal.result.code == -5
    assert 'cmd_timeout' in goal.result.message


def test_goals_are_taken_up_while_time_stands_still(rig, trajectory):
    """P5: cancels and goals are answered while physics is paused."""
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.manager.process_requests(r.now_ns)
    assert goal.status.name == 'EXECUTING'
    arm.cancel(goal)
    r.manager.process_requests(r.now_ns)
    assert goal.status.name == 'CANCELED'


def test_many_goals_end_once_each(rig, trajectory):
    """I4, I11: of many goals in one update all but the last are aborted, the last succeeds."""
    r = rig()
    arm = r.arm()
    goals = [arm.send_goal(trajectory(MOVE)).goal for _ in range(100)]
    r.run(1.1)
    assert [g.status.name for g in goals] == ['ABORTED'] * 99 + ['SUCCEEDED']


def test_goal_replaces_topic_trajectory(rig, trajectory):
    """I6, I7: topic trajectories replace each other, a goal replaces them and is judged."""
    r = rig()
    arm = r.arm()
    arm.set_trajectory(trajectory((1.0, [-1.0, 0.0])))
    r.run(0.2)
    arm.set_trajectory(trajectory((1.0, [-0.5, 0.0])))
    r.run(0.2)
    assert arm.active_goal is None
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.step()
    assert arm.active_goal is goal
    r.run(1.1)
    assert goal.status.name == 'SUCCEEDED'


def test_a_snapshot_names_the_goal_of_its_update(rig, trajectory):
    """J1: a goal that is not taken up yet, or has ended, is not the snapshot's; no old sample."""
    r = rig()
    arm = r.arm()
    assert arm.snapshot().goal is None
    first = arm.send_goal(trajectory(MOVE)).goal
    assert arm.snapshot().goal is None
    r.step()
    assert arm.snapshot().goal is first
    second = arm.send_goal(trajectory((1.0, [0.1, 0.0]))).goal
    assert arm.snapshot().goal is first
    r.step()
    assert arm.snapshot().goal is second
    assert arm.snapshot().desired_time_from_start == 0.0
    r.run(1.1)
    assert arm.snapshot().goal is None


def test_a_stream_from_before_the_goal_leaves_it_alone(rig, trajectory):
    """A topic trajectory that began before the goal came is dropped; a newer one is not."""
    r = rig()
    arm = r.arm()
    r.run(0.5)
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.step()
    began = r.now_ns - 50_000_000
    arm.set_trajectory(trajectory((0.0, [0.0, 0.0]), (0.5, [-0.3, 0.0]), stamp_ns=began))
    r.run(1.1)
    assert goal.status.name == 'SUCCEEDED'
    np.testing.assert_allclose(arm.snapshot().reference.positions, [0.4, 0.0])


@pytest.mark.parametrize(('gain', 'constraints', 'expected'), [
    (0.01, {}, True), (1.0, {}, False), (0.01, {'a': {'goal': 0.5}, 'b': {'goal': 0.5}}, False)])
def test_a_goal_that_succeeds_far_away_is_reported(rig, trajectory, gain, constraints, expected):
    """Where no goal tolerance is set, a warning names the joint that did not arrive."""
    r = rig(gain=gain)
    arm = r.arm(constraints=constraints)
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.run(1.1)
    assert goal.status.name == 'SUCCEEDED'
    assert any("goal succeeded, but joint 'a' is 0." in text for text in r.texts()) is expected


def test_success_is_a_hold_of_the_last_point(rig, trajectory):
    """
    After a goal its last point is held: times count from then on, a query finds no trajectory.

    joint_trajectory_controller.cpp, set_success_trajectory_point.
    """
    r = rig()
    arm = r.arm(command_interfaces=['position', 'effort'])
    start = r.now_ns
    arm.send_goal(trajectory((0.5, [0.2, 0.1], [], [], [2.0, 3.0])))
    r.run(0.8)
    snapshot = arm.snapshot()
    assert 0.2 < snapshot.desired_time_from_start < 0.3
    assert snapshot.desired_time_from_start == pytest.approx(snapshot.actual_time_from_start)
    np.testing.assert_allclose(snapshot.reference.positions, [0.2, 0.1])
    np.testing.assert_allclose(r.hardware.command.effort, [2.0, 3.0])
    assert not arm.query_state(start + 300_000_000).success
