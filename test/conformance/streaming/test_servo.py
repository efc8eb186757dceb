# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""servo_node beside a running arm, seen through ROS alone."""

from __future__ import annotations

import time

from control_msgs.msg import JointJog
from geometry_msgs.msg import Pose
from moveit_msgs.msg import CollisionObject
from moveit_msgs.srv import ApplyPlanningScene
import numpy as np
import pytest
from shape_msgs.msg import SolidPrimitive
from std_srvs.srv import SetBool, Trigger
from streaming_bench import ARM, Streamed
from trajectory_msgs.msg import JointTrajectory

from armsim_ros.clients.controller_manager import ParameterClient

pytestmark = pytest.mark.usefixtures('statuses')
statement = pytest.mark.statement

JOG, TWIST, POSE = 0, 1, 2


@statement('SRV-2', 'SRV-3')
def test_names(arm: Streamed) -> None:
    """Topics and services have upstream's names and types."""
    topics = dict(arm.client.node.get_topic_names_and_types())
    services = dict(arm.client.node.get_service_names_and_types())
    assert topics['/servo_node/delta_twist_cmds'] == ['geometry_msgs/msg/TwistStamped']
    assert topics['/servo_node/delta_joint_cmds'] == ['control_msgs/msg/JointJog']
    assert topics['/servo_node/pose_target_cmds'] == ['geometry_msgs/msg/PoseStamped']
    assert topics['/servo_node/status'] == ['moveit_msgs/msg/ServoStatus']
    assert services['/servo_node/switch_command_type'] == ['moveit_msgs/srv/ServoCommandType']
    assert services['/servo_node/pause_servo'] == ['std_srvs/srv/SetBool']


@statement('S5')
def test_parameters_are_resolved(arm: Streamed) -> None:
    """
    Group and topics that the files leave to the robot are read back as they are used.

    Upstream: servo_parameters.yaml: none of them is ever empty.
    """
    parameters = ParameterClient(arm.client, '/servo_node')
    assert parameters.get('moveit_servo.move_group_name') == 'manipulator'
    topic = parameters.get('moveit_servo.command_out_topic')
    assert topic == '/sunday/arm_joint_controller/joint_trajectory'
    assert parameters.get('moveit_servo.joint_topic') == '/sunday/joint_states'
    wrong = parameters.set('moveit_servo.active_subgroup', 'nowhere')
    assert "'nowhere' is not a planning group" in wrong


@statement('S9')
def test_commands_of_zero_are_answered(arm: Streamed) -> None:
    """
    A fresh twist of zero sends a message each period.

    Upstream: servo_node.cpp, servoLoop.
    """
    arm.choose(TWIST)
    sent = arm.client.collect('/sunday/arm_joint_controller/joint_trajectory', JointTrajectory)
    arm.stream_until(arm.twist, arm.make_twist(), lambda: len(sent.messages) > 20, 'messages come')
    arm.rest()


@statement('SRV-3')
def test_unknown_type(arm: Streamed) -> None:
    """A type that does not exist is refused."""
    assert arm.choose(TWIST)
    assert not arm.choose(7)


@pytest.mark.alone  # a command that comes late is followed in less time, as upstream
@pytest.mark.usefixtures('references')
@statement('SRV-7', 'SRV-12', 'NUM-3')
def test_twist_and_silence(arm: Streamed) -> None:
    """A twist moves the arm; silence brings it to rest, without a step of the reference."""
    arm.choose(TWIST)
    arm.forget()
    arm.stream_until(arm.twist, arm.make_twist((0, 0, -0.2)),
                     arm.has_moved(arm.positions, 0.15), 'the arm moves')
    arm.rest(0.5)
    references, stamps = arm.moved(arm.reference), np.array(arm.reference.stamps)
    assert np.abs(references[-1] - references[0]).max() > 0.1
    # Two states may be published a millisecond apart, where the reference is that of a period.
    times = np.maximum(np.diff(stamps)[: len(references) - 1, None], 0.01)
    assert (np.abs(np.diff(references, axis=0)) / times).max() < 1.5
    assert (0, 'No warnings') in arm.said()


@statement('SRV-8')
def test_jog(arm: Streamed) -> None:
    """A jog moves its joint and no other."""
    arm.choose(JOG)
    before = arm.positions
    arm.stream_until(arm.jog, JointJog(joint_names=['joint_6'], velocities=[1.0]),
                     arm.has_moved(before, 0.2), 'the joint moves')
    arm.rest()
    moved = arm.positions - before
    assert moved[5] > 0.2
    assert np.abs(moved[:5]).max() < 2e-3


@statement('SRV-9')
def test_pose(arm: Streamed) -> None:
    """A pose is reached and held, and the status says so."""
    from geometry_msgs.msg import PoseStamped

    arm.choose(POSE)
    message = PoseStamped()
    message.header.frame_id = 'link_6'
    message.pose.orientation.w = 1.0
    arm.stream_until(
        arm.pose, message, arm.has_said('No warnings: pose reached', 0), 'the pose is reached')


@statement('SRV-11')
@pytest.mark.parametrize(
    ('field', 'words'),
    [('nan', 'twist.linear'), ('no frame', 'frame_id is empty'), ('frame', "frame 'nowhere'")],
)
def test_garbage(arm: Streamed, field: str, words: str) -> None:
    """Garbage moves nothing; the message names the field; the next good command works."""
    arm.choose(TWIST)
    before = arm.positions
    garbage = {
        'nan': arm.make_twist((float('nan'), 0, 0)),
        'no frame': arm.make_twist((0, 0, 0.1), frame=''),
        'frame': arm.make_twist((0, 0, 0.1), frame='nowhere'),
    }[field]
    arm.forget()
    arm.stream_until(arm.twist, garbage, arm.has_said(words, -1), f'the status has: {words}')
    arm.rest(0.3)
    np.testing.assert_allclose(arm.positions, before, atol=1e-3)
    arm.stream_until(
        arm.twist, arm.make_twist((0, 0, -0.2)), arm.has_moved(before, 0.02), 'the arm moves')
    arm.rest()


@statement('SRV-12')
def test_other_clock(arm: Streamed) -> None:
    """A stamp of another clock is refused with the offset."""
    arm.choose(TWIST)
    message = arm.make_twist((0, 0, -0.2))
    message.header.stamp.sec = int(time.time()) - 100
    arm.forget()
    told = arm.has_said('clock', -1)
    arm.until(lambda: arm.twist.publish(message) or told(), 'the status tells of the clock')


@statement('SRV-12')
def test_no_stamp(arm: Streamed) -> None:
    """A command without a stamp counts from its arrival."""
    arm.choose(TWIST)
    before = arm.positions
    moved, deadline = arm.has_moved(before, 0.02), time.monotonic() + 30.0
    while not moved():
        assert time.monotonic() < deadline
        arm.twist.publish(arm.make_twist((0, 0, -0.2)))
        time.sleep(0.01)
    arm.rest()


@statement('SRV-6')
def test_type_that_is_not_chosen(arm: Streamed) -> None:
    """A command of another type moves nothing, and the message says what to call."""
    arm.choose(JOG)
    before = arm.positions
    arm.stream_until(arm.twist, arm.make_twist((0, 0, -0.2)),
                     arm.has_said('switch_command_type', -1), 'the status tells what to call')
    np.testing.assert_allclose(arm.positions, before, atol=1e-3)


@statement('SRV-3', 'SRV-22')
def test_pause(arm: Streamed) -> None:
    """A pause stops the arm, the status goes on, and commands wait for its end."""
    arm.choose(TWIST)
    pause = SetBool.Request(data=True)
    arm.stream(arm.twist, arm.make_twist((0, 0, -0.2)), 0.3)
    assert arm.client.call('/servo_node/pause_servo', SetBool, pause).success
    again = arm.client.call('/servo_node/pause_servo', SetBool, pause)
    assert again.success
    assert again.message == 'Requested pause state is already active.'
    arm.rest()
    before = arm.positions
    arm.forget()
    arm.stream_until(
        arm.twist, arm.make_twist((0, 0, -0.2)), lambda: len(arm.said()) > 30, 'the status comes')
    np.testing.assert_allclose(arm.positions, before, atol=1e-3)
    assert all('paused' in text for _, text in arm.said()[-3:])
    assert arm.client.call('/servo_node/start_servo', Trigger).success


@statement('SRV-21')
def test_other_controller(arm: Streamed) -> None:
    """With another controller active nothing moves, and the status names the inactive one."""
    arm.choose(TWIST)
    arm.use('position_stream')
    before = arm.positions
    arm.forget()
    arm.stream_until(arm.twist, arm.make_twist((0, 0, -0.2)),
                     lambda: any(ARM in text for _, text in arm.said()),
                     'the status names the inactive controller')
    np.testing.assert_allclose(arm.positions, before, atol=1e-3)


@statement('NUM-1')
def test_status_rate(arm: Streamed) -> None:
    """The status comes every period; how exactly, benchmarks/streaming/streaming.py measures."""
    arm.forget()
    arm.until(lambda: len(arm.said()) > 100, 'a hundred and one have come')
    assert arm.status.stamps[100] - arm.status.stamps[0] > 0.7


@statement('SRV-16')
def test_an_object_in_the_way(arm: Streamed) -> None:
    """An object that comes into the scene stops the arm at once, and its name is told."""
    arm.choose(TWIST)
    scene = ApplyPlanningScene.Request()
    scene.scene.is_diff = scene.scene.robot_state.is_diff = True
    wall = CollisionObject(id='wall', operation=CollisionObject.ADD)
    wall.header.frame_id = 'world'
    wall.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.6, 0.6, 0.02])]
    wall.primitive_poses = [Pose()]
    wall.pose.position.x, wall.pose.position.y, wall.pose.position.z = 0.16, 0.25, 1.2
    wall.pose.orientation.w = 1.0
    scene.scene.world.collision_objects = [wall]
    assert arm.client.call('/apply_planning_scene', ApplyPlanningScene, scene).success
    try:
        arm.forget()
        arm.stream_until(arm.twist, arm.make_twist((0, 0, -0.3)), arm.has_said("'wall'", 4, 5),
                         'the status names the object')
        arm.rest()
        assert arm.said()[-1][0] in (0, 4, 5)
    finally:
        wall.operation = CollisionObject.REMOVE
        arm.client.call('/apply_planning_scene', ApplyPlanningScene, scene)
