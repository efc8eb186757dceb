# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Verbs that send and receive messages, beyond what upstream.yaml has."""

import re
import signal

import pytest
import yaml

POSE = 'geometry_msgs/msg/PoseStamped'
ARM = '/sunday/arm_joint_controller/follow_joint_trajectory'
BALL = 'id: ball, header: {frame_id: map}, primitives: [{type: 2, dimensions: [0.1]}]'
TRAJECTORY = 'control_msgs/action/FollowJointTrajectory'


def goal(seconds, position=0.1):
    """Return a goal that moves the first joint."""
    names = [f'joint_{i}' for i in range(1, 7)]
    positions = [position, 0, 0, 0, 0, 0]
    return str({'trajectory': {'joint_names': names, 'points': [
        {'positions': positions, 'time_from_start': {'sec': seconds}}]}})


def test_a_latched_message_is_echoed_in_full(ros2):
    """A field without truncation; a missing one is status 1 (ros2topic/verb/echo.py)."""
    words = ('topic', 'echo', '--once', '/robot_description')
    assert ros2(*words, '--field', 'data').out.split()[-2:] == ['</robot>', '---']
    done = ros2(*words, '--field', 'dat')
    assert done.status == 1
    assert done.err.startswith("Invalid field 'dat': 'String' object has no attribute 'dat'")


def test_a_stream_is_echoed_as_yaml(ros2):
    """Joint states can be read again; an element of a field."""
    words = ('topic', 'echo', '/sunday/joint_states', '--no-lost-messages', '--once')
    message = yaml.safe_load(ros2(*words).out.removesuffix('---\n'))
    assert list(message) == ['header', 'name', 'position', 'velocity', 'effort']
    assert ros2(*words, '--field', 'name[0]').out == 'joint_1\n---\n'


def test_what_cannot_be_echoed_is_explained(ros2):
    """The warning and the status of ros2topic/api."""
    done = ros2('topic', 'echo', '/joint_state')
    assert done.out == (
        'WARNING: topic [/joint_state] does not appear to be published yet\n')
    assert done.err == ("Could not determine the type for the passed topic: '/joint_state'; "
                        "did you mean '/joint_states'?\n")
    assert done.status == 1
    done = ros2('topic', 'echo', '/tf', 'tf2_msgs/msg/TFMessag')
    assert done.err == ("The passed message type is invalid: 'tf2_msgs/msg/TFMessag'; "
                        "did you mean 'TFMessage'?\n")


def test_a_message_reaches_a_subscriber(ros2, start):
    """Topic pub --once waits for the subscription of a topic echo, and stamps the header."""
    echo = start('topic', 'echo', '--once', '/stamped', POSE)
    done = ros2('topic', 'pub', '--once', '/stamped', POSE,
                '{header: {stamp: now, frame_id: base}, pose: {position: {x: 1.5}}}')
    assert done.status == 0
    out, _ = echo.communicate(timeout=30)
    message = yaml.safe_load(out.removesuffix('---\n'))
    assert message['header']['stamp']['sec'] > 1_600_000_000
    assert message['pose']['position']['x'] == 1.5


def test_simulated_time_is_known_before_the_first_stamp(ros2):
    """With -s the node waits for /clock (ros2cli/node/direct.py, DirectNode.__init__)."""
    done = ros2('topic', 'pub', '-s', '-w', '0', '--once', '/chat', POSE, '{header: auto}')
    assert re.search(r'Time\(sec=\d+, nanosec=\d+\)', done.out)[0] != 'Time(sec=0, nanosec=0)'


def test_a_rate_has_no_drift(start):
    """
    Over a second the rate is within 1 % of -r; the most punctual of 20 messages counts.

    The timer starts after the first message, as in ros2topic/verb/pub.py, publisher.
    """
    echo = start('topic', 'echo', '--csv', '--no-lost-messages', '/paced', POSE)
    start('topic', 'pub', '-r', '20', '-w', '1', '/paced', POSE, '{header: auto}')
    stamps = []
    while len(stamps) < 42:
        seconds, nanoseconds, _ = echo.stdout.readline().split(',', 2)
        stamps.append(int(seconds) + int(nanoseconds) * 1e-9)
    late = [stamp - number / 20 for number, stamp in enumerate(stamps[1:])]
    assert min(late[20:40]) - min(late[:20]) == pytest.approx(0, abs=0.01)


def test_a_call_of_another_type_is_refused(ros2):
    """The client would wait for ever."""
    done = ros2('service', 'call', '/compute_ik', 'moveit_msgs/srv/GetPositionFK')
    assert (done.status, done.out) == (1, 'waiting for service to become available...\n')
    assert "'/compute_ik' has the type 'moveit_msgs/srv/GetPositionIK'" in done.err


def test_a_rejected_goal_has_a_reason(ros2):
    """Standard output is upstream's; the controller's reason is on standard error."""
    done = ros2('action', 'send_goal', ARM, TRAJECTORY, '{trajectory: {joint_names: [nope]}}')
    assert done.out.endswith('Goal was rejected.\n')
    assert done.err.startswith('reason: ')
    assert '(nope)' in done.err


@pytest.mark.parametrize('words', [
    ('topic', 'pub', '--once', '/collision_object', 'moveit_msgs/msg/CollisionObject',
     f'{{{BALL}}}'),
    ('service', 'call', '/apply_planning_scene', 'moveit_msgs/srv/ApplyPlanningScene',
     '{scene: {is_diff: true, robot_state: {is_diff: true}, '
     f'world: {{collision_objects: [{{{BALL}}}]}}}}}}'),
])
def test_a_rejected_change_of_the_scene_has_a_reason(ros2, words):
    """Standard output is upstream's; move_group's reason is on standard error."""
    done = ros2(*words)
    assert done.status == 0
    assert done.err.startswith('rejected: ')
    assert "'map'" in done.err


def test_a_topic_that_nothing_publishes_is_reported(start):
    """Echo goes on to wait, and proposes a topic of that name in a namespace."""
    echo = start('topic', 'echo', '/joint_states', 'sensor_msgs/msg/JointState')
    assert echo.stderr.readline() == (
        "no message: nothing publishes '/joint_states'; did you mean '/sunday/joint_states'?\n")
    echo.send_signal(signal.SIGINT)
    echo.communicate(timeout=30)


def test_ctrl_c_cancels_a_goal(start):
    """The goal is canceled and its result printed before the process ends."""
    process = start('action', 'send_goal', ARM, TRAJECTORY, goal(60, 0.5))
    for line in process.stdout:
        if line.startswith('Goal accepted'):
            break
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert 'Canceling goal...\nGoal canceled.\n' in out
    assert out.endswith('Goal finished with status: CANCELED\n')
    assert (process.returncode, err) == (2, '')


def test_signals_and_pipes_end_a_command_silently(start):
    """Ctrl-C is status 2, SIGTERM 143, a closed pipe 141; each message is flushed."""
    for sent, status in ((signal.SIGINT, 2), (signal.SIGTERM, 143), (None, 141)):
        process = start('topic', 'echo', '/sunday/joint_states', '--no-lost-messages')
        assert process.stdout.readline() == 'header:\n'
        if sent is None:
            process.stdout.close()
            process.wait(30)
            assert process.stderr.read() == ''
        else:
            process.send_signal(sent)
            assert process.communicate(timeout=30)[1] == ''
        assert process.returncode == status
