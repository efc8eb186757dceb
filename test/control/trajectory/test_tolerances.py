# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tolerances of parameters and goals, and what their violation does."""

import numpy as np
import pytest

from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.control.controller import NEVER_NS
from armsim_ros.control.trajectory.tolerances import JointTolerance, SegmentTolerances

CONSTRAINTS = {
    'goal_time': 0.2,
    'a': {'trajectory': 0.1, 'goal': 0.05},
    'b': {'trajectory': 0.1, 'goal': 0.05},
}
MOVE = (1.0, [1.0, 0.0], [0, 0])


@pytest.fixture
def defaults():
    """Return the tolerances of the parameters above."""
    return SegmentTolerances.of(
        JointTrajectoryControllerParameters(joints=('a', 'b'), constraints=CONSTRAINTS)
    )


def test_defaults_come_from_parameters(defaults):
    """H1: trajectory, goal, stopped_velocity_tolerance, goal_time; 0 is unchecked."""
    np.testing.assert_array_equal(defaults.path[0], [0.1, 0.1])
    np.testing.assert_array_equal(defaults.goal, [[0.05] * 2, [0.01] * 2, [np.inf] * 2])
    assert np.isinf(defaults.path[1:]).all()
    assert defaults.goal_time == 0.2


def test_goal_overrides_field_by_field(defaults):
    """H2: a value counts, 0 keeps the default, -1 takes the tolerance away."""
    path = [JointTolerance('b', position=0.3), JointTolerance('a', position=-1.0, velocity=2.0)]
    mixed, complaint = defaults.overridden(('a', 'b'), path, [JointTolerance('a')], -1.0)
    assert complaint == ''
    np.testing.assert_array_equal(mixed.path[0], [np.inf, 0.3])
    np.testing.assert_array_equal(mixed.path[1], [2.0, np.inf])
    np.testing.assert_array_equal(mixed.goal, defaults.goal)
    assert mixed.goal_time == 0.0


@pytest.mark.parametrize(
    ('path', 'goal', 'time', 'word'),
    [
        ([JointTolerance('a', position=-2.0)], [], 0.0, '-2'),
        ([], [JointTolerance('a', velocity=-0.5)], 0.0, 'velocity'),
        ([], [], -3.0, '-3 s'),
        ([JointTolerance('x', position=1.0)], [], 0.0, "'x'"),
        ([JointTolerance('a', position=0.5)], [JointTolerance('x')], 0.0, "'x'"),
        ([JointTolerance('a', position=float('nan'))], [], 0.0, 'nan'),
    ],
)
def test_bad_tolerances_leave_all_defaults(defaults, path, goal, time, word):
    """H3: another negative number or an unknown joint puts the defaults in force."""
    same, complaint = defaults.overridden(('a', 'b'), path, goal, time)
    assert same is defaults
    assert word in complaint


def test_goal_with_bad_tolerances_is_accepted(rig, trajectory):
    """H3: the goal is taken, and a warning tells."""
    r = rig()
    arm = r.arm()
    assert arm.send_goal(trajectory(MOVE), [JointTolerance('x', 1.0)]).accepted
    assert any("'x'" in text for text in r.texts())


def test_path_violation_aborts_and_holds(rig, trajectory):
    """H7: ABORTED with -4, joint, error, limit and time in words; the arm holds where it is."""
    r = rig()
    arm = r.arm(constraints=CONSTRAINTS)
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.run(0.2)
    r.hardware.frozen = True
    where = r.hardware.state.position.copy()
    r.run(0.5)
    assert goal.status.name == 'ABORTED'
    assert goal.result.code == -4
    for word in ('path tolerance', "'a'", 'position error 0.112', 'exceeds 0.1', ' 0.300 s after'):
        assert word in goal.result.message
    np.testing.assert_allclose(arm.snapshot().reference.positions, where)
    r.hardware.frozen = False
    assert arm.send_goal(trajectory(MOVE)).accepted, 'H14: the next goal is taken at once'
    r.run(1.1)
    np.testing.assert_allclose(r.hardware.state.position, [1.0, 0.0])


def test_goal_violation_aborts_after_the_goal_time(rig, trajectory):
    """H10: ABORTED with -5; the text tells the time since the last waypoint."""
    r = rig()
    arm = r.arm(constraints={'goal_time': 0.2, 'a': {'goal': 0.05}})
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.hardware.frozen = True
    r.run(1.19)
    assert goal.status.name == 'EXECUTING'
    r.run(0.05)
    assert goal.result.code == -5
    assert 'goal_time_tolerance' in goal.result.message
    assert '0.210000 s' in goal.result.message
    assert "'a'" in goal.result.message


def test_goal_time_zero_waits(rig, trajectory):
    """H11: without a goal time the goal waits until the joint arrives."""
    r = rig()
    arm = r.arm(constraints={'a': {'goal': 0.05}})
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.hardware.frozen = True
    r.run(5.0)
    assert goal.status.name == 'EXECUTING'
    r.hardware.frozen = False
    r.step(2)
    assert goal.status.name == 'SUCCEEDED'


def test_goal_time_zero_is_strict_in_ros1(rig, trajectory):
    """H11, U2: with compat ros1 the first update after the end decides."""
    r = rig()
    arm = r.arm(constraints={'a': {'goal': 0.05}}, compat='ros1')
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.hardware.frozen = True
    r.run(1.05)
    assert goal.result.code == -5


def test_without_constraints_success_at_the_end(rig, trajectory):
    """H12: nothing is checked; success comes at the nominal end."""
    r = rig()
    arm = r.arm()
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.hardware.frozen = True
    r.run(0.99)
    assert goal.status.name == 'EXECUTING'
    r.step(2)
    assert goal.status.name == 'SUCCEEDED'
    assert 'success' in goal.result.message
    assert goal.result.code == 0


def test_tolerances_hold_for_their_goal_only(rig, trajectory):
    """H4: the next goal is judged by the defaults again."""
    r = rig()
    arm = r.arm(constraints=CONSTRAINTS)
    loose = [JointTolerance('a', 10.0), JointTolerance('b', 10.0)]
    first = arm.send_goal(trajectory(MOVE), loose, loose).goal
    r.hardware.frozen = True
    r.run(1.1)
    assert first.status.name == 'SUCCEEDED'
    second = arm.send_goal(trajectory((1.0, [0.5, 0.5], [0, 0]))).goal
    r.run(0.5)
    assert second.result.code == -4


def test_first_sample_is_always_checked(rig, trajectory):
    """H5: a single point at time 0 far away breaks the path tolerance, and nothing moves."""
    r = rig()
    arm = r.arm(constraints=CONSTRAINTS)
    goal = arm.send_goal(trajectory((0.0, [1.0, 0.0]))).goal
    r.step(3)
    assert goal.result.code == -4
    np.testing.assert_array_equal(r.hardware.state.position, [0.0, 0.0])


def test_velocity_is_not_judged_for_position_commands(rig, trajectory):
    """H6: with position commands alone no velocity error is formed."""
    r = rig()
    arm = r.arm(constraints={'stopped_velocity_tolerance': 1e-9})
    tight = [JointTolerance('a', velocity=1e-9)]
    goal = arm.send_goal(trajectory(MOVE), tight, tight).goal
    r.run(1.1)
    assert goal.status.name == 'SUCCEEDED'


def test_velocity_is_judged_for_velocity_commands(rig, trajectory):
    """H6: with velocity commands a path velocity tolerance is in force."""
    r = rig()
    arm = r.arm(command_interfaces=['velocity'], gains={'a': {'p': 1.0}, 'b': {'p': 1.0}})
    goal = arm.send_goal(trajectory(MOVE), [JointTolerance('a', velocity=0.01)]).goal
    r.run(0.5)
    assert goal.result.code == -4
    assert "'a' velocity error" in goal.result.message


def test_topic_violation_holds(rig, trajectory):
    """H8: a trajectory from the topic is stopped, with an error in the log."""
    r = rig()
    arm = r.arm(constraints=CONSTRAINTS)
    assert arm.set_trajectory(trajectory(MOVE)) is None
    r.hardware.frozen = True
    r.run(0.6)
    np.testing.assert_array_equal(arm.snapshot().reference.positions, [0.0, 0.0])
    assert any('path tolerance' in text for text in r.texts())


def test_topic_is_judged_by_defaults(rig, trajectory):
    """H15: the tolerances of the last goal do not reach a later topic trajectory."""
    r = rig()
    arm = r.arm()
    arm.send_goal(trajectory((0.5, [0.1, 0.0])), [JointTolerance('a', 1e-6)])
    r.run(0.6)
    r.hardware.gain = 0.1
    arm.set_trajectory(trajectory(MOVE))
    r.run(3.0)
    np.testing.assert_allclose(r.hardware.state.position, [1.0, 0.0], atol=1e-3)


def test_holding_is_not_judged(rig, trajectory):
    """C4: a push while holding is no violation; the reference stays."""
    r = rig()
    arm = r.arm(constraints=CONSTRAINTS)
    r.texts()
    r.hardware.frozen = True
    r.hardware.state.position[:] = 5.0
    r.run(1.0)
    np.testing.assert_array_equal(arm.snapshot().reference.positions, [0.0, 0.0])
    assert r.texts() == []


def test_goal_time_counts_scaled_time(rig, trajectory):
    """H17: at half pace the goal time lasts twice as long."""
    r = rig()
    arm = r.arm(constraints={'goal_time': 0.2, 'a': {'goal': 0.05}})
    arm.set_speed_scaling(0.5)
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.hardware.frozen = True
    r.run(2.38)
    assert goal.status.name == 'EXECUTING'
    r.run(0.1)
    assert goal.result.code == -5


def test_path_errors_compare_with_the_scaled_reference(rig, trajectory):
    """H17: a slower pace is no path error."""
    r = rig()
    arm = r.arm(constraints=CONSTRAINTS)
    arm.set_speed_scaling(0.25)
    goal = arm.send_goal(trajectory(MOVE)).goal
    r.run(4.1)
    assert goal.status.name == 'SUCCEEDED'


def test_new_constraints_reach_the_next_goal(rig, trajectory):
    """B23: a running goal keeps its tolerances, the next one has the new."""
    r = rig()
    arm = r.arm(constraints={'a': {'goal': 0.5}, 'goal_time': 0.1})
    first = arm.send_goal(trajectory((0.5, [0.3, 0.0], [0, 0]))).goal
    r.hardware.frozen = True
    r.run(0.2)
    arm.set_parameters({'constraints.a.goal': 0.01})
    r.run(0.4)
    assert first.status.name == 'SUCCEEDED'
    second = arm.send_goal(trajectory((0.5, [0.3, 0.0], [0, 0]))).goal
    r.run(0.8)
    assert second.result.code == -5


@pytest.mark.parametrize('value', [0.0, -0.01])
def test_a_tolerance_parameter_that_is_not_positive_is_unchecked(rig, trajectory, value):
    """
    Path, goal and velocity tolerances of the parameters count only where they are above 0.

    tolerances.hpp, check_state_tolerance_per_joint.
    """
    r = rig()
    arm = r.arm(constraints={'a': {'trajectory': value, 'goal': value},
                             'stopped_velocity_tolerance': value})
    goal = arm.send_goal(trajectory((0.2, [0.1, 0.0]))).goal
    r.hardware.frozen = True
    r.run(0.3)
    assert goal.status.name == 'SUCCEEDED'


def test_a_goals_tolerance_of_minus_one_is_rounded(rig, trajectory):
    """A float near -1 erases (tolerances.hpp, resolve_tolerance_source)."""
    r = rig()
    arm = r.arm(constraints={'a': {'goal': 0.01}, 'goal_time': 0.1})
    tolerance = JointTolerance('a', position=-1.00000001)
    goal = arm.send_goal(trajectory((0.2, [0.1, 0.0])), goal_tolerances=[tolerance]).goal
    r.hardware.frozen = True
    r.run(0.3)
    assert goal.status.name == 'SUCCEEDED'


def test_a_topic_trajectory_is_given_up_later(rig, trajectory):
    """
    After a topic's trajectory the goal tolerance goes on being checked, from goal_time on.

    joint_trajectory_controller.cpp, update: only set_hold_position ends the checks. The joints
    are held where they are then.
    """
    r = rig()
    arm = r.arm(constraints={'goal_time': 0.2, 'a': {'goal': 0.05}})
    arm.set_trajectory(trajectory((0.1, [0.2, 0.0])))
    r.run(3.0)
    assert arm.snapshot().reference.positions[0] == 0.2
    r.hardware.frozen = True
    r.hardware.state.position[0] = 0.3
    r.step(2)
    assert arm.snapshot().reference.positions[0] == 0.3
    assert any('goal_time_tolerance exceeded' in text for text in r.texts())


def test_after_a_goal_nothing_is_checked(rig, trajectory):
    """A goal that has succeeded is held (set_success_trajectory_point)."""
    r = rig()
    arm = r.arm(constraints={'goal_time': 0.2, 'a': {'goal': 0.05}})
    arm.send_goal(trajectory((0.1, [0.2, 0.0])))
    r.run(3.0)
    r.hardware.frozen = True
    r.hardware.state.position[0] = 0.3
    r.run(1.0)
    assert arm.snapshot().reference.positions[0] == 0.2


def test_the_checks_after_a_topic_trajectory_are_few(rig, trajectory):
    """They need an update every 10 ms, and none without goal tolerance or goal_time."""
    for constraints, wait_ns in (({'goal_time': 0.2, 'a': {'goal': 0.05}}, 10_000_000),
                                 ({'a': {'goal': 0.05}}, NEVER_NS)):
        r = rig()
        arm = r.arm(constraints={'stopped_velocity_tolerance': 0.0, **constraints})
        arm.set_trajectory(trajectory((0.1, [0.2, 0.0])))
        r.run(0.5)
        due_ns = arm.next_update(r.now_ns)
        assert r.now_ns - 2_000 <= due_ns <= r.now_ns if wait_ns < NEVER_NS else due_ns == NEVER_NS
        assert arm.next_update(r.now_ns - 9_000_000) > r.now_ns - 9_000_000
