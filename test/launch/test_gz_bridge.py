# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which topics of a bridge are published, and what is told of the others."""

import pytest

from armsim_ros.launch.api.process import ExecuteProcess
from armsim_ros.launch.api.ros_node import Node
from armsim_ros.launch.mapping import Kind

IMAGE = '/wrist/image@sensor_msgs/msg/Image[gz.msgs.Image'
CLOCK = '/clock@rosgraph_msgs/msg/Clock[gz.msgs.Clock'


def bridge(*words, **more):
    """Return a bridge of topics between ROS and Gazebo."""
    return Node(package='ros_gz_bridge', executable='parameter_bridge', arguments=words, **more)


def test_a_bridge_of_published_topics_is_a_part(decided):
    """Clock, joint states and transforms come from the simulation, by remapped names too."""
    ((made,), _) = decided(bridge(
        CLOCK, '/model/arm/joints@sensor_msgs/msg/JointState[gz.msgs.Model',
        remappings=[('/model/arm/joints', 'joint_states')]))
    assert (made.kind, made.level) == (Kind.PART, 'INFO')
    assert made.note.startswith('the simulation publishes these topics itself')


@pytest.mark.parametrize('node', [
    bridge(IMAGE, CLOCK),
    ExecuteProcess(cmd=['ros2', 'run', 'ros_gz_bridge', 'parameter_bridge', IMAGE]),
    ExecuteProcess(cmd=[f"ros2 run ros_gz_bridge parameter_bridge '{IMAGE}'"], shell=True)])
def test_topics_of_a_bridge_that_nothing_publishes_are_named(decided, node):
    """
    A client that waits for images would wait forever; the remedy for cameras is in the line.

    Upstream: ros2_kortex/kortex_bringup/launch/kortex_sim_control.launch.py.
    """
    ((made,), _) = decided(node)
    assert (made.kind, made.level) == (Kind.PART, 'WARNING')
    assert made.note.startswith('not simulated: /wrist/image (sensor_msgs/msg/Image); cameras')


@pytest.mark.parametrize(('text', 'note'), [
    ('- {topic_name: scan, ros_type_name: sensor_msgs/msg/LaserScan, gz_type_name: x}',
     'not simulated: scan (sensor_msgs/msg/LaserScan)'),
    ('- {ros_topic_name: a, gz_topic_name: b, ros_type_name: std_msgs/msg/Bool, gz_type_name: x}',
     'not simulated: a (std_msgs/msg/Bool)'),
    ('- {gz_topic_name: clock, ros_type_name: rosgraph_msgs/msg/Clock, gz_type_name: x}',
     'the simulation publishes these topics itself: part of the simulation'),
    ('- [', 'the topics of the bridge cannot be read: '),
    ('# M\xfcller', 'the topics of the bridge cannot be read: ')])
def test_topics_of_a_bridge_in_a_file(decided, tmp_path, text, note):
    """ros_gz_bridge/src/bridge_config.cpp, parseEntry: the keys that name a topic."""
    file = tmp_path / 'bridge.yaml'
    file.write_text(text, encoding='latin-1')
    ((made,), _) = decided(bridge(parameters=[{'config_file': str(file)}]))
    assert made.note.startswith(note)


@pytest.mark.parametrize('given', ['parameter', 'parameter file', 'argument'])
def test_a_bridge_may_be_given_its_file_in_each_way_of_a_node(decided, tmp_path, given):
    """Rclcpp has the same parameters of all of them, and the remappings of the arguments."""
    file, parameters = tmp_path / 'bridge.yaml', tmp_path / 'parameters.yaml'
    file.write_text('- {topic_name: world/joints, ros_type_name: sensor_msgs/msg/JointState}\n'
                    '- {topic_name: scan, ros_type_name: sensor_msgs/msg/LaserScan}')
    parameters.write_text(f'/**: {{ros__parameters: {{config_file: {file}}}}}')
    ros_args = ['--ros-args', '-r', 'world/joints:=/joint_states']
    more = {'parameter': {'parameters': [{'config_file': str(file)}]},
            'parameter file': {'parameters': [str(parameters)]}, 'argument': {}}[given]
    if given == 'argument':
        ros_args += ['-p', f'config_file:={file}']
    ((made,), _) = decided(bridge(*ros_args, **more))
    assert made.note == 'not simulated: scan (sensor_msgs/msg/LaserScan)'


def test_words_of_a_bridge_that_no_shell_understands_are_told(decided):
    """A warning never ends a launch."""
    ((made,), _) = decided(ExecuteProcess(
        cmd=["ros2 run ros_gz_bridge parameter_bridge /x@a/msg/B[c # it's"], shell=True))
    assert made.note.startswith('the topics of the bridge cannot be read: No closing quotation')
