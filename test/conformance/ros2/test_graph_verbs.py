# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Verbs that read the graph, beyond what upstream.yaml has: order, hidden names, hints."""

import re

import pytest


@pytest.mark.parametrize(('kind', 'some', 'more'), [
    ('topic', {'/joint_states', '/tf_static', '/sunday/arm_joint_controller/joint_trajectory'},
     ['--include-hidden-topics']),
    ('service', {'/apply_planning_scene', '/compute_ik', '/move_group/get_parameters'},
     ['--include-hidden-services']),
    ('node', {'/move_group', '/sunday/controller_manager'}, ['-a']),
])
def test_names_are_sorted_and_hidden_ones_left_out(kind, some, more, ros2):
    """An option includes the hidden ones (ros2topic, ros2service, ros2node: verb/list.py)."""
    names = ros2(kind, 'list').lines
    assert names == sorted(names)
    assert some <= set(names)
    assert not [name for name in names if '/_' in name]
    assert [name for name in ros2(kind, 'list', *more).lines if '/_' in name]


def test_topics_with_counts_are_in_two_paragraphs(ros2):
    """Each ends with an empty line (ros2topic/verb/list.py)."""
    text = ros2('topic', 'list', '-v').out
    assert text.startswith('Published topics:\n * ')
    assert '\n\nSubscribed topics:\n * ' in text
    assert text.endswith('\n\n')


@pytest.mark.parametrize(('words', 'text'), [
    (('topic', 'info', '/joint_state'), "Unknown topic '/joint_state'; did you mean "
                                        "'/joint_states'?"),
    (('service', 'info', '/compute_ikk'), "Unknown service '/compute_ikk'; did you mean "
                                          "'/compute_ik'?"),
    (('node', 'info', '/move_grup'), "Unable to find node '/move_grup'; did you mean "
                                     "'/move_group'?"),
])
def test_a_missing_name_is_hinted_at(words, text, ros2):
    """One line on standard error, with the most similar name."""
    done = ros2(*words)
    assert (done.status, done.out, done.err) == (1, '', f'{text}\n')


def test_a_node_has_six_headings(ros2):
    """All are printed, in upstream's order (ros2node/verb/info.py)."""
    lines = ros2('node', 'info', '/move_group').lines
    assert [line for line in lines if re.match('  [A-Z]', line)] == [
        '  Subscribers:', '  Publishers:', '  Service Servers:', '  Service Clients:',
        '  Action Servers:', '  Action Clients:']


def test_nodes_with_the_same_name_are_reported(ros2, start):
    """Upstream's warnings of list and info, and a problem of the doctor."""
    for _ in range(2):
        process = start('topic', 'pub', '-n', 'twin', '/chat', 'std_msgs/msg/String')
        assert process.stdout.readline() == 'publisher: beginning loop\n'
    done = ros2('node', 'list')
    assert done.lines.count('/twin') == 2
    assert 'share an exact name' in done.err
    assert ros2('node', 'info', '/twin').err.startswith(
        'There are 2 nodes in the graph with the exact name "/twin"')
    assert '2 nodes have the name /twin' in ros2('doctor').out


def test_the_doctor_reports_the_graph(ros2):
    """A healthy robot has no problems; versions and numbers are printed."""
    done = ros2('doctor')
    assert 'ros-jazzy-rclpy' in done.out
    assert re.search(r'graph +\d+ nodes, \d+ topics', done.out)
    assert done.status == ('problem:' in done.out)
    assert 'have the name' not in done.out
    assert 'receives nothing' not in done.out
