# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which names exist, of which type, with which quality of service."""

from __future__ import annotations

from collections.abc import Iterator
import math
import threading
from typing import Any

from geometry_msgs.msg import TransformStamped
from move_group_bench import name_of, xyz
from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import DisplayTrajectory, PlanningScene
import pytest
from rclpy.action import ActionClient, get_action_names_and_types
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage
from wire import at, box, quiet_diff, sphere, thing

RELIABLE, BEST_EFFORT = QoSReliabilityPolicy.RELIABLE, QoSReliabilityPolicy.BEST_EFFORT
VOLATILE = QoSDurabilityPolicy.VOLATILE
LATCHED = QoSProfile(depth=10, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)


def services(arm: Any) -> dict[str, list[str]]:
    """Return service -> types."""
    return dict(arm.client.node.get_service_names_and_types())


@pytest.mark.statement('IF-0')
def test_node_name(arm: Any) -> None:
    """The node is called move_group."""
    assert 'move_group' in arm.client.node.get_node_names()


@pytest.mark.statement('IF-0.1')
def test_ready_line_comes_once_after_all_servers(arm: Any, log: Any) -> None:
    """'You can start planning now!' is said once, when every server exists."""
    assert log.text.count('You can start planning now!') == 1
    assert arm.move_action.server_is_ready()


@pytest.mark.statement('IF-1', 'IF-2')
@pytest.mark.parametrize(('name', 'kind'), [
    ('move_action', 'moveit_msgs/action/MoveGroup'),
    ('execute_trajectory', 'moveit_msgs/action/ExecuteTrajectory'),
])
def test_actions(arm: Any, name: str, kind: str) -> None:
    """The actions that all clients use exist under their names."""
    found = dict(get_action_names_and_types(arm.client.node))
    assert found[arm.name(name)] == [kind]


@pytest.mark.statement('SEED-12')
def test_the_old_action_name_works(arm: Any) -> None:
    """A client of ROS 1 that calls the action move_group is served too."""
    client = ActionClient(arm.client.node, MoveGroup, arm.name('move_group'))
    assert client.wait_for_server(10.0)
    goal = MoveGroup.Goal(request=arm.request(arm.near()))
    goal.planning_options.plan_only = True
    future = arm.client.in_executor(lambda: client.send_goal_async(goal))
    handle = arm.client.result(future)
    assert arm.ended(handle).code == 'SUCCESS'
    arm.client.in_executor(client.destroy)


@pytest.mark.parametrize(('name', 'kind'), [
    pytest.param(name, f'moveit_msgs/srv/{kind}' if '/' not in kind else kind,
                 marks=pytest.mark.statement(statement), id=name)
    for statement, name, kind in (
        ('IF-10', 'plan_kinematic_path', 'GetMotionPlan'),
        ('IF-11', 'compute_ik', 'GetPositionIK'),
        ('IF-12', 'compute_fk', 'GetPositionFK'),
        ('IF-13', 'check_state_validity', 'GetStateValidity'),
        ('IF-14', 'compute_cartesian_path', 'GetCartesianPath'),
        ('IF-15', 'get_planning_scene', 'GetPlanningScene'),
        ('IF-16', 'apply_planning_scene', 'ApplyPlanningScene'),
        ('IF-17', 'query_planner_interface', 'QueryPlannerInterfaces'),
        ('IF-18', 'get_planner_params', 'GetPlannerParams'),
        ('IF-19', 'set_planner_params', 'SetPlannerParams'),
        ('IF-20', 'clear_octomap', 'std_srvs/srv/Empty'),
        ('IF-21', 'get_urdf', 'GetGroupUrdf'),
        ('IF-22', 'save_geometry_to_file', 'SaveGeometryToFile'),
        ('IF-23', 'load_geometry_from_file', 'LoadGeometryFromFile'),
        ('IF-26', 'move_group/list_parameters', 'rcl_interfaces/srv/ListParameters'),
        ('IF-26', 'move_group/get_parameters', 'rcl_interfaces/srv/GetParameters'),
        ('IF-26', 'move_group/set_parameters', 'rcl_interfaces/srv/SetParameters'),
        ('IF-26', 'move_group/describe_parameters', 'rcl_interfaces/srv/DescribeParameters'),
    )
])
def test_services(arm: Any, name: str, kind: str) -> None:
    """The service exists under its name and type."""
    assert services(arm)[arm.name(name)] == [kind]


@pytest.mark.parametrize(('name', 'kind', 'reliability'), [
    pytest.param(name, kind, reliability, marks=pytest.mark.statement(*statements), id=name)
    for statements, name, kind, reliability in (
        (('IF-31',), 'attached_collision_object', 'moveit_msgs/msg/AttachedCollisionObject',
         RELIABLE),
        (('IF-32',), 'collision_object', 'moveit_msgs/msg/CollisionObject', RELIABLE),
        (('IF-33',), 'planning_scene', 'moveit_msgs/msg/PlanningScene', RELIABLE),
        (('IF-34',), 'planning_scene_world', 'moveit_msgs/msg/PlanningSceneWorld', RELIABLE),
        (('IF-35',), 'trajectory_execution_event', 'std_msgs/msg/String', RELIABLE),
    )
])
def test_subscriptions(arm: Any, name: str, kind: str, reliability: Any) -> None:
    """The server listens to the topic, so that every client's publisher matches."""
    found = [
        one for one in arm.client.node.get_subscriptions_info_by_topic(arm.name(name))
        if one.node_name == 'move_group'
    ]
    assert [one.topic_type for one in found] == [kind]
    assert found[0].qos_profile.reliability == reliability
    assert found[0].qos_profile.durability == VOLATILE


@pytest.mark.statement('IF-30', 'IF-30a', 'SEED-8')
def test_joint_states_are_heard_on_both_topics(arm: Any) -> None:
    """Joint states are read from the namespace's topic and /joint_states, best effort."""
    node = arm.client.node
    for topic in ('/joint_states', arm.joint_states.topic):
        found = [
            one for one in node.get_subscriptions_info_by_topic(topic)
            if one.node_name == 'move_group'
        ]
        assert found, topic
        assert found[0].qos_profile.reliability == BEST_EFFORT


@pytest.fixture
def frames(arm: Any) -> Iterator[Any]:
    """Give a function that publishes frames on /tf_static or /tf."""
    node = arm.client.node
    profiles = {'/tf_static': LATCHED, '/tf': 10}
    publishers = {
        topic: node.create_publisher(TFMessage, topic, profile)
        for topic, profile in profiles.items()
    }

    def publish(topic: str, child: str, parent: str, z: float) -> None:
        frame = TransformStamped(child_frame_id=child)
        frame.header.frame_id = parent
        frame.transform.translation.z, frame.transform.rotation.w = z, 1.0
        message = TFMessage(transforms=[frame])
        pause = threading.Event()
        for _ in range(200):
            publishers[topic].publish(message)
            answer = arm.fk([arm.tip], frame=child)
            if name_of(answer.error_code) == 'SUCCESS':
                return
            pause.wait(0.02)
        raise AssertionError(f'{child} is not known: {answer.error_code}')

    yield publish
    for publisher in publishers.values():
        arm.client.in_executor(lambda one=publisher: node.destroy_publisher(one))


@pytest.mark.statement('IF-36', 'CON-5')
@pytest.mark.parametrize('topic', ['/tf_static', '/tf'])
def test_frames_of_others_are_known(arm: Any, frames: Any, topic: str) -> None:
    """A frame mounted on the tip goes where the tip goes; what was put there stays."""
    lens = f"lens_{topic.strip('/')}"
    frames(topic, lens, arm.tip, 0.25)
    assert arm.move(next(iter(arm.states))).code == 'SUCCESS'
    for k in range(2):
        (pose,) = arm.fk([arm.tip], frame=lens).pose_stamped
        assert xyz(pose.pose.position) == pytest.approx((0.0, 0.0, -0.25), abs=1e-6)
        assert arm.add(thing(f'seen {k}', lens, [sphere(0.01)], pose=at()))
        seen = xyz(arm.objects()[f'seen {k}'].pose.position)
        assert math.dist(seen, xyz(arm.pose().pose.position)) == pytest.approx(0.25, abs=2e-3)
        assert arm.move(arm.near(0.3)).code == 'SUCCESS'
        assert xyz(arm.objects()[f'seen {k}'].pose.position) == pytest.approx(seen)
    one, two = (arm.objects()[f'seen {k}'].pose.position for k in range(2))
    assert math.dist(xyz(one), xyz(two)) > 0.01


@pytest.mark.statement('IF-40', 'IF-41')
@pytest.mark.parametrize('name', ['monitored_planning_scene', 'display_planned_path'])
def test_publishers_are_reliable(arm: Any, name: str) -> None:
    """RViz, which subscribes reliably, gets the scene and the planned path."""
    found = arm.client.node.get_publishers_info_by_topic(arm.name(name))
    assert [one.qos_profile.reliability for one in found] == [RELIABLE]


@pytest.mark.statement('IF-44', 'RVZ-1')
@pytest.mark.parametrize('name', ['robot_description', 'robot_description_semantic'])
def test_descriptions_are_latched(arm: Any, name: str) -> None:
    """A late subscriber gets URDF and SRDF."""
    assert '<robot' in arm.client.latched(f'/{name}', String).data


@pytest.mark.statement('IF-40a', 'RVZ-3')
def test_the_monitored_scene_is_diffs_after_the_first(arm: Any) -> None:
    """
    A change comes as a diff; a state-only diff carries no attached objects.

    A subscription that is discovered after a motion gets the diffs of the next.
    """
    heard = arm.client.collect(
        arm.name('monitored_planning_scene'), PlanningScene, QoSProfile(depth=100)
    )
    changes: list[PlanningScene] = []
    for _ in range(10):
        assert arm.move(arm.near(0.3)).code == 'SUCCESS'
        changes = [one for one in heard.messages if one.robot_state.joint_state.name
                   and one.is_diff]
        if changes:
            break
    message = changes[0]
    assert all(one.is_diff for one in heard.messages[1:])
    assert message.robot_state.is_diff
    assert not message.robot_state.attached_collision_objects
    heard.close()


@pytest.mark.statement('IF-40b', 'UT-2')
def test_a_change_of_the_world_is_published_within_half_a_second(arm: Any) -> None:
    """Objects that come and go are on the monitored scene within 0.5 s."""
    heard = arm.client.collect(
        arm.name('monitored_planning_scene'), PlanningScene, QoSProfile(depth=100)
    )
    heard.wait_after(
        lambda: arm.add(thing('early', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0))))
    arm.add(thing('crate', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(3.0)))
    heard.wait_for(lambda one: any(o.id == 'crate' for o in one.world.collision_objects), 0.5)
    heard.close()


@pytest.mark.statement('IF-41a', 'ADP-9', 'RVZ-11', 'R25')
def test_every_plan_is_displayed(arm: Any) -> None:
    """A plan is published with the robot's name, one trajectory and the full start state."""
    heard = arm.client.collect(arm.name('display_planned_path'), DisplayTrajectory)
    plans = []
    shown = heard.wait_after(lambda: plans.append(arm.planned(arm.near())))
    assert shown.model_id == arm.robot_name
    assert len(shown.trajectory) == 1
    assert shown.trajectory[0].joint_trajectory in plans
    assert set(shown.trajectory_start.joint_state.name) >= set(arm.joints)
    heard.close()


@pytest.mark.statement('M8')
def test_some_changes_bring_the_whole_monitored_scene(arm: Any) -> None:
    """
    A full scene, another name and padding go out in full, all else as a difference with a stamp.

    moveit_ros planning_scene_monitor.cpp, newPlanningSceneMessage and scenePublishingThread.
    """
    heard = arm.client.collect(
        arm.name('monitored_planning_scene'), PlanningScene, QoSProfile(depth=100)
    )
    heard.wait_after(
        lambda: arm.add(thing('early', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0))))
    named = quiet_diff()
    for change in ('name', 'link_padding', 'is_diff'):
        if change == 'is_diff':
            named = arm.scene()
        else:
            scene = arm.scene()
            setattr(named, change, f'{scene.name}+' if change == 'name' else scene.link_padding)
        heard.clear()
        assert arm.apply(named)
        whole = heard.wait_for(lambda one: not one.is_diff)
        assert [o.id for o in whole.world.collision_objects] == ['early']
        assert whole.robot_state.joint_state.header.stamp.sec > 0
    heard.clear()
    assert arm.add(thing('late', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(3.0)))
    late = heard.wait_for(lambda one: any(o.id == 'late' for o in one.world.collision_objects))
    assert late.is_diff
    assert late.robot_state.joint_state.header.stamp.sec > 0
    heard.close()


@pytest.mark.statement('IF-33', 'IF-34', 'M7')
def test_scene_topics_change_the_scene(arm: Any) -> None:
    """
    planning_scene adds objects without a service, planning_scene_world replaces all of them.

    moveit_ros planning_scene_monitor.cpp, newPlanningSceneWorldCallback.
    """
    node = arm.client.node
    scene = quiet_diff()
    scene.world.collision_objects = [thing('one', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2))]
    other = quiet_diff().world
    other.collision_objects = [thing('two', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(3))]
    for name, message, wanted in (
        ('planning_scene', scene, 'one'), ('planning_scene_world', other, 'two'),
    ):
        publish_until(
            arm, node, name, message, lambda wanted=wanted: list(arm.objects()) == [wanted])


def publish_until(arm: Any, node: Any, name: str, message: Any, done: Any) -> None:
    """Publish a message once its subscriber is there, and wait for its effect."""
    publisher = node.create_publisher(type(message), arm.name(name), 10)
    for _ in range(500):
        if publisher.get_subscription_count():
            break
        arm.positions()
    publisher.publish(message)
    for _ in range(100):
        if done():
            break
        arm.positions()
    assert done()
    arm.client.in_executor(lambda: node.destroy_publisher(publisher))
