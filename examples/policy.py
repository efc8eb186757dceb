# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Stream joint positions at 30 Hz, as a learned policy does.

    armsim copy sunday my_robot     # then add the position controller of docs/streaming.md
    armsim bringup robot:=my_robot
    python examples/policy.py --controller /sunday/position_controller
"""

import argparse
import math
import signal
import sys
import time

from controller_manager_msgs.srv import ListControllers, SwitchController
import rclpy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

RATE = 30.0


class Policy:
    """Returns the next positions for the present ones; here a slow wave about the start."""

    def __init__(self, start):
        self.start = start

    def act(self, observation, seconds):
        """Return the next positions [rad]."""
        return [value + 0.2 * (1.0 - math.cos(0.8 * seconds)) for value in self.start]


def call(node, kind, name, request):
    """Call a service and return its answer."""
    client = node.create_client(kind, name)
    if not client.wait_for_service(10.0):
        sys.exit(f'policy: service {name} is not there; is the arm running?')
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=10.0)
    if not future.done():
        sys.exit(f'policy: {name} does not answer')
    return future.result()


def joints_of(node, manager, name):
    """Return the joints that a controller commands, in its order."""
    answer = call(node, ListControllers, f'{manager}/list_controllers', ListControllers.Request())
    for controller in answer.controller:
        if controller.name == name:
            return [interface.rpartition('/')[0]
                    for interface in controller.required_command_interfaces]
    known = ', '.join(each.name for each in answer.controller)
    sys.exit(f"policy: no controller '{name}' is loaded; loaded: {known}; docs/streaming.md "
             'has the lines to add')


def main():
    """Switch to the position controller, stream, switch back."""
    parser = argparse.ArgumentParser(description='Stream joint positions at 30 Hz.')
    parser.add_argument('--controller', default='/sunday/position_controller')
    parser.add_argument('--instead-of', default='arm_joint_controller')
    parser.add_argument('--seconds', type=float, default=10.0)
    arguments = parser.parse_args()
    namespace, _, name = arguments.controller.rpartition('/')
    # Ctrl-C ends the wave alone: the arm goes back to the trajectory controller.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node('policy')
    newest = {}
    node.create_subscription(
        JointState, f'{namespace}/joint_states',
        lambda m: newest.update(zip(m.name, m.position, strict=True)), 1)
    commands = node.create_publisher(Float64MultiArray, f'{arguments.controller}/commands', 1)
    manager = f'{namespace}/controller_manager'
    joints = joints_of(node, manager, name)
    while not set(joints) <= set(newest):
        rclpy.spin_once(node, timeout_sec=1.0)
    switch = f'{manager}/switch_controller'
    there = SwitchController.Request(
        activate_controllers=[name], deactivate_controllers=[arguments.instead_of], strictness=2)
    answer = call(node, SwitchController, switch, there)
    if not answer.ok:
        sys.exit(f'policy: {answer.message}')
    ended = []
    signal.signal(signal.SIGINT, lambda *_: ended.append(True))
    policy = Policy([newest[joint] for joint in joints])
    begin = time.monotonic()
    step = 0
    while not ended and time.monotonic() - begin < arguments.seconds:
        rclpy.spin_once(node, timeout_sec=0.0)
        observation = [newest[joint] for joint in joints]
        action = policy.act(observation, time.monotonic() - begin)
        commands.publish(Float64MultiArray(data=action))
        step += 1
        time.sleep(max(0.0, begin + step / RATE - time.monotonic()))
    back = SwitchController.Request(
        activate_controllers=[arguments.instead_of], deactivate_controllers=[name], strictness=2)
    call(node, SwitchController, switch, back)
    rclpy.shutdown()


if __name__ == '__main__':
    main()
