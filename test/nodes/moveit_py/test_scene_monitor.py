# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The scene of a script, and what others see of it."""

import time

from ball_message import ball_message
from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, PlanningScene
from moveit_msgs.srv import GetPlanningScene
import pytest
from rclpy.time import Time

from armsim_ros.clients.ros_client import RosClient

pytestmark = pytest.mark.statement('A3', 'B9')

FRAME = 'panda_link0'


@pytest.fixture
def client():
    """Run a client's node."""
    with RosClient('other') as made:
        yield made


def within(seconds, condition):
    """Return whether a condition holds within a time [s]."""
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.01)
    return True


def names(monitor):
    """Return the names of the objects in the world."""
    with monitor.read_only() as scene:
        return [each.id for each in scene.planning_scene_message.world.collision_objects]


def test_an_edit_is_published_when_the_block_ends(monitor, client):
    """As a difference, once; also out of a block that only reads."""
    seen = client.poll(PlanningScene, '/monitored_planning_scene', 100)
    found = []
    assert within(5.0, lambda: found.extend(seen.take()) or found)
    for block in (monitor.read_write, monitor.read_only):
        with block() as scene:
            scene.apply_collision_object(ball_message(FRAME, 'ball', (1.0, 0.0, 1.0)))
            scene.apply_collision_object(ball_message(FRAME, 'other', (1.0, 1.0, 1.0)))
            assert names(monitor) == ['ball', 'other']  # a block in a block is the same scene
        found.clear()

        def edits():
            found.extend(seen.take())
            return [each for each in found if each.world.collision_objects]

        assert within(5.0, edits)
        message = edits()[0]
        assert message.is_diff
        assert [each.id for each in message.world.collision_objects] == ['ball', 'other']
        with monitor.read_write() as scene:
            scene.remove_all_collision_objects()
        found.clear()
        assert within(5.0, edits)
    seen.close()


def test_an_exception_in_a_block_ends_it(monitor):
    """What was changed until then holds, and the next block is not locked out."""
    def fail():
        with monitor.read_write() as scene:
            scene.apply_collision_object(ball_message(FRAME, 'ball', (1.0, 0.0, 1.0)))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert names(monitor) == ['ball']


def test_the_state_in_a_block_does_not_change(monitor, panda):
    """A state that a script tries out does not last: the robot is where it is."""
    before = panda.positions['panda_joint1']
    with monitor.read_only() as scene:
        scene.current_state.joint_positions = {'panda_joint1': 1.0}
        assert not within(0.1, lambda: scene.current_state.joint_positions['panda_joint1'] != 1.0)
        scene.current_state.joint_positions = {'panda_joint1': before}

    def present():
        with monitor.read_only() as scene:
            return scene.current_state.joint_positions['panda_joint1']

    assert within(2.0, lambda: present() == before)


def test_objects_by_message(monitor):
    """Operations return whether they were done."""
    assert monitor.name == 'monitor'
    assert monitor.process_collision_object(ball_message(FRAME, 'ball', (1.0, 0.0, 1.0)))
    gone = CollisionObject(id='table', operation=CollisionObject.REMOVE)
    assert not monitor.process_collision_object(collision_object_msg=gone)
    held = AttachedCollisionObject(
        link_name='panda_hand', object=CollisionObject(id='ball', operation=CollisionObject.ADD))
    assert monitor.process_attached_collision_object(held)
    assert names(monitor) == []
    held.object.operation = CollisionObject.REMOVE
    assert monitor.process_attached_collision_object(held)
    assert names(monitor) == ['ball']
    scene = PlanningScene(is_diff=True)
    scene.robot_state.is_diff = True
    scene.world.collision_objects = [ball_message(FRAME, 'other', (1.0, 1.0, 1.0))]
    assert monitor.new_planning_scene_message(scene)
    assert names(monitor) == ['ball', 'other']
    monitor.clear_octomap()
    monitor.update_frame_transforms()


def test_others_edit_the_scene_while_it_is_followed(monitor, moveit, client):
    """The topics and the service of the node."""
    publisher = client.node.create_publisher(CollisionObject, '/collision_object', 10)
    message = ball_message(FRAME, 'ball', (1.0, 0.0, 1.0))
    assert within(5.0, lambda: publisher.get_subscription_count())
    publisher.publish(message)
    assert within(5.0, lambda: names(monitor) == ['ball'])
    request = GetPlanningScene.Request()
    client.prepare(GetPlanningScene, '/get_planning_scene')
    assert within(5.0, lambda: client.serves(GetPlanningScene, '/get_planning_scene'))
    answer = client.call(GetPlanningScene, '/get_planning_scene', request).result(5.0)
    assert [each.id for each in answer.scene.world.collision_objects] == ['ball']
    # Of its own service: all that there is, again.
    assert monitor.request_planning_scene_state('/get_planning_scene')
    assert names(monitor) == ['ball']


@pytest.mark.parametrize(('what', 'topics'), [
    ('scene', ['/planning_scene']), ('state', ['/attached_collision_object', '/joint_states'])])
def test_a_monitor_that_is_stopped_follows_its_own_topics_no_longer(
        monitor, moveit, what, topics):
    """
    Others stay followed, and it can be started again.

    planning_scene_monitor.cpp: stopSceneMonitor, stopStateMonitor.
    """
    def followed():
        return sorted(each.topic_name for each in moveit._cpp.node.subscriptions)

    before = followed()
    assert {'/planning_scene', '/planning_scene_world', '/collision_object',
            '/attached_collision_object', '/joint_states'} <= set(before)
    getattr(monitor, f'stop_{what}_monitor')()
    assert followed() == [topic for topic in before if topic not in topics]
    getattr(monitor, f'start_{what}_monitor')()
    assert followed() == before


def test_waiting_for_a_state(monitor, moveit):
    """A state of now comes; one of the future does not, nor any while they are not followed."""
    now = moveit._cpp.node.get_clock().now()
    assert monitor.wait_for_current_robot_state(now, 2.0)
    assert not monitor.wait_for_current_robot_state(
        Time(nanoseconds=now.nanoseconds + 10**12, clock_type=now.clock_type), 0.05)
    monitor.stop_state_monitor()
    later = moveit._cpp.node.get_clock().now()
    assert not monitor.wait_for_current_robot_state(later, 0.1)
    monitor.start_state_monitor()
    assert monitor.wait_for_current_robot_state(later, 5.0)
