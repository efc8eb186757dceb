# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services of the controller manager that list what it has."""

from __future__ import annotations

from typing import Any

from controller_manager_msgs.srv import (
    ListControllers,
    ListControllerTypes,
    ListHardwareComponents,
    ListHardwareInterfaces,
    SetHardwareComponentState,
)
from rclpy.node import Node

from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.errors import ControllerError
from armsim_ros.nodes.conversions.controller_manager import (
    component_message,
    controller_message,
    interface_messages,
)
from armsim_ros.nodes.conversions.lifecycle import state_label, state_message

#: Whether a type is chainable -> its base class in ros2_control.
BASE_CLASSES = {False: 'controller_interface::ControllerInterface',
                True: 'controller_interface::ChainableControllerInterface'}


class ControllerManagerQueries:
    """
    ``list_controllers``, ``list_controller_types``, ``list_hardware_*`` and hardware states.

    :param node: the manager's node.
    :param update_rate: [Hz] of the manager.
    """

    def __init__(self, node: Node, manager: ControllerManager, update_rate: float) -> None:
        self._node = node
        self._manager = manager
        self._update_rate = update_rate
        for name, kind, answer in (
            ('list_controllers', ListControllers, self._list_controllers),
            ('list_controller_types', ListControllerTypes, self._list_types),
            ('list_hardware_components', ListHardwareComponents, self._list_components),
            ('list_hardware_interfaces', ListHardwareInterfaces, self._list_interfaces),
            (
                'set_hardware_component_state',
                SetHardwareComponentState,
                self._set_component_state,
            ),
        ):
            node.create_service(kind, f'~/{name}', answer)

    def _list_controllers(self, _: Any, response: Any) -> Any:
        response.controller = [
            controller_message(info) for info in self._manager.list_controllers()
        ]
        return response

    def _list_types(self, _: Any, response: Any) -> Any:
        types = self._manager.list_types()
        response.types = list(types)
        response.base_classes = [BASE_CLASSES[chainable] for chainable in types.values()]
        return response

    def _list_components(self, _: Any, response: Any) -> Any:
        response.component = [
            component_message(info, self._update_rate)
            for info in self._manager.list_hardware_components()
        ]
        return response

    def _list_interfaces(self, _: Any, response: Any) -> Any:
        command, state = self._manager.list_hardware_interfaces()
        response.command_interfaces = interface_messages(command)
        response.state_interfaces = interface_messages(state)
        return response

    def _set_component_state(self, request: Any, response: Any) -> Any:
        try:
            self._manager.set_hardware_component_state(
                request.name, state_label(request.target_state)
            )
            response.ok = True
        except ControllerError as error:
            self._node.get_logger().error(str(error))
        for info in self._manager.list_hardware_components():
            if info.name == request.name:
                response.state = state_message(info.state)
        return response
