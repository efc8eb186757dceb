# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Calls the services of a controller manager from a program that has nothing else to do."""

from __future__ import annotations

from collections.abc import Sequence
import math
import time
from typing import Any

from controller_manager_msgs.srv import (
    CleanupController,
    ConfigureController,
    ListControllers,
    ListHardwareComponents,
    LoadController,
    SetHardwareComponentState,
    SwitchController,
    UnloadController,
)
from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import Parameter

from armsim_ros.errors import ControllerError
from armsim_ros.nodes.conversions.controller_manager import state_message
from armsim_ros.nodes.conversions.time import duration_from_seconds

#: How often a call is made that is not answered.
TRIES = 3
#: Period at which a service is waited for [s]; that of rclpy is a quarter of a second.
_LOOK = 0.02
#: A manager is discovered in this time; only a longer wait is reported [s].
_SILENT_WAIT = 1.0


class ManagerClient:
    """
    A manager by its name.

    :param node: the program's node; nothing else may spin it.
    :param manager: the manager's name, absolute or relative to the namespace.
    :param call_timeout: [s] for an answer.
    :param namespace: '' is that of the node.
    """

    def __init__(
        self, node: Node, manager: str, call_timeout: float, namespace: str = ''
    ) -> None:
        self._node = node
        self._call_timeout = call_timeout
        namespace = (namespace or node.get_namespace()).rstrip('/')
        self.name = manager if manager.startswith('/') else f'{namespace}/{manager}'

    @property
    def namespace(self) -> str:
        """The namespace of the manager and of its controllers, such as ``/sunday``."""
        return self.name.rpartition('/')[0] or '/'

    def wait(self, timeout: float) -> None:
        """
        Wait until the manager answers.

        :param timeout: [s]; 0 waits for ever.
        :raises ControllerError: it does not appear in time.
        """
        client = self._node.create_client(ListControllers, f'{self.name}/list_controllers')
        limit = timeout or math.inf
        if self._appears(client, min(limit, _SILENT_WAIT)):
            return
        self._node.get_logger().info(f'waiting for {self.name} to become available')
        if not self._appears(client, limit - _SILENT_WAIT):
            raise ControllerError(
                f'no controller manager answers as {self.name} within {timeout:g} s; start the '
                "simulation, or name the manager with '-c'"
            )

    def states(self) -> dict[str, str]:
        """Return controller -> lifecycle state."""
        response = self._call('list_controllers', ListControllers, ListControllers.Request())
        return {state.name: state.state for state in response.controller}

    def hardware_states(self) -> dict[str, str]:
        """Return hardware component -> lifecycle state."""
        response = self._call('list_hardware_components', ListHardwareComponents,
                              ListHardwareComponents.Request())
        return {component.name: component.state.label for component in response.component}

    def set_hardware_state(self, name: str, state: str) -> str:
        """Bring a hardware component into a state; return the state that it has then."""
        request = SetHardwareComponentState.Request(name=name, target_state=state_message(state))
        response = self._call('set_hardware_component_state', SetHardwareComponentState, request)
        return str(response.state.label)

    def set_parameters(self, values: dict[str, Any]) -> None:
        """Set parameters of the manager; ControllerError if any is refused."""
        parameters = [Parameter(key, value=value) for key, value in values.items()]
        request = SetParameters.Request(
            parameters=[parameter.to_parameter_msg() for parameter in parameters]
        )
        response = self._call('set_parameters', SetParameters, request)
        for parameter, result in zip(parameters, response.results, strict=True):
            if not result.successful:
                raise ControllerError(f"parameter '{parameter.name}': {result.reason}")

    def load(self, name: str) -> None:
        """Load a controller; ControllerError where the manager refuses, as for all that follow."""
        self._do('load_controller', LoadController, name, 'loaded')

    def configure(self, name: str) -> None:
        """Configure a controller."""
        self._do('configure_controller', ConfigureController, name, 'configured')

    def cleanup(self, name: str) -> None:
        """Bring a configured controller back to unconfigured."""
        self._do('cleanup_controller', CleanupController, name, 'cleaned up')

    def unload(self, name: str) -> None:
        """Unload a controller."""
        self._do('unload_controller', UnloadController, name, 'unloaded')

    def switch(
        self,
        *,
        activate: Sequence[str] = (),
        deactivate: Sequence[str] = (),
        asap: bool = True,
        timeout: float = 5.0,
        strictness: int = SwitchController.Request.STRICT,
    ) -> None:
        """Switch controllers; strictly, all or none."""
        request = SwitchController.Request(
            activate_controllers=list(activate),
            deactivate_controllers=list(deactivate),
            strictness=strictness,
            activate_asap=asap,
            timeout=duration_from_seconds(timeout),
        )
        response = self._call('switch_controller', SwitchController, request)
        if not response.ok:
            names = ', '.join([*activate, *deactivate])
            reason = response.message or 'the manager refuses to switch'
            raise ControllerError(f'{names}: {reason}')

    def _appears(self, client: Client, timeout: float) -> bool:
        """Return whether a service is there within a time [s]."""
        deadline = time.monotonic() + timeout
        while not client.service_is_ready():
            if time.monotonic() > deadline or not self._node.context.ok():
                return False
            time.sleep(_LOOK)
        return True

    def _do(self, service: str, kind: type[Any], name: str, done: str) -> None:
        if not self._call(service, kind, kind.Request(name=name)).ok:
            raise ControllerError(f"'{name}' could not be {done}; see the manager's log")

    def _call(self, service: str, kind: type[Any], request: Any) -> Any:
        client = self._node.create_client(kind, f'{self.name}/{service}')
        try:
            for _ in range(TRIES):
                deadline = time.monotonic() + self._call_timeout
                if not self._appears(client, self._call_timeout):
                    continue
                future = client.call_async(request)
                rclpy.spin_until_future_complete(
                    self._node, future, timeout_sec=max(0.0, deadline - time.monotonic())
                )
                if future.done():
                    return future.result()
                client.remove_pending_request(future)
        finally:
            self._node.destroy_client(client)
        raise ControllerError(
            f'{self.name}/{service} did not answer {TRIES} times within {self._call_timeout:g} s'
        )
