# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What franka_bringup's franka.launch.py starts for an arm with its hand, at an address."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import Command, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

HERE = Path(__file__).parent
ACTIVE = ['franka_robot_state_broadcaster', 'joint_trajectory_controller']
#: Not those of the URDF: the driver publishes whatever it is told.
FINGERS = ['left_finger', 'right_finger']


def generate_launch_description():
    """Return control node, state publishers, spawners and the node of the hand."""
    robot_ip = LaunchConfiguration('robot_ip')
    description = Command(['xacro ', str(HERE / 'franka.urdf.xacro')])
    return LaunchDescription([
        DeclareLaunchArgument('robot_ip'),
        Node(package='robot_state_publisher', executable='robot_state_publisher',
             parameters=[{'robot_description': ParameterValue(description, value_type=str)}]),
        Node(package='controller_manager', executable='ros2_control_node',
             parameters=[str(HERE / 'franka_controllers.yaml')]),
        Node(package='controller_manager', executable='spawner', arguments=[
            'joint_state_broadcaster', '--controller-ros-args',
            '--remap joint_states:=franka/joint_states']),
        Node(package='controller_manager', executable='spawner', arguments=ACTIVE),
        Node(package='franka_gripper', executable='franka_gripper_node', name='franka_gripper',
             parameters=[{'robot_ip': robot_ip, 'joint_names': FINGERS,
                          'default_speed': 0.02, 'feedback_publish_rate': 20}]),
    ])
