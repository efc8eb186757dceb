# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Verbs that send and receive messages: form, status and words of ros2cli 0.32."""

import signal

import yaml

CALL = ('service', 'call', '/get_planning_scene', 'moveit_msgs/srv/GetPlanningScene')
ARM = '/sunday/arm_joint_controller/follow_joint_trajectory'
TRAJECTORY = 'control_msgs/action/FollowJointTrajectory'


def goal(seconds, position=0.1):
    """Return a goal that moves the first joint."""
    names = [f'joint_{i}' for i in range(1, 7)]
    positions = [position, 0, 0, 0, 0, 0]
    return str({'trajectory': {'joint_names': names, 'points': [
        {'positions': positions, 'time_from_start': {'sec': seconds}}]}})


def test_a_latched_message_is_echoed(ros2):
    """QoS found from the publisher; truncated, as a field, as CSV (ros2topic/verb/echo.py)."""
    words = ('topic', 'echo', '--once', '/robot_description')
    done = ros2(*words, '-l', '10')
    assert (done.status, done.out.count('---\n')) == (0, 1)
    assert yaml.safe_load(done.out.removesuffix('---\n'))['data'].endswith('...')
    assert ros2(*words, '--no-str').out.startswith("data: '<string length: <")
    assert ros2(*words, '--field', 'data').out.split()[-2:] == ['</robot>', '---']
    assert ros2(*words, '--csv', '-l', '5').out.endswith('...\n')
    done = ros2(*words, '--field', 'dat')
    assert done.status == 1
    assert done.err.startswith("Invalid field 'dat': 'String' object has no attribute 'dat'")


def test_a_stream_is_echoed(ros2):
    """Joint states as YAML, filtered, and with a time-out."""
    words = ('topic', 'echo', '/sunday/joint_states', '--no-lost-messages')
    message = yaml.safe_load(ros2(*words, '--once').out.removesuffix('---\n'))
    assert list(message) == ['header', 'name', 'position', 'velocity', 'effort']
    assert 'joint_1' in message['name']
    assert ros2(*words, '--once', '--field', 'name[0]').out.startswith('joint_')
    text = ros2(*words, '--once', '--no-arr').out
    assert f"name: '<sequence type: string, length: {len(message['name'])}>'" in text
    assert ros2(*words, '--filter', 'False', '--timeout', '0.1').out == ''


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


def test_messages_are_published(ros2):
    """The words of ros2topic/verb/pub.py; wrong values are refused before anything is sent."""
    words = ('topic', 'pub', '/chat', 'std_msgs/msg/String')
    assert ros2(*words, '{data: a}', '-t', '2', '-w', '0', '-r', '50').out == (
        "publisher: beginning loop\npublishing #1: std_msgs.msg.String(data='a')\n\n"
        "publishing #2: std_msgs.msg.String(data='a')\n\n")
    done = ros2(*words, '{data: a}', '--once', '--max-wait-time-secs', '0.1')
    assert done.out == 'Waiting for at least 1 matching subscription(s)...\n'
    assert done.err.startswith('Timed out waiting for subscribers: Expected 1')
    for values, text in (('{dta: a}', 'Failed to populate field: '),
                         ('[1]', 'The passed value needs to be a dictionary in YAML format')):
        done = ros2(*words, values)
        assert (done.status, done.out) == (1, '')
        assert done.err.startswith(text)


def test_a_message_reaches_a_subscriber(ros2, start):
    """Topic pub --once waits for the subscription of a topic echo, and stamps the header."""
    echo = start('topic', 'echo', '--once', '/stamped', 'geometry_msgs/msg/PoseStamped')
    done = ros2('topic', 'pub', '--once', '/stamped', 'geometry_msgs/msg/PoseStamped',
                '{header: {stamp: now, frame_id: base}, pose: {position: {x: 1.5}}}')
    assert done.status == 0
    out, _ = echo.communicate(timeout=30)
    message = yaml.safe_load(out.removesuffix('---\n'))
    assert message['header']['stamp']['sec'] > 1_600_000_000
    assert message['pose']['position']['x'] == 1.5


def test_a_service_is_called(ros2):
    """Request and response as Python values (ros2service/verb/call.py)."""
    done = ros2(*CALL, '{components: {components: 1}}')
    assert done.status == 0
    assert done.out.removeprefix('waiting for service to become available...\n').startswith(
        'requester: making request: moveit_msgs.srv.GetPlanningScene_Request(components=')
    assert '\n\nresponse:\nmoveit_msgs.srv.GetPlanningScene_Response(scene=' in done.out
    assert ros2(*CALL, '{component: 1}').err.startswith('Failed to populate field: ')
    done = ros2('service', 'call', '/compute_ik', 'moveit_msgs/srv/GetPositionFK')
    assert (done.status, done.out) == (1, 'waiting for service to become available...\n')
    assert "'/compute_ik' has the type 'moveit_msgs/srv/GetPositionIK'" in done.err
    done = ros2('service', 'call', '/compute_ik', 'moveit_msgs/srv/Nope')
    assert done.err.startswith('The passed service type is invalid')


def test_a_goal_is_sent(ros2):
    """Goal, acceptance, feedback, result and status in words (ros2action/verb/send_goal.py)."""
    done = ros2('action', 'send_goal', '-f', ARM, TRAJECTORY, goal(1))
    assert done.status == 0
    for text in ('Waiting for an action server to become available...\nSending goal:\n     '
                 'trajectory:\n', 'Goal accepted with ID: ', 'Feedback:\n    header:\n',
                 'Result:\n    error_code: 0\n', 'Goal finished with status: SUCCEEDED\n'):
        assert text in done.out
    done = ros2('action', 'send_goal', ARM, TRAJECTORY, '{trajectory: {joint_names: [nope]}}')
    assert (done.status, done.lines[-1]) == (0, 'Goal was rejected.')
    done = ros2('action', 'send_goal', ARM, TRAJECTORY, '{nope: 1}')
    assert done.err.startswith('Failed to populate message fields: ')


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


def test_rates_are_printed(start):
    """Hz, bw and delay print in upstream's form until they are stopped."""
    for verb, first, second in (
            ('hz', 'average rate: ', '\tmin: '),
            ('bw', 'Subscribed to [/sunday/joint_states]', ''),
            ('delay', 'average delay: ', '\tmin: ')):
        process = start('topic', verb, '/sunday/joint_states')
        assert process.stdout.readline().startswith(first)
        line = process.stdout.readline()
        assert line.startswith(second)
        if verb == 'bw':
            assert '/s from ' in line
            assert process.stdout.readline().startswith('\tMessage size mean: ')
        process.send_signal(signal.SIGINT)
        assert process.wait(30) == 2
