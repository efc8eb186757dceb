# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The other process: sends back what it gets.

Arguments: types of messages. Each arrives on ``/there/<package>`` and leaves on
``/back/<package>``. Besides, ``/switch`` answers with the request in words, and ``/follow``
succeeds after a second of feedback.
"""

from contextlib import suppress
import sys
import threading

from control_msgs.action import FollowJointTrajectory
from controller_manager_msgs.srv import SwitchController
from filled import interface
import rclpy
from rclpy.action import ActionServer
from rclpy.executors import ExternalShutdownException
from rclpy.qos import DurabilityPolicy, QoSProfile

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def switch(request, response):
    """Answer with the request in words."""
    response.ok = True
    response.message = ' '.join([*request.activate_controllers, str(request.strictness)])
    return response


def follow(handle):
    """Send the last point as feedback for a second, then succeed."""
    feedback = FollowJointTrajectory.Feedback()
    feedback.joint_names = handle.request.trajectory.joint_names
    feedback.desired = handle.request.trajectory.points[-1]
    pause = threading.Event()
    for _ in range(50):
        # The first ones may be lost: the client's subscription may not be known here yet.
        handle.publish_feedback(feedback)
        pause.wait(0.02)
    handle.succeed()
    return FollowJointTrajectory.Result(error_string='done')


def main():
    """Serve until a signal comes."""
    rclpy.init()
    node = rclpy.create_node('echo_peer')
    for name in sys.argv[1:]:
        package = name.split('/')[0]
        back = node.create_publisher(interface(name), f'/back/{package}', LATCHED)
        node.create_subscription(interface(name), f'/there/{package}', back.publish, LATCHED)
    node.create_service(SwitchController, '/switch', switch)
    server = ActionServer(node, FollowJointTrajectory, '/follow', follow)
    with suppress(ExternalShutdownException, KeyboardInterrupt):
        rclpy.spin(node)
    # A participant that is left to the end of the process may wait there for ever.
    server.destroy()
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()
