# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What stands in for the programs of a launch file that are started together."""

import pytest

from armsim_ros.launch.api.process import ExecuteProcess
from armsim_ros.launch.api.ros_node import ComposableNode, Node
from armsim_ros.launch.lookup import looking_with, make_lookup
from armsim_ros.launch.mapping import FLOOR, GRIPPER, JOINT_STATES, Kind
from armsim_ros.launch.process_spec import COMPONENTS

CONTROL = Node(package='controller_manager', executable='ros2_control_node',
               parameters=[{'robot_description': '<robot name="r"/>'}])


MESH = ('<robot name="r"><link name="l"><collision><geometry><mesh filename="file://{}"/>'
        '</geometry></collision></link></robot>')


def publisher(**parameters):
    """Return a joint_state_publisher."""
    return Node(package='joint_state_publisher', executable='joint_state_publisher',
                parameters=[parameters])


def spawner(name):
    """Return a spawner of one controller."""
    return Node(package='controller_manager', executable='spawner', arguments=[name])


def tells_joints(texts):
    """Return whether the simulation is told to publish joint states of its own."""
    return any(JOINT_STATES in one for one in texts)


def test_a_joint_state_publisher_beside_hardware(decided):
    """
    It runs, and the simulation publishes what the driver would have.

    Drivers that publish joint states themselves have no broadcaster spawned.
    """
    (_, publishing, _), texts = decided(CONTROL, publisher(source_list=['joint_states']),
                                  spawner('arm_controller'))
    assert publishing.kind is Kind.RUN
    assert tells_joints(texts)


def test_a_spawned_broadcaster_is_enough(decided):
    """Where a spawner starts the broadcaster, the simulation waits for it."""
    _, texts = decided(CONTROL, publisher(), spawner('joint_state_broadcaster'))
    assert not tells_joints(texts)


@pytest.mark.parametrize(('words', 'shell'), [
    (['ros2', 'run', 'controller_manager', 'spawner', 'arm', '--inactive'], False),
    (['ros2 run controller_manager spawner arm ', '--inactive'], True),
])
def test_a_spawner_by_ros2_run_keeps_its_arguments(decided, words, shell):
    """A command may be a list of words or, for a shell, texts of several words."""
    ((_, one), _) = decided(CONTROL, ExecuteProcess(cmd=words, shell=shell))
    at = one.command.index('spawner')
    assert one.command[at + 1:at + 3] == ['arm', '--inactive']


def test_a_robot_that_is_spawned_stands_in_a_simulators_world(decided):
    """Only there is a floor under it; ros2_control_node alone has none."""
    _, texts = decided(Node(package='ros_gz_sim', executable='create',
                            arguments=['-string', URDF]), spawner('arm'))
    assert any(one.get(FLOOR) for one in texts)
    _, texts = decided(CONTROL, spawner('arm'))
    assert not any(FLOOR in one for one in texts)


SDF = """<?xml version="1.0"?>
<sdf version="1.8"><model name="arm"><joint name="j" type="revolute"/>{}</model></sdf>"""
PLUGIN = '<plugin filename="gz_ros2_control-system" name="gz_ros2_control::GazeboSimROS2Control"/>'
URDF = '<robot name="r"><ros2_control name="s" type="system"/></robot>'


def create(file, **more):
    """Return the spawner of a model in a file."""
    return Node(package='ros_gz_sim', executable='create', arguments=['-file', str(file)], **more)


CUBE = '<robot name="cube"><link name="l"/><!-- <ros2_control/> -->{}</robot>'
DOOR = '<joint name="door" type="revolute"/>'
OBJECT = "'{}' has no <ros2_control>: an object, which is not simulated; put it into the world"


def spawned(name, *words):
    """Return the spawner of an entity of a name."""
    return Node(package='gazebo_ros', executable='spawn_entity.py',
                arguments=['-entity', name, *words])


def state_publisher(urdf, **more):
    """Return a robot_state_publisher of a URDF."""
    return Node(package='robot_state_publisher', executable='robot_state_publisher',
                parameters=[{'robot_description': urdf}], **more)


def simulated(texts):
    """Return the descriptions that are given to simulations."""
    return [one['robot_description'] for one in texts if FLOOR in one]


@pytest.mark.parametrize('joint', ['', DOOR])
def test_an_object_that_is_spawned_before_the_robot_is_not_simulated(decided, joint):
    """
    The robot is the model with controllers, whatever comes first and moves.

    Upstream: gazebo_ros/scripts/spawn_entity.py adds every model to the world.
    """
    (cube, arm), texts = decided(spawned('cube', '-string', CUBE.format(joint)),
                                 spawned('arm', '-string', URDF))
    assert (cube.kind, cube.level, cube.simulation) == (Kind.DONE, 'WARNING', None)
    assert cube.note.startswith(OBJECT.format('cube'))
    assert arm.simulation is not None
    assert simulated(texts) == [URDF]


def test_a_model_that_cannot_move_is_an_object_where_it_is_alone(decided):
    """The robot may be spawned later; with joints and no controllers elsewhere, it is a robot."""
    (cube,), _ = decided(spawned('cube', '-string', CUBE.format('')))
    assert cube.note.startswith(OBJECT.format('cube'))
    (door,), texts = decided(spawned('door', '-string', CUBE.format(DOOR)))
    assert door.simulation is not None
    assert simulated(texts) == [CUBE.format(DOOR)]


def test_a_robot_may_have_controllers_by_a_plugin_alone(decided):
    """
    The plugin reads <ros2_control> from the robot_state_publisher.

    Upstream: gazebo_ros2_control/src/gazebo_ros2_control_plugin.cpp, getURDF.
    """
    model = f'<robot name="r"><gazebo>{PLUGIN}</gazebo></robot>'
    (_, arm), texts = decided(state_publisher(URDF), spawned('arm', '-string', model))
    assert arm.simulation is not None
    assert simulated(texts) == [model]


@pytest.mark.parametrize('last', ['arm', 'table'])
def test_each_model_is_that_of_its_topic(decided, last):
    """Two robot_state_publishers in one namespace publish to different topics."""
    publishers = {
        'arm': state_publisher(URDF),
        'table': state_publisher(
            CUBE.format(''), remappings=[('robot_description', 'table_description')])}
    (_, _, table, arm), texts = decided(
        *sorted(publishers.values(), key=lambda one: one is publishers[last]),
        spawned('table', '-topic', '/table_description'),
        spawned('arm', '-topic', 'robot_description'))
    assert table.note.startswith(OBJECT.format('table'))
    assert arm.simulation is not None
    assert simulated(texts) == [URDF]


def test_a_topic_that_nothing_publishes_is_not_the_robots(decided):
    """An entity of an unknown model does not become the robot that another topic has."""
    (_, table), _ = decided(state_publisher(URDF), spawned('table', '-topic', 'table_model'))
    assert table.simulation is None
    assert "'table' is not spawned: no robot_state_publisher" in table.note


def test_a_second_entity_is_named_with_what_helps(decided):
    """Its absence shows; an object can be spawned into the world, a robot be part of a cell."""
    (_, cube, second), _ = decided(
        spawned('arm', '-string', URDF), spawned('cube', '-string', CUBE.format('')),
        spawned('second', '-string', URDF))
    assert cube.note.startswith(OBJECT.format('cube'))
    assert second.note.startswith("'second' is not spawned: the simulation has its robot already")
    assert 'docs/many_robots.md' in second.note
    assert [one.level for one in (cube, second)] == ['WARNING'] * 2


@pytest.mark.parametrize('executable', ['create', 'spawn_entity.py'])
def test_a_robot_in_sdf_is_simulated_by_the_urdf_of_the_state_publisher(
        decided, tmp_path, executable):
    """The SDF was made of that URDF; an SDF without controllers is an object, not spawned."""
    file = tmp_path / 'model.sdf'
    file.write_text(SDF.format(PLUGIN))
    package = 'gazebo_ros' if executable.startswith('spawn') else 'ros_gz_sim'
    state_publisher = Node(package='robot_state_publisher', executable='robot_state_publisher',
                           parameters=[{'robot_description': URDF}])
    (_, spawned), texts = decided(state_publisher, Node(
        package=package, executable=executable, arguments=['-file', str(file)]))
    assert spawned.simulation is not None
    assert any(one.get('robot_description') == URDF for one in texts[1:])
    file.write_text(SDF.format(''))
    (_, spawned), _ = decided(state_publisher, create(file))
    assert spawned.simulation is None
    assert spawned.kind is Kind.DONE


def test_the_description_may_be_that_of_a_component(decided):
    """
    A ros2_control_node without a description takes that of the file's robot_state_publisher.

    Upstream: moveit_servo/launch/demo_ros_api.launch.py.
    """
    plugin = 'robot_state_publisher::RobotStatePublisher'
    component = ComposableNode(package='robot_state_publisher', plugin=plugin,
                               parameters=[{'robot_description': URDF}])
    (_, made), texts = decided(
        Node(package='controller_manager', executable='ros2_control_node'),
        component.process(*COMPONENTS[plugin]))
    assert (made.kind, made.is_ours) == (Kind.RUN, True)
    assert texts[0]['robot_description'] == URDF


@pytest.mark.parametrize('folder', ['', 'models'])
def test_a_model_is_found_by_its_name(decided, tmp_path, folder):
    """Gazebo finds a model's folder in its resource paths, which a package's hooks set."""
    package = tmp_path / 'src' / 'arm_description'
    model = package / folder / 'arm'
    model.mkdir(parents=True)
    (package / 'package.xml').write_text('<package><name>arm_description</name></package>')
    (model / 'model.sdf').write_text(SDF.format(PLUGIN))
    state_publisher = Node(package='robot_state_publisher', executable='robot_state_publisher',
                           parameters=[{'robot_description': URDF}])
    with looking_with(make_lookup([tmp_path], [])):
        (_, spawned), _ = decided(state_publisher, create('arm'))
        (missing,), _ = decided(create('leg'))
    assert spawned.simulation is not None
    assert missing.note == "'leg' is not found and not spawned"


def test_a_model_is_found_where_the_launch_file_says(decided, tmp_path):
    """The resource paths are those of the process, which a group of the file may have set."""
    (tmp_path / 'arm').mkdir()
    (tmp_path / 'arm' / 'model.sdf').write_text(URDF)
    found = create('arm', additional_env={'GZ_SIM_RESOURCE_PATH': str(tmp_path)})
    (spawned,), _ = decided(found)
    assert spawned.simulation is not None


@pytest.mark.parametrize('urdf', ['', URDF.replace('ros2_control', 'gazebo')])
def test_a_robot_in_sdf_without_a_urdf_is_refused(decided, tmp_path, urdf):
    """Nothing would ever move it, and everything else would wait."""
    file = tmp_path / 'model.sdf'
    file.write_text(SDF.format(PLUGIN))
    nodes = [Node(package='robot_state_publisher', executable='robot_state_publisher',
                  parameters=[{'robot_description': urdf}])] if urdf else []
    (*_, refused), _ = decided(*nodes, create(file))
    assert refused.kind is Kind.REFUSED
    assert 'model.sdf is an SDF, which is not simulated' in refused.note


def test_state_publishers_run_beside_the_simulation(decided, tmp_path):
    """Each keeps its name, its namespace and its parameters."""
    (_, states, transforms), texts = decided(
        CONTROL, publisher(source_list=['joint_states']),
        Node(package='robot_state_publisher', executable='robot_state_publisher', name='rsp',
             namespace='left', remappings=[('joint_states', 'merged')],
             parameters=[{'robot_description': '<robot name="r"/>', 'frame_prefix': 'left/',
                          'publish_frequency': 5.0}]))
    assert states.command[-4:] == [
        'joint_state_publisher', '--ros-args', '--params-file', str(tmp_path / 'parameters.yaml')]
    words = transforms.command
    assert words[words.index('robot_state_publisher'):] == [
        'robot_state_publisher', '--ros-args', '-r', '__node:=rsp', '-r', '__ns:=/left',
        '--params-file', str(tmp_path / 'parameters.yaml'), '-r', 'joint_states:=merged']
    assert {'frame_prefix': 'left/', 'publish_frequency': 5.0}.items() <= texts[-1].items()


def test_a_package_is_known_by_the_files_of_its_meshes(decided, workspace):
    """Addresses that xacro made with a slash too many lead to the same package."""
    for slashes in ('', '/'):
        mesh = f'{slashes}{workspace}/meshes/hand.stl'
        _, texts = decided(Node(package='controller_manager', executable='ros2_control_node',
                                parameters=[{'robot_description': MESH.format(mesh)}]))
        (found,) = [one['armsim.packages_path'] for one in texts if 'armsim.packages_path' in one]
        assert found == str(workspace)


@pytest.mark.parametrize('executable', ['servo_node', 'servo_node_main'])
def test_servo_is_ours(decided, executable):
    """
    Servo of a launch file is servo_node of this package, by Humble's name too.

    Upstream: moveit_servo/CMakeLists.txt and moveit_servo/launch/demo_ros_api.launch.py.
    """
    servo = Node(package='moveit_servo', executable=executable, name='my_servo',
                 parameters=[{'moveit_servo.scale.linear': 0.2, 'robot_description': '<robot/>'}])
    (start,), texts = decided(servo)
    assert (start.kind, start.is_ours) == (Kind.RUN, True)
    assert 'servo_node' in start.command
    assert '__node:=my_servo' in start.command
    assert texts[0]['moveit_servo.scale.linear'] == 0.2


def test_the_hardware_spawner_is_ours(decided):
    """hardware_spawner keeps its words."""
    (made,), _ = decided(Node(package='controller_manager', executable='hardware_spawner',
                              arguments=['Arm', '--configure']))
    place = made.command.index('hardware_spawner')
    assert made.command[place:place + 3] == ['hardware_spawner', 'Arm', '--configure']


TF2_TOOLS = [('tf2_ros', 'tf2_echo'), ('tf2_ros', 'tf2_monitor'), ('tf2_tools', 'view_frames')]


@pytest.mark.parametrize(('package', 'executable'), TF2_TOOLS)
def test_tools_of_tf2_are_ours_where_they_are_not_installed(decided, package, executable):
    """They keep their words."""
    (made,), _ = decided(Node(package=package, executable=executable, arguments=['a', 'b']))
    place = made.command.index(executable)
    assert made.is_ours
    assert made.command[place:place + 3] == [executable, 'a', 'b']


@pytest.mark.parametrize(('package', 'executable'), TF2_TOOLS)
def test_installed_tools_of_tf2_are_started(decided, tmp_path, monkeypatch, package, executable):
    """Programs of a ROS installation that only show the robot are not replaced."""
    program = tmp_path / 'lib' / package / executable
    program.parent.mkdir(parents=True)
    program.write_text('#!/bin/sh\n')
    program.chmod(0o755)
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    (made,), _ = decided(Node(package=package, executable=executable, arguments=['a']))
    assert (made.kind, made.is_ours) == (Kind.RUN, False)
    assert made.command[:2] == [str(program), 'a']


def test_a_shell_splits_the_words_of_a_node(decided):
    """With shell=True, words are split at blanks, and empty ones are dropped."""
    (made,), _ = decided(Node(package='controller_manager', executable='spawner', shell=True,
                              arguments=['arm', '', "--controller-ros-args '-r a:=b'"]))
    place = made.command.index('spawner')
    assert made.command[place:place + 4] == [
        'spawner', 'arm', '--controller-ros-args', '-r a:=b']


def test_rosbridge_is_the_bridge_and_rosapi_a_part_of_it(decided):
    """With the parameters that the launch file gives; one process serves both."""
    (bridge, rosapi), texts = decided(
        Node(package='rosbridge_server', executable='rosbridge_websocket',
             parameters=[{'port': 9091}]),
        Node(package='rosapi', executable='rosapi_node'))
    assert 'rosbridge_websocket' in bridge.command
    assert texts[0] == {'port': 9091}
    assert (bridge.kind, rosapi.kind) == (Kind.RUN, Kind.PART)


def test_foxglove_bridge_is_the_bridge(decided):
    """Its port is that of Foxglove."""
    (bridge,), texts = decided(Node(package='foxglove_bridge', executable='foxglove_bridge',
                                    parameters=[{'port': 8766}]))
    assert 'foxglove_bridge' in bridge.command
    assert (bridge.kind, texts[0]) == (Kind.RUN, {'port': 8766})


def test_the_node_of_a_hand_is_a_part_with_its_arguments(decided, tmp_path):
    """franka_gripper's node gets no process; the simulation gets its name and parameters."""
    file = tmp_path / 'franka_gripper_node.yaml'
    file.write_text('franka_gripper: {ros__parameters: {state_publish_rate: 50}}')
    (control, hand), texts = decided(CONTROL, Node(
        package='franka_gripper', executable='franka_gripper_node', name='franka_gripper',
        parameters=[{'default_speed': 0.05}, str(file)]))
    assert (control.kind, hand.kind) == (Kind.RUN, Kind.PART)
    (words,) = (one[GRIPPER] for one in texts if GRIPPER in one)
    assert '__node:=franka_gripper' in words
    assert {'default_speed': 0.05} in texts
    assert words[-2:] == ['--params-file', str(file)]
