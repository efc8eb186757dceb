# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics of gpios: ``~/commands`` and ``~/gpio_states``."""

from __future__ import annotations

from control_msgs.msg import DynamicInterfaceGroupValues, InterfaceValue
from rclpy.node import Node

from armsim_ros.control.broadcasters.sensor_broadcaster import SensorSample
from armsim_ros.control.command_controllers.gpio_command_controller import GpioCommandController
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.simulation.wanted_publisher import WantedPublisher


class GpioTopics:
    """Passes commands to the controller and publishes its samples."""

    def __init__(self, node: Node, controller: GpioCommandController) -> None:
        self._controller = controller
        kind = DynamicInterfaceGroupValues
        self._publisher = WantedPublisher(node, kind, '~/gpio_states', qos.STATE)
        self._gpios = controller.gpios
        self._subscription = node.create_subscription(
            kind, '~/commands', self._receive, qos.COMMAND
        ) if controller.required_command_interfaces else None

    def publish(self, sample: SensorSample) -> None:
        """Publish a sample, a group per GPIO."""
        if not self._publisher.wanted(sample.time_ns):
            return
        groups = {gpio: InterfaceValue() for gpio in self._gpios}
        for name, value in zip(self._controller.interfaces, sample.values.tolist(), strict=False):
            gpio, _, kind = name.rpartition('/')
            group = groups[gpio]
            group.interface_names.append(kind)
            group.values.append(value)
        message = DynamicInterfaceGroupValues(
            interface_groups=list(groups), interface_values=list(groups.values()))
        fill_time(message.header.stamp, sample.time_ns)
        self._publisher.publish(message, sample.time_ns)

    def _receive(self, message: DynamicInterfaceGroupValues) -> None:
        gpios, groups = message.interface_groups, message.interface_values
        if len(gpios) != len(groups):
            self._controller.drop(f'{len(gpios)} interface_groups and {len(groups)} '
                                  'interface_values')
            return
        self._controller.receive([
            (gpio, group.interface_names, group.values)
            for gpio, group in zip(gpios, groups, strict=True)
        ])
