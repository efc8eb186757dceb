# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What ur_robot_driver's ur_control.launch.py starts for an arm at an address."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import Command, LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

HERE = Path(__file__).parent
ACTIVE = ['joint_state_broadcaster', 'io_and_status_controller',
          'speed_scaling_state_broadcaster', 'ur_configuration_controller',
          'scaled_joint_trajectory_controller']
INACTIVE = ['joint_trajectory_controller', 'freedrive_mode_controller']


def driver(executable, name='', **parameters):
    """Return a program of the driver."""
    named = {'name': name} if name else {}
    return Node(package='ur_robot_driver', executable=executable, **named,
                parameters=[{key: value} for key, value in parameters.items()])


def generate_launch_description():
    """Return control node, dashboard client, helpers and spawners."""
    robot_ip, headless = LaunchConfiguration('robot_ip'), LaunchConfiguration('headless_mode')
    description = Command(['xacro ', str(HERE / 'ur_driver.urdf.xacro'),
                           ' headless_mode:=', headless])
    return LaunchDescription([
        DeclareLaunchArgument('robot_ip'),
        DeclareLaunchArgument('headless_mode', default_value='false'),
        Node(package='controller_manager', executable='ros2_control_node',
             parameters=[str(HERE / 'ur_driver_controllers.yaml')]),
        driver('dashboard_client', 'dashboard_client', robot_ip=robot_ip),
        driver('robot_state_helper', 'ur_robot_state_helper', headless_mode=headless,
               robot_ip=robot_ip),
        driver('controller_stopper_node', 'controller_stopper', headless_mode=headless,
               consistent_controllers=ACTIVE[:-1]),
        driver('urscript_interface', robot_ip=robot_ip),
        Node(package='robot_state_publisher', executable='robot_state_publisher',
             parameters=[{'robot_description': ParameterValue(description, value_type=str)}]),
        Node(package='controller_manager', executable='spawner', arguments=ACTIVE),
        Node(package='controller_manager', executable='spawner',
             arguments=['--inactive', *INACTIVE]),
    ])
