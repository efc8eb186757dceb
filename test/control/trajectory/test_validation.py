# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which trajectories are refused, and with which words."""

import numpy as np
import pytest

GOOD = (1.0, [0.1, 0.2])


@pytest.fixture
def arm(rig):
    """Return an active controller for the joints a and b."""
    return rig().arm()


def refused(controller, trajectory):
    """Return the reason and make sure that nothing was accepted."""
    response = controller.send_goal(trajectory)
    assert not response.accepted
    assert response.goal is None
    assert controller.set_trajectory(trajectory) == response.reason
    return response.reason


def test_good_trajectory_is_accepted(arm, trajectory):
    """A trajectory with positions for all joints is taken."""
    assert arm.send_goal(trajectory(GOOD)).accepted


def test_inactive_controller_refuses(rig, trajectory):
    """D1: an inactive controller takes nothing."""
    r = rig()
    arm = r.arm()
    r.manager.switch(deactivate=['arm'])
    assert 'inactive' in refused(arm, trajectory(GOOD))


@pytest.mark.parametrize(
    ('statement', 'points', 'options', 'words'),
    [
        ('D2', [(1.0, [0.1])], {'joints': ('a',)}, ['2 (a, b)', 'allow_partial_joints_goal']),
        ('D4', [], {}, ['no points']),
        ('D5', [GOOD], {'joints': ('a', 'bb')}, ["'bb'", "did you mean 'b'", '(a, b)']),
        ('D6', [(1.0, [0.1, 0.2], [0.0, 0.5])], {}, ["'b'", '0.5', 'last point']),
        ('D7', [GOOD], {'stamp_ns': 2_500_000_000}, ['ended 1.5', 'is 2.500 s', 'stamp of 0']),
        ('D8', [GOOD, (1.0, [0, 0])], {}, ['point 1 is 1 s', 'increasing']),
        ('D8', [(2.0, [0, 0]), GOOD], {}, ['point 1 is 1 s', '2 s of point 0']),
        ('D9', [(1.0, [], [0, 0])], {}, ['no positions', 'allow_integration']),
        ('D9', [(1.0, [0.1])], {}, ['1 positions for 2 joints']),
        ('D9', [(1.0, [0.1, 0.2], [0.0])], {}, ['1 velocities']),
        ('D9', [(1.0, [0.1, 0.2], [0, 0], [0.0])], {}, ['1 accelerations']),
        ('D11', [(1.0, [0.1, 0.2], [], [], [1.0, 1.0])], {}, ['efforts', 'position only']),
        ('D14', [GOOD], {'joints': ('a', 'a')}, ["'a' is named 2 times"]),
        ('D14', [(1.0, [0.1, np.nan])], {}, ['nan', "'b'", 'point 0']),
        ('D14', [(1.0, [0.1, np.inf])], {}, ['inf', 'finite']),
        ('D14', [(1.0, [0.1, 0.1], [0, np.nan])], {}, ['nan', 'velocities']),
    ],
)
def test_bad_trajectory_is_refused(arm, trajectory, statement, points, options, words):
    """D2, D4, D5, D6, D7, D8, D9, D11, D14: refused; the sentence names joint, point, value."""
    reason = refused(arm, trajectory(*points, **options))
    for word in words:
        assert word in reason, statement


@pytest.mark.parametrize(
    ('points', 'words'),
    [
        ([(20.0, [11.0, 0])], ["'a'", '20 s', '11 rad', 'limit 10']),
        ([(1.0, [0, 0], [5, 0]), (2.0, [1, 0], [0, 0])], ["'a'", '1 s', 'velocity 5', 'limit 3']),
        ([(1.0, [0, 0]), (1.1, [1, 0])], ["'a'", '1 s to 1.1 s', 'velocity of 10', 'limit 3']),
        ([(0.0, [1.0, 0]), (1.0, [1.0, 0])], ["'a'", 'in 0 s', '1 rad away', 'can move 0.05']),
        ([(0.1, [2.0, 0]), (1.0, [2.0, 0])], ["'a'", 'in 0.1 s', '2 rad away', 'can move 0.35']),
    ],
)
def test_beyond_limits_is_executed_with_a_warning(rig, trajectory, points, words):
    """
    Limits of position and velocity and a first point out of reach refuse nothing.

    joint_trajectory_controller.cpp, validate_trajectory_msg has no such check. One warning names
    joint, value, limit and time; reject_beyond_limits refuses with the same words.
    """
    r = rig()
    arm = r.arm()
    r.texts()
    goal = arm.send_goal(trajectory(*points)).goal
    (text,) = r.texts()
    r.run(points[-1][0] + 0.05)
    assert goal.status.name == 'SUCCEEDED'
    np.testing.assert_allclose(r.hardware.state.position, points[-1][1])
    strict = rig().arm(reject_beyond_limits=True)
    reason = refused(strict, trajectory(*points))
    for word in words:
        assert word in text
        assert word in reason


def test_a_stream_beyond_limits_warns_once(rig, trajectory):
    """Trajectories of the topic share one warning, whatever their values."""
    r = rig()
    arm = r.arm()
    r.texts()
    for i in range(20):
        assert arm.set_trajectory(trajectory((0.1, [11.0 + i, 0.0]))) is None
        r.step()
    assert len(r.texts()) == 1


def test_past_stamp_that_leaves_too_little_time(rig, trajectory):
    """D14, E5: what remains of a late trajectory may be out of the joints' reach."""
    late = trajectory((0.5, [0.5, 0.0]), (2.0, [4.0, 0.0]), stamp_ns=5_010_000_000 - 1_900_000_000)
    r = rig()
    r.arm().send_goal(late)
    assert any('in 0.11 s, is 4 rad away' in text for text in r.texts())


def test_negative_first_time(rig, trajectory):
    """
    A trajectory may begin before its start: what is over is left out.

    joint_trajectory_controller.cpp, validate_trajectory_msg: times have to increase, no more.
    """
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory((-1.0, [0.1, 0.1]), (0.5, [0.2, 0.3]))).goal
    r.run(0.6)
    assert goal.status.name == 'SUCCEEDED'
    np.testing.assert_allclose(r.hardware.state.position, [0.2, 0.3])


def test_a_urdf_without_velocity_limit(rig, trajectory):
    """D14: a limit of 0 in the URDF is no limit."""
    arm = rig(velocity=0.0).arm()
    assert arm.send_goal(trajectory((0.01, [1.0, 0.0]))).accepted


def test_no_joint_names(rig, trajectory):
    """D3: with partial goals allowed, a trajectory still has to name a joint."""
    arm = rig().arm(allow_partial_joints_goal=True)
    assert 'names no joint' in refused(arm, trajectory((1.0, []), joints=()))


def test_integration_needs_some_field(rig, trajectory):
    """D10: with integration, a point has to give something."""
    arm = rig().arm(allow_integration_in_goal_trajectories=True)
    assert 'neither positions' in refused(arm, trajectory((1.0, [])))
    assert arm.send_goal(trajectory((1.0, [], [0.0, 0.0]))).accepted


def test_order_of_joints_is_free(rig, trajectory):
    """D12: values are sorted by name into the controller's order."""
    r = rig()
    arm = r.arm()
    arm.send_goal(trajectory((0.5, [0.2, 0.1]), joints=('b', 'a')))
    r.run(1.0)
    np.testing.assert_allclose(arm.snapshot().feedback.positions, [0.1, 0.2])


def test_missing_joints_are_held(rig, trajectory):
    """D13: with partial goals, joints that are not named stay where they are commanded."""
    r = rig()
    arm = r.arm(allow_partial_joints_goal=True)
    arm.send_goal(trajectory((0.5, [0.2, 0.1])))
    r.run(1.0)
    arm.send_goal(trajectory((0.5, [0.5], [0.0]), joints=('b',)))
    r.run(1.0)
    np.testing.assert_allclose(arm.snapshot().feedback.positions, [0.2, 0.5])


def test_nonzero_end_velocity_by_parameter(rig, trajectory):
    """B8: allow_nonzero_velocity_at_trajectory_end lets it pass."""
    arm = rig().arm(allow_nonzero_velocity_at_trajectory_end=True)
    assert arm.send_goal(trajectory((1.0, [0.1, 0.2], [0.0, 0.5]))).accepted


def test_refusal_is_an_event(rig, trajectory):
    """D18: every refused goal leaves its reason for the log."""
    r = rig()
    arm = r.arm()
    r.manager.poll_events()
    reason = arm.send_goal(trajectory()).reason
    (event,) = r.manager.poll_events()
    assert (event.kind, event.level, event.source) == ('goal_rejected', 'error', 'arm')
    assert reason in event.text


def test_refused_goals_can_be_aborted_instead(rig, trajectory):
    """D18: with refused_goals abort, the goal's result carries code and reason."""
    arm = rig().arm(refused_goals='abort')
    response = arm.send_goal(trajectory(GOOD, joints=('a', 'x')))
    assert response.accepted
    assert response.goal.status.name == 'ABORTED'
    assert response.goal.result.code == -2
    assert "'x'" in response.goal.result.message


def test_refused_goal_does_not_disturb_the_running_one(rig, trajectory):
    """I4: the running goal goes on as if nothing had come."""
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory((1.0, [0.4, 0.0], [0, 0]))).goal
    r.run(0.5)
    assert not arm.send_goal(trajectory()).accepted
    assert arm.set_trajectory(trajectory()) is not None
    r.run(0.6)
    assert goal.status.name == 'SUCCEEDED'
