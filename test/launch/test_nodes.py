# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Nodes of launch files: namespaces, parameters, remappings."""

import pytest
import yaml

from armsim_ros.launch.api.context import LaunchContext, TextSubstitution
from armsim_ros.launch.api.ros_node import Node, PushRosNamespace, SetParameter, SetRemap
from armsim_ros.launch.api.ros_parameters import evaluate_parameters, ParameterFile, ParameterValue
from armsim_ros.launch.failures import LaunchError


def spec_of(node, *before):
    """Return the process of a node after some actions."""
    context = LaunchContext()
    for action in before:
        action.execute(context)
    return node.spec(context).node


def test_namespaces_nest_and_a_slash_is_absolute():
    """P37 PushRosNamespace: namespaces nest, ``/x`` is absolute."""
    inner = PushRosNamespace('a'), PushRosNamespace('b')
    assert spec_of(Node(executable='x', namespace='c'), *inner).namespace == '/a/b/c'
    assert spec_of(Node(executable='x', namespace='/c'), *inner).namespace == '/c'
    assert spec_of(Node(executable='x')).namespace == '/'


def test_substitutions_are_typed_by_yaml_unless_they_say_so():
    """
    P37 ParameterValue: substitutions are what YAML sees in them, or of their type.

    launch_ros/utilities/normalize_parameters.py, normalize_parameter_dict: other texts are texts.
    """
    text = TextSubstitution(text='1')
    found = evaluate_parameters(LaunchContext(), [{
        'plain': '1', 'own': ParameterValue('5'), 'substitution': text,
        'string': ParameterValue(text, value_type=str), 'truth': 'true', 'time': '12:30:00',
        'number': ParameterValue('2', value_type=float), 'list': [1, 2],
        'block': {'inner': 'x'}, 'texts': ['1', 'b'], 'joined': [text, '.5']}])
    assert found == [{
        'plain': '1', 'own': '5', 'substitution': 1, 'string': '1', 'truth': 'true',
        'time': '12:30:00', 'number': 2.0,
        'list': [1, 2], 'block.inner': 'x', 'texts': ['1', 'b'], 'joined': 1.5}]


@pytest.mark.parametrize('value', [
    [1, 0.5], TextSubstitution(text='[1, 0.5]'), ParameterValue([1, 0.5])])
def test_integers_among_floats_are_floats(value):
    """launch_ros/utilities/normalize_parameters.py, _normalize_parameter_array_value."""
    (block,) = evaluate_parameters(LaunchContext(), [{'gains': value}])
    assert list(map(type, block['gains'])) == [float, float]


def test_a_text_of_set_parameter_is_typed_by_yaml():
    """launch_ros/actions/node.py, _perform_substitutions: it becomes ``-p x:=2``."""
    assert spec_of(Node(executable='x'), SetParameter('x', '2')).merged() == {'x': 2}


def test_a_robot_description_stays_a_text():
    """P37: a robot description is a text also without ParameterValue."""
    urdf = '<?xml version="1.0"?>\n<!-- a: b -->\n<robot name="r"/>'
    found = evaluate_parameters(LaunchContext(), [{'robot_description': TextSubstitution(
        text=urdf)}])
    assert found == [{'robot_description': urdf}]


def test_a_value_of_another_type_is_refused():
    """P37 ParameterValue: a text that is no value of its type is a mistake with its line."""
    value = ParameterValue(TextSubstitution(text='x'), value_type=int)
    with pytest.raises(LaunchError, match="'x' is not a valid int"):
        evaluate_parameters(LaunchContext(), [{'n': value}])


def test_files_and_what_groups_set_come_first(tmp_path):
    """P36 SetParameter, SetRemap: a group's parameters and remappings come before the node's."""
    file = tmp_path / 'f.yaml'
    file.touch()
    node = spec_of(Node(executable='x', parameters=[file, {'a': 1}], remappings=[('b', 'c')]),
                   SetParameter('use_sim_time', True), SetRemap('d', 'e'))
    assert node.group_parameters == [{'use_sim_time': True}]
    assert node.parameters == [str(file), {'a': 1}]
    assert node.remappings == [('d', 'e'), ('b', 'c')]


@pytest.mark.parametrize(('own', 'pattern', 'prefix'), [
    (None, '', ['nice', '-n', '5']), (None, 'arm', ['nice', '-n', '5']), (None, 'leg', []),
    ('gdb', 'leg', ['gdb'])])
def test_the_prefix_of_a_process(own, pattern, prefix):
    """launch/descriptions/executable.py, prepare: the filter does not hold for its own prefix."""
    context = LaunchContext()
    context.launch_configurations.update(
        {'launch-prefix': 'nice -n 5', 'launch-prefix-filter': pattern})
    assert Node(executable='arm_driver', prefix=own).spec(context).prefix == prefix


@pytest.mark.parametrize(('more', 'before', 'key'), [
    ({'name': 'arm', 'namespace': 'left'}, (), '/left/arm'),
    ({'name': 'arm', 'namespace': ''}, (), '/arm'),
    ({'name': 'arm'}, (PushRosNamespace('left'),), '/left/arm'),
    ({'name': 'arm'}, (), '/**'), ({'namespace': 'left'}, (), '/**')])
def test_parameters_are_under_the_full_name_where_it_is_known(more, before, key):
    """launch_ros/actions/node.py, _create_params_file_from_dict."""
    assert spec_of(Node(executable='x', **more), *before).key == key


def test_a_parameter_file_that_does_not_exist_is_skipped(entities):
    """launch_ros/actions/node.py, _perform_substitutions: with a warning."""
    said = entities("node('arm', parameters=['nowhere.yaml', {'a': 1}]),")
    assert said.plan == ['process: mine/one name=arm ns=/ parameters=a']
    assert 'it.launch.py:15: parameter file path is not a file: nowhere.yaml' in said.errors


def test_a_parameter_file_with_substitutions(entities, workspace):
    """P36 ParameterFile: allow_substs replaces $(var x); without it the file is as it is."""
    file = workspace / 'config' / 'p.yaml'
    file.write_text('x: {ros__parameters: {a: $(var who)}}')
    context = LaunchContext()
    context.launch_configurations['who'] = 'anna'
    assert ParameterFile(str(file)).evaluate(context) == str(file)
    said = entities("""
        DeclareLaunchArgument('who', default_value='anna'),
        OpaqueFunction(function=lambda context: print(Path(ParameterFile(
            [FindPackageShare('mine'), '/config/p.yaml'], allow_substs=True)
            .evaluate(context)).read_text())),
    """, before='from pathlib import Path')
    content = yaml.safe_load(next(line for line in said.errors.splitlines() if 'ros__' in line))
    assert content == {'x': {'ros__parameters': {'a': 'anna'}}}


def test_the_line_of_a_dry_run(entities, workspace):
    """P41: package, program, name, namespace, names of parameters and files, each once."""
    (workspace / 'config' / 'controllers.yaml').touch()
    said = entities("""
        PushRosNamespace('cell'),
        Node(package='mine', executable='two', name='arm', namespace='left', parameters=[
            {'a': 1, 'b': {'c': 2, 'd': 3}}, 'src/mine/config/controllers.yaml', {'a': 2}],
            arguments=['--x'], remappings=[('q', 'r')], output='screen', emulate_tty=True,
            respawn=True, on_exit=Shutdown()),
    """)
    assert said.plan == [
        'process: mine/two name=arm ns=/cell/left parameters=a,b,controllers.yaml']


def test_what_is_not_installed_is_named_and_its_exit_handlers_fire(entities):
    """P39: a program that is not there is named; what waits for its end goes on."""
    said = entities("""
        absent := Node(package='some_driver', executable='driver'),
        RegisterEventHandler(OnProcessExit(target_action=absent, on_exit=[node('after')])),
    """)
    assert said.plan == ['unknown: some_driver/driver is not installed and not started',
                         'process: mine/one name=after ns=/ parameters=']
    assert said.status == 0


def test_components_are_named(entities):
    """P36 ComposableNode: components of a container are named, one line each."""
    said = entities("""
        ComposableNodeContainer(
            name='box', namespace='', package='rclcpp_components',
            executable='component_container', composable_node_descriptions=[
                ComposableNode(package='lib', plugin='lib::Talker', name='talker')]),
    """)
    assert said.plan == [
        'unknown: lib/lib::Talker is not installed and not started',
        'unknown: rclcpp_components/component_container is not installed and not started']


@pytest.mark.parametrize(('package', 'plugin', 'name', 'process'), [
    ('moveit_servo', 'moveit_servo::ServoNode', 'servo_node', 'servo_node'),
    ('robot_state_publisher', 'robot_state_publisher::RobotStatePublisher',
     'robot_state_publisher', 'robot_state_publisher'),
    ('tf2_ros', 'tf2_ros::StaticTransformBroadcasterNode', 'static_tf2_broadcaster',
     'static_transform_broadcaster_node')])
def test_components_with_a_program_here(entities, package, plugin, name, process):
    """
    A node that a launch file loads into a container is a process of its own.

    Upstream: moveit_servo/launch/demo_ros_api.launch.py.
    """
    said = entities(f"""
        ComposableNodeContainer(
            name='box', namespace='', package='rclcpp_components',
            executable='component_container', composable_node_descriptions=[
                ComposableNode(package='{package}', plugin='{plugin}', name='{name}',
                               parameters=[{{'block.a': 1}}])]),
    """)
    assert f'process: {package}/{process} name={name} ns=/ parameters=block' in said.plan


def test_a_dry_run_names_topics_that_nothing_publishes(entities):
    """The bridge is replaced, but not the sensors of Gazebo behind it."""
    said = entities("""
        Node(package='ros_gz_bridge', executable='parameter_bridge',
             arguments=['/scan@sensor_msgs/msg/LaserScan[gz.msgs.LaserScan']),
    """)
    assert said.plan == ['process: ros_gz_bridge/parameter_bridge name=parameter_bridge ns=/ '
                         'parameters=']
    assert 'not simulated: /scan (sensor_msgs/msg/LaserScan)' in said.errors


def test_nothing_to_start(entities):
    """P41: a file that starts nothing says so."""
    assert entities("DeclareLaunchArgument('a', default_value='b'),").plan == ['nothing to start']
