# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``~/controller_state``."""

from __future__ import annotations

from control_msgs.msg import JointTrajectoryControllerState
from rclpy.node import Node

from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.controller_state import fill_controller_state
from armsim_ros.nodes.simulation.wanted_publisher import WantedPublisher


class ControllerStatePublisher:
    """
    Publishes reference, feedback, error and output of a trajectory controller.

    The rate is the parameter ``state_publish_rate``; the reference implementation publishes at
    every update, which at the rate of our physics would be more than any client reads.

    :param node: the controller's node.
    """

    def __init__(self, node: Node, controller: JointTrajectoryController) -> None:
        self._controller = controller
        self._message = JointTrajectoryControllerState()
        self._published = -1
        self._publisher = WantedPublisher(
            node, JointTrajectoryControllerState, '~/controller_state', qos.STATE
        )

    def publish_if_due(self, time_ns: int) -> None:
        """
        Publish the latest state if it is due and there was an update since the last state.

        :param time_ns: [ns] of the simulation.
        """
        if not self._controller.active or not self._controller.publish_due(time_ns):
            return
        if not self._publisher.wanted(time_ns):
            return
        snapshot = self._controller.snapshot()
        if snapshot is not None and snapshot.sequence != self._published:
            self._published = snapshot.sequence
            fill_controller_state(self._message, snapshot)
            self._publisher.publish(self._message, time_ns)
