# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Verbs that read the graph: form, status and words of ros2cli 0.32 on the default robot."""

import re

#: Endpoints of a robot come and go at its start.
COUNT = re.compile(r'[1-9]\d*\n')


def test_topics_are_listed(ros2):
    """Sorted names, -t with types, -c as a number, -v in two paragraphs (ros2topic/verb/list)."""
    names = ros2('topic', 'list').lines
    assert names == sorted(names)
    assert {'/joint_states', '/parameter_events', '/robot_description', '/rosout',
            '/sunday/arm_joint_controller/joint_trajectory', '/tf', '/tf_static'} <= set(names)
    assert not [name for name in names if '/_' in name]
    hidden = ros2('topic', 'list', '--include-hidden-topics').lines
    assert '/move_action/_action/feedback' in hidden
    assert '/joint_states [sensor_msgs/msg/JointState]' in ros2('topic', 'list', '-t').lines
    assert COUNT.fullmatch(ros2('topic', 'list', '-c').out)
    text = ros2('topic', 'list', '-v').out
    assert text.startswith('Published topics:\n * ')
    assert '\n\nSubscribed topics:\n * ' in text
    assert ' * /robot_description [std_msgs/msg/String] 1 publisher\n' in text
    assert text.endswith('\n\n')


def test_a_topic_is_described(ros2):
    """Info, info -v and type; unknown names are status 1 (ros2topic/verb/info, type, find)."""
    assert re.fullmatch(
        r'Type: std_msgs/msg/String\nPublisher count: 1\nSubscription count: \d+\n',
        ros2('topic', 'info', '/robot_description').out)
    text = ros2('topic', 'info', 'robot_description', '-v').out
    for line in ('Type: std_msgs/msg/String', 'Publisher count: 1', 'Node namespace: /',
                 'Endpoint type: PUBLISHER', '  Durability: TRANSIENT_LOCAL',
                 '  Reliability: RELIABLE'):
        assert f'{line}\n' in text
    assert re.search('Topic type hash: RIHS01_[0-9a-f]{64}\n', text)
    assert ros2('topic', 'type', '/robot_description').out == 'std_msgs/msg/String\n'
    assert '/tf' in ros2('topic', 'find', 'tf2_msgs/msg/TFMessage').lines
    assert ros2('topic', 'find', '-c', 'std_msgs/msg/Nope').out == '0\n'
    done = ros2('topic', 'info', '/joint_state')
    assert (done.status, done.out) == (1, '')
    assert done.err == "Unknown topic '/joint_state'; did you mean '/joint_states'?\n"
    assert ros2('topic', 'type', '/nope').status == 1


def test_services_are_listed_and_described(ros2):
    """List, type, find and info (ros2service/verb)."""
    names = ros2('service', 'list').lines
    assert names == sorted(names)
    assert {'/apply_planning_scene', '/compute_ik', '/move_group/get_parameters'} <= set(names)
    kind = 'moveit_msgs/srv/GetPositionIK'
    assert f'/compute_ik [{kind}]' in ros2('service', 'list', '-t').lines
    assert COUNT.fullmatch(ros2('service', 'list', '-c').out)
    assert ros2('service', 'type', '/compute_ik').out == f'{kind}\n'
    assert ros2('service', 'find', kind).out == '/compute_ik\n'
    assert re.fullmatch(  # programs that have just ended count as clients for a while
        rf'Type: {kind}\nClients count: \d+\nServices count: 1\n',
        ros2('service', 'info', '/compute_ik').out)
    done = ros2('service', 'info', '/compute_ikk')
    assert (done.status, done.err) == (
        1, "Unknown service '/compute_ikk'; did you mean '/compute_ik'?\n")


def test_actions_are_listed_and_described(ros2):
    """List, info and type (ros2action/verb)."""
    assert '/move_action [moveit_msgs/action/MoveGroup]' in ros2('action', 'list', '-t').lines
    assert '/move_action' in ros2('action', 'list').lines
    assert COUNT.fullmatch(ros2('action', 'list', '-c').out)
    text = ros2('action', 'info', '/move_action', '-t').out
    assert text.startswith('Action: /move_action\nAction clients: ')
    assert text.endswith('Action servers: 1\n    /move_group [moveit_msgs/action/MoveGroup]\n')
    assert ros2('action', 'type', '/move_action').out == 'moveit_msgs/action/MoveGroup\n'
    assert ros2('action', 'type', '/nope').status == 1
    done = ros2('action', 'info', '-c', '/nope')
    assert (done.status, done.out) == (0, 'Action: /nope\nAction clients: 0\nAction servers: 0\n')


def test_nodes_are_listed_and_described(ros2):
    """Six headings in upstream's order (ros2node/verb)."""
    names = ros2('node', 'list').lines
    assert names == sorted(names)
    assert '/move_group' in names
    assert not [name for name in names if '/_' in name]
    assert COUNT.fullmatch(ros2('node', 'list', '-c').out)
    lines = ros2('node', 'info', '/move_group').lines
    assert lines[0] == '/move_group'
    assert [line for line in lines if re.match('  [A-Z]', line)] == [
        '  Subscribers:', '  Publishers:', '  Service Servers:', '  Service Clients:',
        '  Action Servers:', '  Action Clients:']
    assert '    /compute_ik: moveit_msgs/srv/GetPositionIK' in lines
    assert '    /move_action: moveit_msgs/action/MoveGroup' in lines
    done = ros2('node', 'info', '/move_grup')
    assert (done.status, done.out) == (1, '')
    assert done.err == "Unable to find node '/move_grup'; did you mean '/move_group'?\n"


def test_there_are_no_lifecycle_nodes(ros2):
    """Empty output, and the words of a missing node (ros2lifecycle/verb)."""
    assert (ros2('lifecycle', 'nodes').out, ros2('lifecycle', 'get').out) == ('', '')
    assert ros2('lifecycle', 'nodes', '-c').out == '0\n'
    for words in (('get', '/move_group'), ('list', '/nope'), ('set', '/nope', 'configure')):
        done = ros2('lifecycle', *words)
        assert (done.status, done.out) == (1, '')
        assert done.err.startswith('Node not found')


def test_the_doctor_reports_the_graph(ros2):
    """A healthy robot has no problems; versions and numbers are printed."""
    done = ros2('doctor')
    assert 'ros-jazzy-rclpy' in done.out
    assert re.search(r'graph +\d+ nodes, \d+ topics', done.out)
    assert done.status == ('problem:' in done.out)
    assert 'have the name' not in done.out
    assert 'receives nothing' not in done.out
