# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A small MoveIt package that is started by its own launch files, two beside each other."""

from contextlib import ExitStack
import re
from textwrap import dedent

from control_msgs.msg import JointJog, JointTrajectoryControllerState
from moveit_msgs.srv import ServoCommandType
import pytest
from sensor_msgs.msg import JointState

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.motion import SUCCESS
from armsim_ros.testing.program import private_domain, start_program
from armsim_ros.testing.robot_user import READY, RobotUser

CONTROL = """
from pathlib import Path
from launch import LaunchDescription
from launch.actions import RegisterEventHandler, TimerAction
from launch.event_handlers import OnProcessExit
from launch.substitutions import Command, FindExecutable, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

SHARE = FindPackageShare('small_moveit_config')


def spawner(name):
    return Node(package='controller_manager', executable='spawner', arguments=[name])


def generate_launch_description():
    urdf = Command([FindExecutable(name='xacro'), ' ',
                    PathJoinSubstitution([SHARE, 'config', 'small.urdf.xacro'])])
    control = Node(package='controller_manager', executable='ros2_control_node', parameters=[
        PathJoinSubstitution([SHARE, 'config', 'ros2_controllers.yaml'])],
        remappings=[('~/robot_description', '/robot_description'),
                    ('arm_controller/controller_state', 'arm_state')])
    states = spawner('joint_state_broadcaster')
    return LaunchDescription([
        control, states,
        RegisterEventHandler(OnProcessExit(
            target_action=states, on_exit=[spawner('arm_controller')])),
        # In a batch of its own: the simulation waits for the topic.
        TimerAction(period=0.5, actions=[Node(
            package='robot_state_publisher', executable='robot_state_publisher',
            parameters=[{'robot_description': urdf}])])])
"""
PLANNING = """
from moveit_configs_utils import MoveItConfigsBuilder
from moveit_configs_utils.launches import generate_move_group_launch


def generate_launch_description():
    return generate_move_group_launch(MoveItConfigsBuilder('small').to_moveit_configs())
"""
SERVO = """
from launch import LaunchDescription
from launch_ros.actions import ComposableNodeContainer
from launch_ros.descriptions import ComposableNode
from moveit_configs_utils import MoveItConfigsBuilder


def generate_launch_description():
    config = MoveItConfigsBuilder('small').to_moveit_configs()
    return LaunchDescription([ComposableNodeContainer(
        name='container', namespace='/', package='rclcpp_components',
        executable='component_container_mt', composable_node_descriptions=[ComposableNode(
            package='moveit_servo', plugin='moveit_servo::ServoNode', name='servo_node',
            parameters=[
                {'moveit_servo.move_group_name': 'arm', 'moveit_servo.check_collisions': False,
                 'moveit_servo.command_out_topic': '/arm_controller/joint_trajectory'},
                config.robot_description, config.robot_description_semantic])])])
"""


@pytest.fixture
def launched(small_package, monkeypatch):
    """Return a function that launches a file of the package, and the user of what runs."""
    for name, text in (('control', CONTROL), ('planning', PLANNING), ('servo', SERVO)):
        small_package.write(f'launch/{name}.launch.py', dedent(text))
    small_package.write(
        'config/ros2_controllers.yaml', small_package.ROS2.replace('rate: 500', 'rate: 100'))
    monkeypatch.chdir(small_package.src)
    with ExitStack() as stack:
        domain = stack.enter_context(private_domain())
        client = stack.enter_context(ClientNode(domain, 'user'))

        def launch(name):
            return stack.enter_context(start_program(
                'launch', domain, 'small_moveit_config', f'{name}.launch.py'))

        yield launch, client


def test_two_launch_files_make_one_robot(launched, tmp_path, monkeypatch):
    """
    P44: a launch with move_group alone joins the simulation; a second one is refused.

    Remappings of the manager hold for its controllers, as in upstream's controller_manager.cpp,
    determine_controller_node_options.
    """
    temporary = tmp_path / 'temporary'
    temporary.mkdir()
    monkeypatch.setenv('TMPDIR', str(temporary))
    launch, client = launched
    control = launch('control')
    control.wait_for_line(r'\[spawner-\d+\] .*active: arm_controller', 60.0)
    planning = launch('planning')
    second = launch('control')
    planning.wait_for_line(re.escape(READY), 60.0)
    user = RobotUser(client, control, '')
    client.collect('/arm_state', JointTrajectoryControllerState).wait(1)
    bent = user.move_group.named_states()['arm', 'bent']
    assert user.move_group.move('arm', bent).error_code.val == SUCCESS
    assert user.distance(bent) < 0.01
    assert second.wait(60.0) == 1
    assert re.search(r'already runs on ROS_DOMAIN_ID', second.text)
    assert planning.stop(15.0) == 0
    assert control.stop(15.0) == 0
    assert not list(temporary.glob('armsim_robot_*'))


def test_a_manager_that_asks_finds_the_controllers_of_another_launch(launched, small_package):
    """
    Ros2ControlManager is told of no controllers: what runs when a plan is executed is used.

    Upstream: controller_manager_plugin.cpp, discover.
    """
    small_package.write('config/moveit_controllers.yaml', (
        'moveit_controller_manager: moveit_ros_control_interface/Ros2ControlManager\n'))
    launch, client = launched
    planning = launch('planning')
    control = launch('control')
    planning.wait_for_line(re.escape(READY), 90.0)
    control.wait_for_line(r'\[spawner-\d+\] .*active: arm_controller', 60.0)
    user = RobotUser(client, control, '')
    bent = user.move_group.named_states()['arm', 'bent']
    assert user.move_group.move('arm', bent).error_code.val == SUCCESS
    assert user.distance(bent) < 0.01


def test_servo_of_a_launch_file(launched):
    """
    A launch file that loads moveit_servo starts ours, which moves the arm of another launch.

    Upstream: moveit_servo/launch/demo_ros_api.launch.py; test_ros_integration.cpp, testJointJog.
    """
    launch, client = launched
    control, servo = launch('control'), launch('servo')
    control.wait_for_line(r'\[spawner-\d+\] .*active: arm_controller', 60.0)
    servo.wait_for_line('Servo initialized successfully', 60.0)
    jog = ServoCommandType.Request(command_type=ServoCommandType.Request.JOINT_JOG)
    assert client.call('/servo_node/switch_command_type', ServoCommandType, jog).success
    publisher = client.node.create_publisher(JointJog, '/servo_node/delta_joint_cmds', 10)
    states = client.collect('/joint_states', JointState)

    def turned(message):
        command = JointJog(joint_names=['elbow'], velocities=[-1.0])
        command.header.stamp = client.node.get_clock().now().to_msg()
        publisher.publish(command)
        return dict(zip(message.name, message.position, strict=True)).get('elbow', 0.0) < -0.05

    states.wait_for(turned, 30.0)
