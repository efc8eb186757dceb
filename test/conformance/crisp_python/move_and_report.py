# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A user's program: crisp_py reads the arm, moves it, and prints joints and tool position."""

import sys

from crisp_py.control.parameters_client import ParametersClient
from crisp_py.robot.robot import Robot
from crisp_py.robot.robot_config import RobotConfig

CONTROLLER = 'joint_trajectory_controller'
config = RobotConfig(
    joint_names=[f'joint_{number}' for number in range(1, 7)],
    home_config=[float(word) for word in sys.argv[1:]], base_frame='base_link',
    target_frame='link_6', use_tf_pose=True, time_to_home=1.0)
robot = Robot(namespace='sunday', robot_config=config)
robot.wait_until_ready(60)
switcher = robot.controller_switcher_client
assert switcher.is_server_ready()
robot.home()
(name,) = (entry.name for entry in switcher.get_controller_list() if entry.claimed_interfaces)
assert name == CONTROLLER
parameters = ParametersClient(robot.node, name)
parameters.wait_until_ready(60)
assert parameters.get_parameters(['joints']) == [config.joint_names]
print(*robot.joint_values, *robot.end_effector_pose.position)
robot.shutdown()
assert 'armsim_ros' not in sys.modules
