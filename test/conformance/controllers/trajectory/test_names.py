# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Names, types, qualities of service and rates of a trajectory controller's endpoints."""

from __future__ import annotations

import itertools
import statistics

from action_msgs.msg import GoalStatusArray
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTrajectoryControllerState
from controller_bench import Bench, nanoseconds, PERIOD, point, seconds, TrajectoryController
import pytest
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from armsim_ros.clients.trajectory import SUCCEEDED

statement = pytest.mark.statement
VOLATILE, TRANSIENT_LOCAL = QoSDurabilityPolicy.VOLATILE, QoSDurabilityPolicy.TRANSIENT_LOCAL
RELIABLE, BEST_EFFORT = QoSReliabilityPolicy.RELIABLE, QoSReliabilityPolicy.BEST_EFFORT
PROFILES = [
    pytest.param(
        QoSProfile(depth=10, reliability=r, durability=d), id=f'{r.name}-{d.name}'.lower()
    )
    for r, d in itertools.product((RELIABLE, BEST_EFFORT), (VOLATILE, TRANSIENT_LOCAL))
]


@statement('A1')
def test_action_name_and_type(bench: Bench, arm: TrajectoryController) -> None:
    """The action is follow_joint_trajectory of type FollowJointTrajectory."""
    services = dict(bench.client.node.get_service_names_and_types())
    name = f'{arm.controller}/follow_joint_trajectory/_action/send_goal'
    assert services[name] == ['control_msgs/action/FollowJointTrajectory_SendGoal']


@statement('A2', 'A3', 'A5')
def test_topic_names_and_types(bench: Bench, arm: TrajectoryController) -> None:
    """Topics joint_trajectory, controller_state and speed_scaling_input have their types."""
    topics = dict(bench.client.node.get_topic_names_and_types())
    assert topics[f'{arm.controller}/joint_trajectory'] == ['trajectory_msgs/msg/JointTrajectory']
    assert topics[f'{arm.controller}/controller_state'] == [
        'control_msgs/msg/JointTrajectoryControllerState'
    ]
    assert topics[f'{arm.controller}/speed_scaling_input'] == [
        'control_msgs/msg/SpeedScalingFactor'
    ]


@statement('A5')
def test_speed_scaling_only_with_position_commands(bench: Bench) -> None:
    """A controller that commands more than positions takes no pace."""
    bench.use('two_levels')
    topic = bench.name('two_levels/speed_scaling_input')
    assert bench.client.node.count_subscribers(topic) == 0


@statement('A4')
def test_query_state_name_and_type(bench: Bench, arm: TrajectoryController) -> None:
    """The service query_state has type QueryTrajectoryState."""
    services = dict(bench.client.node.get_service_names_and_types())
    assert services[f'{arm.controller}/query_state'] == ['control_msgs/srv/QueryTrajectoryState']


@statement('A6')
def test_a_controller_is_a_node_without_lifecycle_services(
    bench: Bench, arm: TrajectoryController
) -> None:
    """The node has the controller's name and parameters, but no lifecycle services or topic."""
    assert arm.parameters.get('constraints.goal_time') == 0.0
    node = bench.client.node
    assert ('arm', bench.namespace) in node.get_node_names_and_namespaces()
    services = dict(node.get_service_names_and_types())
    topics = dict(node.get_topic_names_and_types())
    assert f'{arm.controller}/change_state' not in services
    assert f'{arm.controller}/get_state' not in services
    assert f'{arm.controller}/transition_event' not in topics


@statement('A8')
def test_feedback_has_the_layout_of_jazzy(arm: TrajectoryController) -> None:
    """Goal, result and feedback travel whole with the layout of control_msgs 5."""
    goal = arm.goal(arm.to([0.1, 0.2]))
    feedback = goal.wait_for_feedback()[0]
    assert goal.result().status == SUCCEEDED
    assert list(feedback.joint_names) == arm.joints
    assert 'index' not in FollowJointTrajectory.Feedback.get_fields_and_field_types()


@statement('A9')
@pytest.mark.parametrize(
    ('name', 'code'),
    [('SUCCESSFUL', 0), ('INVALID_GOAL', -1), ('INVALID_JOINTS', -2),
     ('OLD_HEADER_TIMESTAMP', -3), ('PATH_TOLERANCE_VIOLATED', -4),
     ('GOAL_TOLERANCE_VIOLATED', -5)],
)
def test_result_codes(name: str, code: int) -> None:
    """The constants of the result have Jazzy's values."""
    assert getattr(FollowJointTrajectory.Result, name) == code


@statement('A10', 'A11')
@pytest.mark.parametrize('topic', ['arm/controller_state', 'joint_states'])
def test_publishers_are_reliable_and_transient_local(
    bench: Bench, arm: TrajectoryController, topic: str
) -> None:
    """Publishers of states offer reliable and transient-local."""
    arm.newest()
    infos = bench.client.node.get_publishers_info_by_topic(bench.name(topic))
    assert {(i.qos_profile.reliability, i.qos_profile.durability) for i in infos} == {
        (RELIABLE, TRANSIENT_LOCAL)
    }


@statement('A10', 'A11')
def test_subscriptions_ask_for_little(bench: Bench, arm: TrajectoryController) -> None:
    """The subscription to joint_trajectory is best effort and volatile."""
    arm.wait_for_server()
    (info,) = bench.client.node.get_subscriptions_info_by_topic(
        f'{arm.controller}/joint_trajectory'
    )
    assert info.qos_profile.reliability == BEST_EFFORT
    assert info.qos_profile.durability == VOLATILE


@statement('A12')
@pytest.mark.parametrize('profile', PROFILES)
def test_any_subscriber_gets_the_state(
    bench: Bench, arm: TrajectoryController, profile: QoSProfile
) -> None:
    """Every choice of reliability and durability gets controller_state and joint_states."""
    state = bench.client.collect(
        f'{arm.controller}/controller_state', JointTrajectoryControllerState, profile
    )
    joints = bench.client.collect(bench.name('joint_states'), JointState, profile)
    state.wait(2)
    joints.wait(2)
    state.close()
    joints.close()


@statement('A12')
@pytest.mark.parametrize('profile', PROFILES)
def test_any_publisher_moves_the_arm(
    bench: Bench, arm: TrajectoryController, profile: QoSProfile
) -> None:
    """Every choice of reliability and durability is heard on joint_trajectory."""
    node = bench.client.node
    topic = f'{arm.controller}/joint_trajectory'
    publisher = node.create_publisher(JointTrajectory, topic, profile)
    arm.states.clear()
    arm.states.wait_for(lambda _: publisher.get_subscription_count() > 0)
    # A best-effort message may meet a match that only one side knows: send until heard.
    publisher.publish(arm.to([0.2, 0.1], 0.05))
    for _ in range(20):
        states = arm.watch(10)
        if abs(states[-1].reference.positions[0] - 0.2) < 1e-9:
            break
        publisher.publish(arm.to([0.2, 0.1], 0.05))
    bench.client.in_executor(lambda: node.destroy_publisher(publisher))
    assert states[-1].reference.positions[0] == pytest.approx(0.2)


@statement('A12')
def test_latched_speed_scaling_is_heard(bench: Bench, arm: TrajectoryController) -> None:
    """A transient-local publisher of the pace is heard, as upstream's documentation asks."""
    try:
        arm.set_speed(0.5)
    finally:
        arm.set_speed(1.0)
    assert bench.client.node.count_subscribers(f'{arm.controller}/speed_scaling_input') == 1


@statement('A13')
def test_qualities_of_the_action(bench: Bench, arm: TrajectoryController) -> None:
    """Status is reliable and latched with depth 1, feedback reliable and volatile."""
    node = bench.client.node
    base = f'{arm.controller}/follow_joint_trajectory/_action'
    arm.go([0.1, 0.1])
    bench.client.latched(f'{base}/status', GoalStatusArray)
    (status,) = node.get_publishers_info_by_topic(f'{base}/status')
    (feedback,) = node.get_publishers_info_by_topic(f'{base}/feedback')
    assert status.qos_profile.reliability == feedback.qos_profile.reliability == RELIABLE
    assert status.qos_profile.durability == TRANSIENT_LOCAL
    assert feedback.qos_profile.durability == VOLATILE


@statement('A14')
def test_activity_is_latched(bench: Bench) -> None:
    """The manager's activity is reliable and transient-local."""
    bench.manager.states()
    (info,) = bench.client.node.get_publishers_info_by_topic(
        bench.name('controller_manager/activity')
    )
    assert info.qos_profile.reliability == RELIABLE
    assert info.qos_profile.durability == TRANSIENT_LOCAL


def state_steps(bench: Bench, controller: str) -> list[int]:
    """Return the times between states [ns]; none is missed where this process is slow."""
    topic = bench.name(f'{controller}/controller_state')
    states = bench.client.collect(topic, JointTrajectoryControllerState, 100)
    stamps = [nanoseconds(state.header.stamp) for state in states.wait(40)]
    states.close()
    return [b - a for a, b in itertools.pairwise(stamps)]


@pytest.mark.alone
@statement('A15')
def test_controller_state_comes_once_per_update(bench: Bench, arm: TrajectoryController) -> None:
    """With a manager at 100 Hz the stamps of controller_state lie 10 ms apart."""
    steps = state_steps(bench, 'arm')
    assert min(steps) > 0
    assert statistics.median(steps) == pytest.approx(PERIOD * 1e9, rel=0.05)


@statement('A15', 'B18')
def test_a_controller_may_be_slower_than_the_manager(bench: Bench) -> None:
    """update_rate 50 gives 50 states a second."""
    bench.use('slow')
    steps = state_steps(bench, 'slow')
    assert statistics.median(steps) == pytest.approx(2 * PERIOD * 1e9, rel=0.05)


@statement('A15', 'J1', 'B12')
def test_feedback_comes_at_the_monitor_rate(arm: TrajectoryController) -> None:
    """Feedback comes at 20 Hz by default."""
    goal = arm.goal(arm.to([0.3, 0.3], 2.0))
    assert goal.result().status == SUCCEEDED
    stamps = [seconds(message.header.stamp) for message in goal.feedback]
    steps = [b - a for a, b in itertools.pairwise(stamps)]
    assert len(steps) >= 8
    assert statistics.median(steps) == pytest.approx(0.05, rel=0.25)


@statement('A17')
def test_stamps_are_of_one_clock(bench: Bench, arm: TrajectoryController) -> None:
    """joint_states, controller_state and feedback carry times of the same clock."""
    goal = arm.goal(arm.trajectory(point(0.3, [0.1, 0.1])))
    feedback = seconds(goal.wait_for_feedback()[0].header.stamp)
    joints = bench.client.collect(bench.name('joint_states'), JointState)
    state = seconds(arm.newest().header.stamp)
    stamp = seconds(joints.wait(1)[0].header.stamp)
    joints.close()
    goal.result()
    assert abs(feedback - state) < 3.0
    assert abs(stamp - state) < 3.0
