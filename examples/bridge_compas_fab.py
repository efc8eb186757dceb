# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Plan and move the arm with compas_fab, as Grasshopper and Rhino do.

    pip install compas_fab
    armsim bringup bridge:=true
    python examples/bridge_compas_fab.py

The first argument is another port.
"""

import sys
import threading

from compas_fab.backends import MoveItPlanner, RosClient
from compas_fab.robots import ConfigurationTarget, TargetMode
from roslibpy import ActionClient, Goal

CONTROLLER = '/sunday/arm_joint_controller/follow_joint_trajectory'
PATIENCE = 30.0


def execute(client, trajectory):
    """Send a trajectory to the controller and return the action's status."""
    points = []
    for point in trajectory.points:
        points.append({
            'positions': list(point.joint_values), 'velocities': list(point.velocities),
            'time_from_start': {'secs': point.time_from_start.secs,
                                'nsecs': point.time_from_start.nsecs}})
    goal = Goal({'trajectory': {'joint_names': list(trajectory.joint_names), 'points': points}})
    action = ActionClient(client, CONTROLLER, 'control_msgs/action/FollowJointTrajectory')
    done, answers = threading.Event(), []

    def answer(result):
        answers.append(result)
        done.set()

    action.send_goal(goal, answer, lambda _: None, answer)
    assert done.wait(PATIENCE), 'no result'
    return answers[0]['status']


def main():
    """Plan, execute, and return 0 where the controller succeeded."""
    port = int(sys.argv[1]) if len(sys.argv) > 1 else 9090
    with RosClient('127.0.0.1', port) as client:
        cell = client.load_robot_cell(load_geometry=False)
        planner = MoveItPlanner(client)
        state = cell.default_cell_state()
        planner.set_robot_cell(cell)
        planner.set_robot_cell_state(state)
        group = cell.main_group_name
        frame = planner.forward_kinematics(state, TargetMode.ROBOT, group)
        print(f'tool at {frame.point}')
        goal = state.robot_configuration.copy()
        goal['joint_1'] = 0.3
        trajectory = planner.plan_motion(ConfigurationTarget(goal), state, group)
        print(f'planned {len(trajectory.points)} points')
        status = execute(client, trajectory)
        print(f'status {status.name}')
    return 0 if status.name == 'SUCCEEDED' else 1


if __name__ == '__main__':
    sys.exit(main())
