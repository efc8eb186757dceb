# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A peer: the least that a FollowJointTrajectory server of rclpy can do.

``python -m benchmarks.controllers.empty_action_server`` accepts every goal, publishes one feedback
message and succeeds at once, until it is terminated.
"""

from __future__ import annotations

from control_msgs.action import FollowJointTrajectory
import rclpy
from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

ACTION = '/empty/follow_joint_trajectory'


def serve() -> None:
    """Serve until a signal comes."""
    rclpy.init()
    node = Node('empty')
    server = ActionServer(node, FollowJointTrajectory, ACTION, _execute)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        executor.spin()
    except ExternalShutdownException:
        server.destroy()


def _execute(handle: ServerGoalHandle) -> FollowJointTrajectory.Result:
    handle.publish_feedback(FollowJointTrajectory.Feedback())
    handle.succeed()
    return FollowJointTrajectory.Result()


if __name__ == '__main__':
    serve()
