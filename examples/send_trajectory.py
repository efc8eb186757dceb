# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Send a trajectory to the arm's controller and print its feedback and result.

An ordinary ros2_control client: it uses rclpy and control_msgs only and runs unchanged
against a joint_trajectory_controller on a real robot. The joints' names come from the
first controller state message.

    python examples/send_trajectory.py
    python examples/send_trajectory.py --positions 0.3 0.4 0.2 0 0.5 0 --duration 3
"""

import argparse
import sys

from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTrajectoryControllerState
import rclpy
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectoryPoint

TIMEOUT = 30.0
#: Feedback comes twenty times a second; a line is printed this often [s].
FEEDBACK_PERIOD = 0.5


def wait(node, future, what):
    """Return the future's result; leave with a message when it does not come."""
    rclpy.spin_until_future_complete(node, future, timeout_sec=TIMEOUT)
    if not future.done():
        sys.exit(f'no {what} within {TIMEOUT:g} s: is the bringup running?')
    return future.result()


def point(positions, seconds):
    """Return a waypoint at rest."""
    whole = int(seconds)
    return JointTrajectoryPoint(
        positions=positions,
        velocities=[0.0] * len(positions),
        accelerations=[0.0] * len(positions),
        time_from_start=Duration(sec=whole, nanosec=int((seconds - whole) * 1e9)),
    )


def main():
    """Send there-and-back (or the given positions), print feedback and the result."""
    parser = argparse.ArgumentParser(description='Send a trajectory to a controller.')
    parser.add_argument('--controller', default='/sunday/arm_joint_controller')
    parser.add_argument(
        '--positions', type=float, nargs='+', help='goal [rad] (default: 0.3 away and back)'
    )
    parser.add_argument('--duration', type=float, default=2.0, help='[s] for each waypoint')
    arguments = parser.parse_args()

    rclpy.init()
    node = Node('send_trajectory')
    first_state = rclpy.Future()
    node.create_subscription(
        JointTrajectoryControllerState,
        f'{arguments.controller}/controller_state',
        lambda message: first_state.done() or first_state.set_result(message),
        qos_profile_sensor_data,
    )
    state = wait(node, first_state, f'message on {arguments.controller}/controller_state')
    names = list(state.joint_names)
    start = list(state.reference.positions)
    if arguments.positions and len(arguments.positions) != len(names):
        sys.exit(f'--positions needs {len(names)} values, for {", ".join(names)}')

    goal = FollowJointTrajectory.Goal()
    goal.trajectory.joint_names = names
    if arguments.positions:
        goal.trajectory.points = [point(arguments.positions, arguments.duration)]
    else:
        away = [value + 0.3 for value in start]
        goal.trajectory.points = [
            point(away, arguments.duration),
            point(start, 2.0 * arguments.duration),
        ]

    # A rejected goal has no result. This controller publishes its reason; ros2_control's logs it.
    reason = rclpy.Future()
    node.create_subscription(
        String, f'{arguments.controller}/rejected_goals',
        lambda message: reason.done() or reason.set_result(message.data), 10)

    client = ActionClient(
        node, FollowJointTrajectory, f'{arguments.controller}/follow_joint_trajectory'
    )
    if not client.wait_for_server(timeout_sec=TIMEOUT):
        sys.exit(f'no action server at {arguments.controller}: is the bringup running?')

    shown = 0.0

    def print_feedback(message):
        nonlocal shown
        feedback = message.feedback
        elapsed = feedback.desired.time_from_start
        seconds = elapsed.sec + elapsed.nanosec * 1e-9
        if seconds < shown:
            return
        shown = seconds + FEEDBACK_PERIOD
        positions = ' '.join(f'{value:6.3f}' for value in feedback.actual.positions)
        error = 1e3 * max(map(abs, feedback.error.positions), default=0.0)
        print(f'{seconds:5.2f} s: joints at {positions} rad, largest error {error:.3g} mrad')

    handle = wait(node, client.send_goal_async(goal, print_feedback), 'answer to the goal')
    if not handle.accepted:
        rclpy.spin_until_future_complete(node, reason, timeout_sec=1.0)
        sys.exit(reason.result() or f'the goal was rejected; {arguments.controller} logs the '
                 'reason')
    answer = wait(node, handle.get_result_async(), 'result')
    result = answer.result
    print(f'error_code {result.error_code}: {result.error_string}')
    rclpy.shutdown()
    sys.exit(0 if answer.status == GoalStatus.STATUS_SUCCEEDED else 1)


if __name__ == '__main__':
    main()
