# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A user's program: crisp_py drives a Panda through the controllers that it expects."""

from pathlib import Path
import sys

import crisp_py
from crisp_py.robot.robot import Robot
from crisp_py.robot.robot_config import PandaConfig
import numpy as np

config = PandaConfig(time_to_home=1.0)
robot = Robot(robot_config=config)
robot.wait_until_ready(60)
rate = robot.node.create_rate(20.0)


def wait(condition):
    """Wait for half a minute at most."""
    for _ in range(600):
        if condition():
            return
        rate.sleep()
    raise AssertionError('the arm is not where it should be')


robot.home()
np.testing.assert_allclose(robot.joint_values, config.home_config, atol=0.01)
robot.controller_switcher_client.switch_controller('cartesian_impedance_controller')
gains = Path(crisp_py.__file__).parent / 'config' / 'control' / 'default_cartesian_impedance.yaml'
parameters = robot.cartesian_controller_parameters_client
parameters.wait_until_ready(60)
parameters.load_param_config(gains)
assert parameters.get_parameters(['task.k_pos_x', 'use_sim_time']) == [600.0, False]
parameters.set_parameters([('use_friction', False)])
start = robot.end_effector_pose.position
goal = start + np.array([0.0, 0.1, 0.0])
robot.move_to(position=goal, speed=0.1)
wait(lambda: np.linalg.norm(robot.end_effector_pose.position - goal) < 0.005)
robot.set_stiffness([400.0, 400.0, 400.0], [30.0, 30.0, 30.0])
robot.set_target_wrench(force=[0.0, 0.0, 8.0])
# In the tip's axes, as that file has it: downwards, 8 N on 400 N/m.
wait(lambda: abs(goal[2] - robot.end_effector_pose.position[2] - 0.02) < 0.003
     and np.linalg.norm(robot.end_effector_twist.linear) < 0.005)
robot.controller_switcher_client.switch_controller('joint_impedance_controller')
robot.reset_targets()
robot.set_target_joint(np.array(config.home_config) + 0.2 * np.eye(7)[0])
wait(lambda: abs(robot.joint_values[0] - 0.2) < 0.05)
robot.shutdown()
assert 'armsim_ros' not in sys.modules
