# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Typed clients of a controller manager's services and of a node's parameter services."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from controller_manager_msgs.msg import ControllerState
from controller_manager_msgs.srv import (
    CleanupController,
    ConfigureController,
    ListControllers,
    ListControllerTypes,
    ListHardwareComponents,
    ListHardwareInterfaces,
    LoadController,
    SetHardwareComponentState,
    SwitchController,
    UnloadController,
)
from rcl_interfaces.msg import ParameterDescriptor
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter, parameter_value_to_python

from armsim_ros.nodes.conversions.controller_manager import state_message
from armsim_ros.nodes.conversions.time import duration_from_seconds


class Caller(Protocol):
    """Calls services and waits for their responses, as ``ClientNode`` does."""

    def call(self, service: str, kind: type[Any], request: Any = None) -> Any:
        """Call a service and return its response."""


class ParameterClient:
    """
    Reads and writes parameters of another node.

    :param client: what calls, such as a :class:`ClientNode`.
    :param node: the other node's full name.
    """

    def __init__(self, client: Caller, node: str) -> None:
        self._client, self._node = client, node

    def names(self) -> list[str]:
        """Return the names of all parameters."""
        response = self._client.call(f'{self._node}/list_parameters', ListParameters)
        return list(response.result.names)

    def get(self, name: str) -> Any:
        """Return a value; None where it is not set."""
        request = GetParameters.Request(names=[name])
        response = self._client.call(f'{self._node}/get_parameters', GetParameters, request)
        return parameter_value_to_python(response.values[0])

    def describe(self, name: str) -> ParameterDescriptor:
        """Return the descriptor of a parameter."""
        request = DescribeParameters.Request(names=[name])
        response = self._client.call(
            f'{self._node}/describe_parameters', DescribeParameters, request)
        descriptor: ParameterDescriptor = response.descriptors[0]
        return descriptor

    def set(self, name: str, value: Any) -> str:
        """Set a value; return the reason of a refusal, or '' where it was taken."""
        return self.set_all({name: value})[name]

    def set_all(self, values: Mapping[str, Any]) -> dict[str, str]:
        """Set values in one request; return the reason of each refusal, or ''."""
        request = SetParameters.Request(parameters=[
            Parameter(name, value=value).to_parameter_msg() for name, value in values.items()])
        response = self._client.call(f'{self._node}/set_parameters', SetParameters, request)
        return {
            name: '' if result.successful else result.reason or 'refused without a reason'
            for name, result in zip(values, response.results, strict=True)}


STRICT = SwitchController.Request.STRICT
BEST_EFFORT = SwitchController.Request.BEST_EFFORT


class ControllerManagerClient:
    """
    Calls the services of a manager.

    :param client: what calls, such as a :class:`ClientNode`.
    :param manager: the manager's full name, such as ``/sunday/controller_manager``.
    """

    def __init__(self, client: Caller, manager: str) -> None:
        self._client, self._manager = client, manager

    def controllers(self) -> dict[str, ControllerState]:
        """Return the loaded controllers by name."""
        response = self._call('list_controllers', ListControllers)
        return {state.name: state for state in response.controller}

    def states(self) -> dict[str, str]:
        """Return controller -> lifecycle state."""
        return {name: state.state for name, state in self.controllers().items()}

    def controller_types(self) -> Any:
        """Return the response of list_controller_types."""
        return self._call('list_controller_types', ListControllerTypes)

    def hardware_components(self) -> Any:
        """Return the response of list_hardware_components."""
        return self._call('list_hardware_components', ListHardwareComponents)

    def hardware_states(self) -> dict[str, str]:
        """Return hardware component -> lifecycle state."""
        return {component.name: str(component.state.label)
                for component in self.hardware_components().component}

    def set_hardware_state(self, name: str, state: str) -> str:
        """Bring a hardware component into a state; return the state that it has then."""
        request = SetHardwareComponentState.Request(name=name, target_state=state_message(state))
        response = self._call('set_hardware_component_state', SetHardwareComponentState, request)
        return str(response.state.label)

    def hardware_interfaces(self) -> Any:
        """Return the response of list_hardware_interfaces."""
        return self._call('list_hardware_interfaces', ListHardwareInterfaces)

    def switch(
        self, *, activate: Sequence[str] = (), deactivate: Sequence[str] = (),
        strictness: int = STRICT, timeout: float = 0.0, asap: bool = False
    ) -> Any:
        """Switch controllers and return the response (ok, message)."""
        request = SwitchController.Request(
            activate_controllers=list(activate), deactivate_controllers=list(deactivate),
            strictness=strictness, activate_asap=asap, timeout=duration_from_seconds(timeout))
        return self._call('switch_controller', SwitchController, request)

    def load(self, name: str) -> bool:
        """Load a controller."""
        return self._named('load_controller', LoadController, name)

    def configure(self, name: str) -> bool:
        """Configure a controller."""
        return self._named('configure_controller', ConfigureController, name)

    def cleanup(self, name: str) -> bool:
        """Bring a controller back to unconfigured."""
        return self._named('cleanup_controller', CleanupController, name)

    def unload(self, name: str) -> bool:
        """Unload a controller."""
        return self._named('unload_controller', UnloadController, name)

    def _named(self, service: str, kind: type[Any], name: str) -> bool:
        return bool(self._call(service, kind, kind.Request(name=name)).ok)

    def _call(self, service: str, kind: type[Any], request: Any = None) -> Any:
        return self._client.call(f'{self._manager}/{service}', kind, request)
