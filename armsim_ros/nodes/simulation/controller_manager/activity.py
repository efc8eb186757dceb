# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``~/activity`` of the controller manager."""

from __future__ import annotations

from controller_manager_msgs.msg import ControllerManagerActivity
from rclpy.node import Node

from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.controller_manager import activity_message


class Activity:
    """
    Publishes the states of controllers and hardware whenever any has changed.

    :param node: the manager's node.
    """

    def __init__(self, node: Node, manager: ControllerManager) -> None:
        self._manager = manager
        self._generation = -1
        self._publisher = node.create_publisher(
            ControllerManagerActivity, '~/activity', qos.LATCHED
        )

    def publish_if_changed(self, time_ns: int) -> None:
        """
        Publish the states if any of them has changed since the last call.

        :param time_ns: [ns] of the simulation.
        """
        generation = self._manager.generation
        if generation == self._generation:
            return
        self._generation = generation
        self._publisher.publish(
            activity_message(
                time_ns,
                self._manager.list_controllers(),
                self._manager.list_hardware_components(),
            )
        )
