# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which trajectories are taken, and what a refusal leaves behind."""

from __future__ import annotations

from collections.abc import Iterator
import math

from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointComponentTolerance
from controller_bench import Bench, point, TrajectoryController
import pytest
from std_msgs.msg import String
from trajectory_msgs.msg import (
    JointTrajectory,
    MultiDOFJointTrajectory,
    MultiDOFJointTrajectoryPoint,
)

from armsim_ros.clients.client_node import Collector, LATCHED
from armsim_ros.clients.trajectory import ABORTED, SUCCEEDED
from armsim_ros.testing.program import Program

statement = pytest.mark.statement
upstream = pytest.mark.upstream
NAMES = ['axis_1', 'axis_2']
GOOD = point(0.2, [0.1, 0.2])


def message(*points, names=NAMES) -> JointTrajectory:
    """Return a trajectory."""
    return JointTrajectory(joint_names=list(names), points=list(points))


MALFORMED = {
    'partial': ('D2', message(point(0.2, [0.1]), names=NAMES[:1])),
    'too_many_names': ('D2', message(point(0.2, [0.1, 0.2, 0.3]), names=[*NAMES, 'wheel_1'])),
    'no_names': ('D3', message(point(0.2), names=[])),
    'no_points': ('D4', message()),
    'empty': ('D4', JointTrajectory()),
    'unknown_joint': ('D5', message(GOOD, names=['axis_1', 'nobody'])),
    'another_controllers_joint': ('D5', message(GOOD, names=['axis_1', 'wheel_1'])),
    'moving_end': ('D6', message(point(0.2, [0.1, 0.2], [0.5, 0.0]))),
    'equal_times': ('D8', message(point(0.2, [0.1, 0.1]), GOOD)),
    'decreasing_times': ('D8', message(point(0.3, [0.1, 0.1]), GOOD)),
    'no_positions': ('D9', message(point(0.2))),
    'short_positions': ('D9', message(point(0.2, [0.1]))),
    'long_positions': ('D9', message(point(0.2, [0.1, 0.2, 0.3]))),
    'short_velocities': ('D9', message(point(0.2, [0.1, 0.2], [0.0]))),
    'long_accelerations': ('D9', message(point(0.2, [0.1, 0.2], [0.0, 0.0], [0.0, 0.0, 0.0]))),
    'second_point_wrong': ('D9', message(GOOD, point(0.4, [0.1]))),
    'velocities_alone': ('D9', message(point(0.2, (), [0.0, 0.0]))),
    'effort': ('D11', message(point(0.2, [0.1, 0.2], effort=[1.0, 1.0]))),
    'name_twice': ('D14', message(GOOD, names=['axis_1', 'axis_1'])),
    'not_a_number': ('D14', message(point(0.2, [math.nan, 0.2]))),
    'infinite': ('D14', message(point(0.2, [0.1, math.inf]))),
    'infinite_velocity': ('D14', message(point(0.2, [0.1, 0.1], [0.0, -math.inf]),
                                         point(0.4, [0.1, 0.1], [0.0, 0.0]))),
}
BEYOND = {
    'a_position_limit': message(point(2.0, [7.0, 0.2])),
    'a_velocity_limit': message(GOOD, point(0.25, [3.0, 0.2])),
    'the_first_step': message(point(0.0, [2.0, 0.2]), point(0.2, [2.0, 0.2])),
}
CASES = [
    pytest.param(
        trajectory,
        id=name,
        marks=[statement(number)] + ([upstream('invalid_message', 'invalidMessages')]
                                     if number in ('D2', 'D5', 'D8', 'D9') else []),
    )
    for name, (number, trajectory) in MALFORMED.items()
]


@pytest.fixture
def reasons(bench: Bench, arm: TrajectoryController) -> Iterator[Collector]:
    """Collect what the controller says of refused goals."""
    collector = bench.client.collect(f'{arm.controller}/rejected_goals', String, LATCHED)
    yield collector
    collector.close()


def reference(controller: TrajectoryController) -> list[float]:
    """Return the reference of now."""
    return list(controller.newest().reference.positions)


@pytest.mark.parametrize('trajectory', CASES)
def test_a_malformed_trajectory_is_refused(
    arm: TrajectoryController, trajectory: JointTrajectory
) -> None:
    """The action rejects it, the topic drops it, nothing moves, the next good goal is taken."""
    before = arm.newest()
    assert not arm.goal(trajectory).accepted()
    arm.publish(trajectory)
    for state in arm.watch(5):
        assert list(state.reference.positions) == list(before.reference.positions)
        assert state.feedback.positions == pytest.approx(before.feedback.positions, abs=1e-4)
    assert arm.run(arm.to([0.0, 0.0], 0.05)).status == SUCCEEDED


@statement('X1')
@pytest.mark.parametrize('trajectory', BEYOND.values(), ids=BEYOND)
def test_limits_refuse_no_goal(arm: TrajectoryController, trajectory: JointTrajectory) -> None:
    """A goal beyond the joints' limits is executed, unless reject_beyond_limits is set."""
    if 'reject_beyond_limits' in arm.parameters.names():
        assert arm.parameters.set('reject_beyond_limits', True) == ''
        try:
            assert not arm.goal(trajectory).accepted()
        finally:
            assert arm.parameters.set('reject_beyond_limits', False) == ''
    goal = arm.goal(trajectory)
    assert goal.accepted()
    goal.cancel()


@statement('D18')
@upstream('invalid_message')
def test_a_rejection_leaves_a_reason(
    bench: Bench, arm: TrajectoryController, reasons: Collector
) -> None:
    """The reason is published on rejected_goals and logged as an error."""
    assert not arm.goal(message(GOOD, names=['axis_1', 'axis_3'])).accepted()
    reasons.wait_for(lambda text: "'axis_3'" in text.data)
    if isinstance(bench.program, Program):
        bench.program.wait_for_line(r"\[ERROR\].*bench\.arm.*'axis_3'")


@statement('D18')
def test_a_refused_goal_may_be_accepted_and_aborted(bench: Bench) -> None:
    """With refused_goals 'abort' the result of a bad goal carries code and reason."""
    arm = bench.use('arm')
    if 'refused_goals' not in arm.parameters.names():
        pytest.skip('the server has no such choice')
    assert arm.parameters.set('refused_goals', 'abort') == ''
    try:
        outcome = arm.run(message(GOOD, names=['axis_1', 'axis_3']))
        assert outcome.status == ABORTED
        assert outcome.error_code == FollowJointTrajectory.Result.INVALID_JOINTS
        assert 'axis_3' in outcome.error_string
    finally:
        assert arm.parameters.set('refused_goals', 'reject') == ''


@statement('D1', 'C7')
def test_an_inactive_controller_takes_nothing(bench: Bench) -> None:
    """Goals to an inactive controller are rejected, messages to it are ignored."""
    arm = bench.use('arm')
    bench.activate()
    assert not arm.goal(arm.to([0.1, 0.1])).accepted()
    arm.publish(arm.to([0.2, 0.2], 0.05))
    bench.activate('arm')
    assert all(max(map(abs, s.reference.positions)) < 1e-6 for s in arm.watch(8))


@statement('D')
@upstream('invalid_message')
def test_a_rejected_goal_leaves_the_running_trajectory_alone(
    arm: TrajectoryController
) -> None:
    """Rejected goals and dropped messages do not disturb what runs."""
    running = arm.goal(arm.to([0.4, 0.4], 0.3))
    running.wait_for_feedback()
    assert not arm.goal(message()).accepted()
    arm.publish(message(GOOD, names=['axis_1', 'nobody']))
    assert running.result().status == SUCCEEDED
    assert arm.reaches([0.4, 0.4])


@statement('D6', 'B8')
@upstream('test_allow_nonzero_velocity_at_trajectory_end_false',
          'expect_invalid_when_trajectory_with_nonzero_end_velocity')
def test_a_tiny_end_velocity_is_none(arm: TrajectoryController) -> None:
    """Up to 1.2e-7 a velocity at the end counts as zero, more is refused."""
    assert arm.run(arm.trajectory(point(0.1, [0.0, 0.0], [1.1e-7, 0.0]))).status == SUCCEEDED
    assert not arm.goal(arm.trajectory(point(0.1, [0.0, 0.0], [2e-7, 0.0]))).accepted()


@statement('D6', 'B8')
@upstream('test_allow_nonzero_velocity_at_trajectory_end_true')
def test_an_end_velocity_may_be_allowed(bench: Bench) -> None:
    """allow_nonzero_velocity_at_trajectory_end takes a last point that moves."""
    integrating = bench.use('integrating')
    outcome = integrating.run(
        integrating.trajectory(point(0.1, [0.05, 0.0], [0.5, 0.0]))
    )
    assert outcome.status == SUCCEEDED


@statement('D7')
@upstream('test_ignore_old_trajectory', 'ignoreOldTopicTraj', 'ignoreOldActionTraj',
          'ignoreSingleOldActionTraj')
def test_a_trajectory_of_the_past_is_refused(arm: TrajectoryController) -> None:
    """A trajectory that ended before now is rejected, on the topic dropped."""
    old = arm.to([0.3, 0.3], 0.2, stamp_ns=arm.now_ns() - 1_000_000_000)
    assert not arm.goal(old).accepted()
    arm.publish(old)
    assert all(max(map(abs, s.reference.positions)) < 1e-9 for s in arm.watch(6))


@statement('D8')
def test_the_first_point_may_be_at_time_zero(arm: TrajectoryController) -> None:
    """A first point at 0 is legal."""
    trajectory = arm.trajectory(point(0.0, [0.0, 0.0]), point(0.1, [0.1, 0.1]))
    assert arm.run(trajectory).status == SUCCEEDED


@statement('D10', 'B7', 'F10')
@upstream('missing_positions_message_accepted')
def test_points_without_positions_where_integration_is_on(bench: Bench) -> None:
    """Velocities or accelerations alone are taken; wrong sizes and empty points are not."""
    c = bench.use('integrating')
    velocities = c.trajectory(point(0.1, (), [0.5, 0.5]), point(0.2, (), [0.0, 0.0]))
    accelerations = c.trajectory(
        point(0.1, (), (), [1.0, 1.0]), point(0.2, (), (), [-1.0, -1.0])
    )
    assert c.run(velocities).status == SUCCEEDED
    c.home()
    assert c.run(accelerations).status == SUCCEEDED
    c.home()
    for bad in (point(0.1, (), [0.5]), point(0.1, [0.1], [0.1, 0.1]), point(0.1)):
        assert not c.goal(c.trajectory(bad)).accepted()


@statement('D11', 'B3')
def test_effort_is_taken_where_effort_is_commanded(bench: Bench) -> None:
    """A controller with an effort interface takes efforts."""
    c = bench.use('with_effort')
    outcome = c.run(c.trajectory(point(0.1, [0.05, 0.05], effort=[0.0, 0.0])))
    assert outcome.status == SUCCEEDED


@statement('D12')
@upstream('test_jumbled_joint_order', 'jointReordering')
def test_joints_in_any_order(arm: TrajectoryController) -> None:
    """Values belong to the names of the message, whatever their order."""
    trajectory = arm.trajectory(
        point(0.1, [0.2, 0.1], [0.0, 0.0]), joints=arm.joints[::-1]
    )
    assert arm.run(trajectory).status == SUCCEEDED
    assert arm.reaches([0.1, 0.2])


@statement('D13', 'B6')
@upstream('test_partial_joint_list', 'allowPartialTrajIfSpecified', 'topicSinglePartialTraj',
          'actionSinglePartialTraj')
@pytest.mark.parametrize('way', ['action', 'topic'])
def test_joints_that_are_not_named_are_held(bench: Bench, way: str) -> None:
    """With partial goals on, joints that the message omits stand at their last command."""
    c = bench.use('partial')
    c.go([0.1, 0.3])
    assert c.reaches([0.1, 0.3])
    trajectory = c.trajectory(point(0.15, [0.25]), joints=['axis_1'])
    c.states.clear()
    if way == 'action':
        assert c.run(trajectory).status == SUCCEEDED
    else:
        c.publish(trajectory)
    c.states.wait_for(lambda s: abs(s.reference.positions[0] - 0.25) < 1e-9)
    assert all(s.reference.positions[1] == pytest.approx(0.3) for s in c.states.messages)


@statement('D13', 'D3', 'D5')
@upstream('invalidMessages')
def test_partial_goals_are_checked_too(bench: Bench) -> None:
    """No names, unknown names and wrong sizes are refused with partial goals on."""
    c = bench.use('partial')
    for names, values in ([], []), (['nobody'], [0.1]), (['axis_1'], [0.1, 0.2]):
        assert not c.goal(c.trajectory(point(0.1, values), joints=names)).accepted()


@statement('D2', 'B6')
@upstream('test_partial_joint_list_not_allowed')
def test_partial_goals_can_be_switched_on(arm: TrajectoryController) -> None:
    """allow_partial_joints_goal is dynamic and false by default."""
    part = arm.trajectory(point(0.1, [0.05]), joints=['axis_1'])
    assert not arm.goal(part).accepted()
    assert arm.parameters.set('allow_partial_joints_goal', True) == ''
    try:
        arm.watch(2)
        assert arm.run(part).status == SUCCEEDED
    finally:
        assert arm.parameters.set('allow_partial_joints_goal', False) == ''


@statement('D15')
def test_fields_that_no_one_reads(arm: TrajectoryController) -> None:
    """Multi-dof trajectories and component tolerances are ignored."""
    goal = FollowJointTrajectory.Goal(trajectory=arm.to([0.1, 0.1], 0.1))
    goal.multi_dof_trajectory = MultiDOFJointTrajectory(
        joint_names=['base'], points=[MultiDOFJointTrajectoryPoint()]
    )
    goal.component_path_tolerance = [JointComponentTolerance(joint_name='base', position=1e-9)]
    assert arm.send_goal(goal).result().status == SUCCEEDED


@statement('D16', 'D17')
@pytest.mark.parametrize('way', ['action', 'topic'])
def test_an_empty_trajectory_does_not_stop(arm: TrajectoryController, way: str) -> None:
    """Unlike in ROS 1 an empty trajectory is refused and stops nothing."""
    running = arm.goal(arm.to([0.3, 0.3], 0.25))
    running.wait_for_feedback()
    if way == 'action':
        assert not arm.goal(arm.trajectory()).accepted()
    else:
        arm.publish(arm.trajectory())
    assert running.result().status == SUCCEEDED
    assert arm.reaches([0.3, 0.3])


@statement('D9')
def test_velocities_and_accelerations_are_optional(arm: TrajectoryController) -> None:
    """Points with and without derivatives may stand side by side."""
    trajectory = arm.trajectory(
        point(0.1, [0.05, 0.05]),
        point(0.2, [0.1, 0.1], [0.5, 0.5]),
        point(0.3, [0.12, 0.12], [0.0, 0.0], [0.0, 0.0]),
    )
    assert arm.run(trajectory).status == SUCCEEDED
