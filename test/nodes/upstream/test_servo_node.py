# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Servo as launch files start it: robot and parameters are in its parameters."""

import yaml

from armsim_ros.cli.node_arguments import NodeArguments
from armsim_ros.config.loading import load_robot_settings
from armsim_ros.nodes.upstream.robot_programs import servo_words

URDF = """<robot name="two"><link name="base"/><link name="arm"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""
SRDF = """<robot name="two"><group name="all"><chain base_link="base" tip_link="arm"/></group>
</robot>"""


def test_words_of_servo(tmp_path):
    """
    The block moveit_servo and what is beside it are parameters, with upstream's topics.

    Upstream: moveit_servo/launch/demo_ros_api.launch.py; servo_parameters.yaml.
    """
    arguments = NodeArguments('my_servo', namespace='/left', values={
        'robot_description': URDF, 'robot_description_semantic': SRDF,
        'robot_description_planning.joint_limits.turn.has_acceleration_limits': True,
        'robot_description_planning.joint_limits.turn.max_acceleration': 3.0,
        'moveit_servo.move_group_name': 'all', 'moveit_servo.scale.linear': 0.2,
        'update_period': 0.02, 'planning_group_name': 'all', 'use_sim_time': True,
    }, remappings=['a:=b'])
    words = servo_words(arguments, tmp_path)
    assert words[3:9] == ['-r', 'a:=b', '-r', '__node:=my_servo', '-r', '__ns:=/left']
    file = words[words.index('--params-file') + 1]
    with open(file, encoding='utf-8') as stream:
        parameters = yaml.safe_load(stream)['/**']['ros__parameters']
    assert parameters == {
        'moveit_servo.move_group_name': 'all', 'moveit_servo.scale.linear': 0.2,
        'moveit_servo.command_out_topic': '/panda_arm_controller/joint_trajectory',
        'moveit_servo.joint_topic': '/joint_states',
        'moveit_servo.monitored_planning_scene_topic': '/planning_scene',
        'update_period': 0.02, 'planning_group_name': 'all',
    }
    robot = words[0].removeprefix('robot:=')
    limits = load_robot_settings(robot).joint_limits.joint_limits
    assert limits['turn'].max_acceleration == 3.0
