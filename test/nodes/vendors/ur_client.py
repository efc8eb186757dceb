# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A client as written for a real arm of Universal Robots; it knows of no simulation."""

import sys

from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
import rclpy
from rclpy.action import ActionClient
from rclpy.node import Node
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from ur_dashboard_msgs.action import SetMode
from ur_dashboard_msgs.msg import RobotMode
from ur_dashboard_msgs.srv import GetRobotMode
from ur_msgs.srv import SetIO, SetSpeedSliderFraction

JOINTS = ['shoulder_pan_joint', 'shoulder_lift_joint', 'elbow_joint',
          'wrist_1_joint', 'wrist_2_joint', 'wrist_3_joint']
IO, DASHBOARD = '/io_and_status_controller', '/dashboard_client'
TARGET = [0.5, -1.2, 0.4, -1.4, 0.2, 0.1]


class Robot(Node):
    """The arm, its inputs and outputs, and its dashboard."""

    def call(self, kind, name, **request):
        """Call a service that has to succeed; return the response."""
        client = self.create_client(kind, name)
        if not client.wait_for_service(timeout_sec=30.0):
            sys.exit(f'no service {name}')
        response = self.wait(client.call_async(kind.Request(**request)))
        self.destroy_client(client)
        if not response.success:
            sys.exit(f'{name}: {response}')
        return response

    def run(self, kind, name, goal):
        """Send a goal; return its result."""
        client = ActionClient(self, kind, name)
        if not client.wait_for_server(timeout_sec=30.0):
            sys.exit(f'no action {name}')
        handle = self.wait(client.send_goal_async(goal))
        if not handle.accepted:
            sys.exit(f'{name}: rejected')
        return self.wait(handle.get_result_async()).result

    def wait(self, future):
        """Spin until an answer is there."""
        rclpy.spin_until_future_complete(self, future, timeout_sec=40.0)
        return future.result()


def main():
    """Power up, clear stops, play the program, set an output, move at half the speed."""
    rclpy.init()
    robot = Robot('client_of_a_real_arm')
    robot.call(Trigger, f'{DASHBOARD}/power_on')
    robot.call(Trigger, f'{DASHBOARD}/brake_release')
    robot.call(Trigger, f'{DASHBOARD}/close_safety_popup')
    robot.call(Trigger, f'{DASHBOARD}/unlock_protective_stop')
    result = robot.run(SetMode, '/ur_robot_state_helper/set_mode', SetMode.Goal(
        target_robot_mode=RobotMode.RUNNING, stop_program=True, play_program=False))
    print(f'set_mode: {result.success} {result.message}')
    mode = robot.call(GetRobotMode, f'{DASHBOARD}/get_robot_mode').robot_mode.mode
    print(f'robot mode {mode}')
    print(robot.call(Trigger, f'{DASHBOARD}/play').message)
    robot.call(SetIO, f'{IO}/set_io', fun=SetIO.Request.FUN_SET_DIGITAL_OUT, pin=1, state=1.0)
    robot.call(SetSpeedSliderFraction, f'{IO}/set_speed_slider', speed_slider_fraction=0.5)
    outcome = robot.run(
        FollowJointTrajectory, '/scaled_joint_trajectory_controller/follow_joint_trajectory',
        FollowJointTrajectory.Goal(trajectory=JointTrajectory(
            joint_names=JOINTS, points=[JointTrajectoryPoint(
                positions=TARGET, time_from_start=Duration(sec=1))])))
    print(f'trajectory: {outcome.error_code} {outcome.error_string}')
    robot.call(SetSpeedSliderFraction, f'{IO}/set_speed_slider', speed_slider_fraction=1.0)
    robot.destroy_node()
    rclpy.shutdown()
    return int(outcome.error_code != FollowJointTrajectory.Result.SUCCESSFUL)


if __name__ == '__main__':
    sys.exit(main())
