# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories through the real simulation program: goals, cancels, refusals, the topic."""

from collections.abc import Iterator, Sequence
import itertools
import math

from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTrajectoryControllerState
from control_msgs.srv import QueryTrajectoryState
import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectory

from armsim_ros.clients.client_node import ClientNode, Collector, LATCHED
from armsim_ros.clients.trajectory import (
    ABORTED,
    CANCELED,
    SUCCEEDED,
    trajectory_message,
    TrajectoryClient,
)
from armsim_ros.nodes.conversions.time import ns_from_time, seconds_from_duration, time_from_ns
from armsim_ros.testing.program import Program

CONTROLLER = '/sunday/arm_joint_controller'
JOINTS = [f'joint_{i}' for i in range(1, 7)]
RESULT = FollowJointTrajectory.Result


@pytest.fixture(scope='module')
def arm(simulation: Program, client: ClientNode) -> TrajectoryClient:
    """Give a client of the arm's controller."""
    arm = TrajectoryClient(client, CONTROLLER)
    arm.wait_for_server()
    return arm


@pytest.fixture(scope='module')
def states(simulation: Program, client: ClientNode) -> Collector:
    """Collect joint states."""
    states = client.collect('/sunday/joint_states', JointState)
    states.wait(1)
    return states


@pytest.fixture(scope='module')
def rejections(simulation: Program, client: ClientNode) -> Collector:
    """Collect reasons of refusals."""
    return client.collect(f'{CONTROLLER}/rejected_goals', String, LATCHED)


@pytest.fixture
def controller_state(arm: TrajectoryClient) -> Iterator[Collector]:
    """Collect controller states from now on."""
    collector = arm.client.collect(
        f'{CONTROLLER}/controller_state', JointTrajectoryControllerState
    )
    collector.wait(1)
    yield collector
    collector.close()


def positions(states: Collector) -> list[float]:
    """Return the newest joint positions in the order of JOINTS."""
    message = states.messages[-1]
    return [message.position[list(message.name).index(name)] for name in JOINTS]


def all_at(value: float, seconds: float) -> JointTrajectory:
    """Return a trajectory that moves every joint to a value."""
    return trajectory_message(JOINTS, [(seconds, [value] * 6)], [[0.0] * 6])


def at_rest_at_zero(state: JointState) -> bool:
    """Return whether no joint moves or is elsewhere; earlier states may still be under way."""
    return max(map(abs, (*state.position, *state.velocity))) < 1e-3


def go_to(arm: TrajectoryClient, value: float, seconds: float = 0.3) -> None:
    """Move every joint to a value and wait for the end."""
    assert arm.send(all_at(value, seconds)).result().status == SUCCEEDED


def test_a_goal_runs_to_success(arm: TrajectoryClient, states: Collector) -> None:
    """H9: the result is SUCCEEDED with code 0, and the arm is there, below 1 mrad off."""
    outcome = arm.send(
        all_at(0.2, 0.5), goal_tolerance=dict.fromkeys(JOINTS, 0.001), goal_time_tolerance=1.0
    ).result()
    assert outcome.status == SUCCEEDED
    assert outcome.error_code == RESULT.SUCCESSFUL
    assert 'success' in outcome.error_string.lower()
    states.wait_for(
        lambda message: all(abs(position - 0.2) < 1e-3 for position in message.position)
    )


def test_feedback_tells_desired_actual_and_error(arm: TrajectoryClient) -> None:
    """J1, J2: feedback comes at 20 Hz while the goal is active, in controller order."""
    go_to(arm, 0.0)
    goal = arm.send(all_at(0.3, 1.0))
    assert goal.result().status == SUCCEEDED
    feedback = goal.wait_for_feedback(15)
    assert len(feedback) <= 25
    for message in feedback:
        assert list(message.joint_names) == JOINTS
        assert len(message.desired.positions) == 6
        for desired, actual, error in zip(
            message.desired.positions,
            message.actual.positions,
            message.error.positions,
            strict=True,
        ):
            assert desired - actual == pytest.approx(error, abs=1e-9)
            assert abs(error) < 1e-3
    times = [seconds_from_duration(message.desired.time_from_start) for message in feedback]
    assert times == sorted(times)
    stamps = [ns_from_time(message.header.stamp) for message in feedback]
    assert all(a < b for a, b in itertools.pairwise(stamps))


def test_a_canceled_goal_ends_canceled_and_the_arm_stops(
    arm: TrajectoryClient, states: Collector
) -> None:
    """I1: CANCELED with code 0 and no text; the arm stays where it was."""
    go_to(arm, 0.0)
    goal = arm.send(all_at(1.0, 4.0))
    goal.wait_for_feedback(3)
    assert goal.cancel()
    outcome = goal.result()
    assert outcome.status == CANCELED
    assert outcome.error_code == RESULT.SUCCESSFUL
    states.clear()
    samples = states.wait(10)
    moved = max(
        abs(a - b)
        for a, b in zip(samples[-1].position, samples[-5].position, strict=True)
    )
    assert moved < 1e-3
    assert max(positions(states)) < 0.5
    assert not goal.cancel()


def test_a_new_goal_preempts_the_old_one(arm: TrajectoryClient) -> None:
    """I4: the old goal is ABORTED with INVALID_GOAL and the new one proceeds."""
    go_to(arm, 0.0)
    old = arm.send(all_at(0.5, 3.0))
    old.wait_for_feedback()
    new = arm.send(all_at(0.1, 0.4))
    outcome = old.result()
    assert outcome.status == ABORTED
    assert outcome.error_code == RESULT.INVALID_GOAL
    assert 'preempt' in outcome.error_string.lower()
    assert new.result().status == SUCCEEDED


def malformed() -> Sequence[tuple[str, JointTrajectory]]:
    """Return what must be refused."""
    good = [0.1] * 6
    wrong_size = trajectory_message(JOINTS, [(1.0, [0.1] * 5)])
    bad_velocity = trajectory_message(JOINTS, [(1.0, good)], [[0.0] * 5])
    return [
        ('wrong name', trajectory_message([*JOINTS[:5], 'elbow'], [(1.0, good)])),
        ('duplicate name', trajectory_message([*JOINTS[:5], 'joint_1'], [(1.0, good)])),
        ('no names', trajectory_message([], [(1.0, [])])),
        ('missing joint', trajectory_message(JOINTS[:5], [(1.0, good[:5])])),
        ('no points', trajectory_message(JOINTS, [])),
        ('empty', JointTrajectory()),
        ('wrong size', wrong_size),
        ('wrong velocity size', bad_velocity),
        ('unsorted', trajectory_message(JOINTS, [(1.0, good), (0.5, good)])),
        ('equal times', trajectory_message(JOINTS, [(1.0, good), (1.0, good)])),
        ('NaN', trajectory_message(JOINTS, [(1.0, [math.nan, *good[1:]])])),
        ('infinite', trajectory_message(JOINTS, [(1.0, [math.inf, *good[1:]])])),
        ('moving end', trajectory_message(JOINTS, [(1.0, good)], [[0.5] * 6])),
    ]


@pytest.mark.parametrize(
    'trajectory', [pytest.param(bad, id=name) for name, bad in malformed()]
)
def test_a_malformed_goal_is_refused_with_a_reason(
    arm: TrajectoryClient,
    states: Collector,
    rejections: Collector,
    simulation: Program,
    trajectory: JointTrajectory,
) -> None:
    """D1 to D14: rejected, the reason is published and logged, nothing moves, the next works."""
    go_to(arm, 0.0, 0.1)
    rejections.clear()
    lines = len(simulation.output)
    states.clear()
    states.wait_for(at_rest_at_zero)
    before = positions(states)
    goal = arm.send(trajectory)
    assert not goal.accepted()
    reason = rejections.wait(1)[0].data
    assert len(reason) > 10
    simulation.wait_for_line(r'\[ERROR\].*arm_joint_controller.*rejected', after=lines)
    states.clear()
    states.wait(3)
    after = positions(states)
    assert max(abs(a - b) for a, b in zip(before, after, strict=True)) < 1e-4
    go_to(arm, 0.01, 0.05)


def test_a_refused_goal_does_not_disturb_the_running_one(arm: TrajectoryClient) -> None:
    """I4: a goal that is rejected leaves the active one alone."""
    go_to(arm, 0.0)
    running = arm.send(all_at(0.2, 0.6))
    running.wait_for_feedback()
    assert not arm.send(trajectory_message(JOINTS, [])).accepted()
    assert running.result().status == SUCCEEDED


def test_joints_may_come_in_any_order(arm: TrajectoryClient, states: Collector) -> None:
    """D12: values are assigned by name."""
    names = JOINTS[::-1]
    values = [0.01 * int(name[-1]) for name in names]
    outcome = arm.send(trajectory_message(names, [(0.4, values)])).result()
    assert outcome.status == SUCCEEDED
    expected = [0.01 * i for i in range(1, 7)]
    states.wait_for(
        lambda message: all(
            abs(message.position[list(message.name).index(name)] - value) < 1e-3
            for name, value in zip(JOINTS, expected, strict=True)
        )
    )


def test_the_topic_moves_the_arm(arm: TrajectoryClient, states: Collector) -> None:
    """A2: a message on joint_trajectory is followed without a goal."""
    go_to(arm, 0.0)
    arm.publish(all_at(0.15, 0.3))
    states.wait_for(
        lambda message: all(abs(position - 0.15) < 1e-3 for position in message.position)
    )


def test_query_state_samples_the_running_trajectory(
    arm: TrajectoryClient, controller_state: Collector
) -> None:
    """L1, L2: the reference at an absolute time, in controller order."""
    go_to(arm, 0.0)
    goal = arm.send(all_at(0.4, 1.0))
    stamp = ns_from_time(goal.wait_for_feedback(2)[-1].header.stamp)
    request = QueryTrajectoryState.Request(time=time_from_ns(stamp))
    answer = arm.client.call(f'{CONTROLLER}/query_state', QueryTrajectoryState, request)
    assert answer.success, answer.message
    assert list(answer.name) == JOINTS
    assert 0.0 < answer.position[0] < 0.4
    assert answer.velocity[0] > 0.0
    late = QueryTrajectoryState.Request(time=time_from_ns(stamp + 3_600_000_000_000))
    refusal = arm.client.call(f'{CONTROLLER}/query_state', QueryTrajectoryState, late)
    assert not refusal.success
    assert refusal.message
    assert goal.result().status == SUCCEEDED


def test_controller_state_is_consistent_when_idle(
    arm: TrajectoryClient, controller_state: Collector
) -> None:
    """J3, J4, J5, C10: names, reference, feedback, error and output fit together."""
    go_to(arm, 0.1)
    controller_state.clear()
    for state in controller_state.wait(5):
        assert list(state.joint_names) == JOINTS
        assert len(state.reference.positions) == 6
        assert len(state.feedback.positions) == 6
        assert len(state.output.positions) == 6
        assert len(state.output.velocities) == 0
        assert state.speed_scaling_factor == 1.0
        for reference, feedback, error in zip(
            state.reference.positions, state.feedback.positions, state.error.positions, strict=True
        ):
            assert reference - feedback == pytest.approx(error, abs=1e-9)


def test_a_client_that_vanishes_does_not_stop_the_motion(
    arm: TrajectoryClient, states: Collector, ros_domain: int
) -> None:
    """A goal belongs to the server once it is accepted."""
    go_to(arm, 0.0)
    with ClientNode(ros_domain, 'short_lived') as other:
        goal = TrajectoryClient(other, CONTROLLER).send(all_at(0.25, 1.0))
        goal.wait_for_feedback(1)
    states.wait_for(
        lambda message: all(abs(position - 0.25) < 1e-3 for position in message.position)
    )
    go_to(arm, 0.0)


def test_a_burst_of_goals_ends_each_of_them(arm: TrajectoryClient) -> None:
    """I11: every accepted goal gets exactly one terminal result, the last one succeeds."""
    goals = [arm.send(all_at(0.01 * (i % 7), 0.3)) for i in range(40)]
    statuses = [goal.result().status for goal in goals]
    assert set(statuses) <= {SUCCEEDED, ABORTED}
    assert statuses[-1] == SUCCEEDED
