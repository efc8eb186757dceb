# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Plan to a named state and execute, as RViz's "Plan & Execute" button does.

An ordinary MoveIt client: it uses rclpy and moveit_msgs only and runs unchanged against
MoveIt's own move_group. The named state's joint values come from the SRDF that the
``robot_description_semantic`` topic carries.

    python examples/plan_and_execute.py scan_food
"""

import argparse
import sys
from xml.etree import ElementTree

from action_msgs.msg import GoalStatus
from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import Constraints, JointConstraint, MoveItErrorCodes
import rclpy
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, qos_profile_sensor_data, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import String

CODES = {
    getattr(MoveItErrorCodes, name): name
    for name in dir(type(MoveItErrorCodes))
    if name.isupper() and not name.startswith('_')
}


def error_name(code):
    """Return a code's name and number."""
    return f'{CODES.get(code, "error code")} ({code})'


class Client:
    """The few things that this example waits for."""

    def __init__(self, node, timeout):
        self.node = node
        self.timeout = timeout

    def wait(self, future, what):
        """Return the future's result; leave with a message when it does not come."""
        rclpy.spin_until_future_complete(self.node, future, timeout_sec=self.timeout)
        if not future.done():
            sys.exit(f'no {what} within {self.timeout:g} s: is the bringup running?')
        return future.result()

    def first_message(self, message_type, topic, qos):
        """Return the first message of a topic."""
        future = rclpy.Future()

        def keep(message):
            if not future.done():
                future.set_result(message)

        subscription = self.node.create_subscription(message_type, topic, keep, qos)
        message = self.wait(future, f'message on {topic}')
        self.node.destroy_subscription(subscription)
        return message


def named_state(srdf, group, name):
    """Return joint -> value of a group state; leave with the known names."""
    states = {
        (state.get('group'), state.get('name')): {
            joint.get('name'): float(joint.get('value')) for joint in state.findall('joint')
        }
        for state in ElementTree.fromstring(srdf).findall('group_state')
    }
    if (group, name) not in states:
        known = ', '.join(sorted(state for owner, state in states if owner == group))
        sys.exit(f"group '{group}' has no state '{name}'; known states: {known or 'none'}")
    return states[group, name]


def goal_for(group, target, arguments):
    """Return the action goal for joint -> value, in the form that RViz sends."""
    goal = MoveGroup.Goal()
    request = goal.request
    request.group_name = group
    request.num_planning_attempts = 1
    request.allowed_planning_time = 5.0
    request.max_velocity_scaling_factor = arguments.velocity_scaling
    request.max_acceleration_scaling_factor = arguments.acceleration_scaling
    request.start_state.is_diff = True
    request.goal_constraints = [
        Constraints(
            joint_constraints=[
                JointConstraint(
                    joint_name=joint,
                    position=value,
                    tolerance_above=1e-4,
                    tolerance_below=1e-4,
                    weight=1.0,
                )
                for joint, value in target.items()
            ]
        )
    ]
    goal.planning_options.plan_only = arguments.plan_only
    goal.planning_options.planning_scene_diff.is_diff = True
    goal.planning_options.planning_scene_diff.robot_state.is_diff = True
    return goal


def first_group(srdf):
    """Return the name of the SRDF's first group that has states."""
    root = ElementTree.fromstring(srdf)
    with_states = [state.get('group') for state in root.findall('group_state')]
    groups = [group.get('name') for group in root.findall('group')]
    return next((name for name in groups if name in with_states), groups[0])


def main():
    """Plan, execute, and print how far each joint is from its goal."""
    parser = argparse.ArgumentParser(description='Move the arm to a named state.')
    parser.add_argument('state', help='a group state of the SRDF, such as scan_food')
    parser.add_argument('--group', help='planning group (default: the first with states)')
    parser.add_argument('--joint-states', default='/sunday/joint_states', help='topic')
    parser.add_argument('--plan-only', action='store_true', help='do not move')
    parser.add_argument('--velocity-scaling', type=float, default=0.5, metavar='0..1')
    parser.add_argument('--acceleration-scaling', type=float, default=0.5, metavar='0..1')
    parser.add_argument('--timeout', type=float, default=30.0, help='[s] for each answer')
    arguments = parser.parse_args()

    rclpy.init()
    client = Client(Node('plan_and_execute'), arguments.timeout)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    srdf = client.first_message(String, '/robot_description_semantic', latched).data
    group = arguments.group or first_group(srdf)
    target = named_state(srdf, group, arguments.state)

    move_action = ActionClient(client.node, MoveGroup, '/move_action')
    if not move_action.wait_for_server(timeout_sec=arguments.timeout):
        sys.exit('no action server /move_action: is the bringup running?')
    goal = client.wait(
        move_action.send_goal_async(goal_for(group, target, arguments)), 'answer to the goal'
    )
    if not goal.accepted:
        sys.exit('move_group refused the goal')
    answer = client.wait(goal.get_result_async(), 'result')
    result = answer.result
    if answer.status != GoalStatus.STATUS_SUCCEEDED:
        sys.exit(f'failed: {error_name(result.error_code.val)}: {result.error_code.message}')

    points = result.planned_trajectory.joint_trajectory.points
    last = points[-1].time_from_start if points else None
    duration = last.sec + last.nanosec * 1e-9 if last else 0.0
    print(f'planned {len(points)} points, {duration:.2f} s, in {result.planning_time:.3f} s')
    if arguments.plan_only:
        return
    state = client.first_message(JointState, arguments.joint_states, qos_profile_sensor_data)
    measured = dict(zip(state.name, state.position, strict=False))
    worst = 0.0
    for joint, value in target.items():
        error = abs(measured[joint] - value)
        worst = max(worst, error)
        print(f'{joint}: {measured[joint]:+.4f} rad, goal {value:+.4f}, error {error:.4f}')
    print(f"arrived at '{arguments.state}', largest joint error {worst:.5f} rad")
    rclpy.shutdown()


if __name__ == '__main__':
    main()
