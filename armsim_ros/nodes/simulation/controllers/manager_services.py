# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services of the controller manager: list, load, switch and unload controllers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
import traceback
from typing import Any

from controller_manager_msgs.srv import (
    CleanupController,
    ConfigureController,
    ListControllers,
    ListControllerTypes,
    ListHardwareComponents,
    ListHardwareInterfaces,
    LoadController,
    ReloadControllerLibraries,
    SetHardwareComponentState,
    SwitchController,
    UnloadController,
)
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future

from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.control.manager.switching import Strictness
from armsim_ros.errors import ArmsimError, ControllerError
from armsim_ros.nodes.conversions.controller_manager import (
    component_message,
    controller_message,
    interface_messages,
    state_label,
    state_message,
)
from armsim_ros.nodes.conversions.time import seconds_from_duration
from armsim_ros.nodes.simulation.controllers.registry import ControllerRegistry
from armsim_ros.nodes.simulation.dispatcher import Dispatcher, wake

#: Whether a type is chainable -> its base class in ros2_control.
BASE_CLASSES = {False: 'controller_interface::ControllerInterface',
                True: 'controller_interface::ChainableControllerInterface'}


class ControllerManagerQueries:
    """
    ``list_controllers``, ``list_controller_types``, ``list_hardware_*`` and hardware states.

    :param update_rate: [Hz] of the manager.
    """

    def __init__(self, node: Node, manager: ControllerManager, update_rate: float) -> None:
        self._node, self._manager, self._update_rate = node, manager, update_rate
        for name, kind, answer in (
            ('list_controllers', ListControllers, self._list_controllers),
            ('list_controller_types', ListControllerTypes, self._list_types),
            ('list_hardware_components', ListHardwareComponents, self._list_components),
            ('list_hardware_interfaces', ListHardwareInterfaces, self._list_interfaces),
            (
                'set_hardware_component_state', SetHardwareComponentState,
                self._set_component_state),
        ):
            node.create_service(kind, f'~/{name}', answer)

    def _list_controllers(self, _: Any, response: Any) -> Any:
        response.controller = [
            controller_message(info) for info in self._manager.list_controllers()]
        return response

    def _list_types(self, _: Any, response: Any) -> Any:
        types = self._manager.list_types()
        response.types = list(types)
        response.base_classes = [BASE_CLASSES[chainable] for chainable in types.values()]
        return response

    def _list_components(self, _: Any, response: Any) -> Any:
        response.component = [
            component_message(info, self._update_rate)
            for info in self._manager.list_hardware_components()]
        return response

    def _list_interfaces(self, _: Any, response: Any) -> Any:
        command, state = self._manager.list_hardware_interfaces()
        response.command_interfaces = interface_messages(command)
        response.state_interfaces = interface_messages(state)
        return response

    def _set_component_state(self, request: Any, response: Any) -> Any:
        try:
            self._manager.set_hardware_component_state(
                request.name, state_label(request.target_state))
            response.ok = True
        except ControllerError as error:
            self._node.get_logger().error(str(error))
        for info in self._manager.list_hardware_components():
            if info.name == request.name:
                response.state = state_message(info.state)
        return response


#: Timeout of a switch if the request gives none [s].
DEFAULT_SWITCH_TIMEOUT = 1.0


class ControllerManagerServices:
    """
    ``load_controller`` to ``unload_controller``, ``switch_controller``.

    A switch is done by the control loop; its service waits as a coroutine, so that other
    services and the actions go on meanwhile.
    """

    def __init__(
        self, node: Node, manager: ControllerManager, loader: ControllerRegistry,
        dispatcher: Dispatcher
    ) -> None:
        self._node, self._manager, self._loader = node, manager, loader
        self._dispatcher = dispatcher
        self._create('load_controller', LoadController, self._named(loader.load))
        self._create('configure_controller', ConfigureController, self._named(loader.configure))
        self._create('cleanup_controller', CleanupController, self._named(manager.cleanup))
        self._create('unload_controller', UnloadController, self._named(loader.unload))
        waiting = ReentrantCallbackGroup()
        self._create(
            'reload_controller_libraries', ReloadControllerLibraries, self._reload, waiting)
        self._create('switch_controller', SwitchController, self._switch, waiting)

    def _create(self, name: str, kind: type[Any], answer: Any, group: Any = None) -> None:
        self._node.create_service(kind, f'~/{name}', answer, callback_group=group)

    def _named(self, work: Callable[[str], object]) -> Callable[[Any, Any], Any]:
        def answer(request: Any, response: Any) -> Any:
            response.ok = self._try(lambda: work(request.name))
            return response

        return answer

    def _try(self, work: Callable[[], object]) -> bool:
        try:
            work()
        except ArmsimError as error:
            self._node.get_logger().error(str(error))
            return False
        except Exception:  # noqa: BLE001 - the caller always gets an answer
            self._node.get_logger().error(
                'a request failed inside the program; please report this:\n'
                + traceback.format_exc())
            return False
        return True

    async def _reload(self, request: Any, response: Any) -> Any:
        active = [info.name for info in self._manager.list_controllers() if info.state == 'active']
        if active and not request.force_kill:
            self._node.get_logger().error(
                f'controllers are active ({", ".join(active)}); deactivate them first, or set '
                'force_kill')
            return response
        switched, _ = await self._switched((), active, Strictness.STRICT, DEFAULT_SWITCH_TIMEOUT)
        names = [info.name for info in self._manager.list_controllers()]
        unloaded = [self._try(partial(self._loader.unload, name)) for name in names]
        response.ok = switched and all(unloaded)
        return response

    async def _switch(self, request: Any, response: Any) -> Any:
        timeout = seconds_from_duration(request.timeout)
        response.ok, response.message = await self._switched(
            request.activate_controllers, request.deactivate_controllers, request.strictness,
            timeout if timeout > 0.0 else DEFAULT_SWITCH_TIMEOUT)
        if not response.ok:
            self._node.get_logger().error(f'switch_controller: {response.message}')
        return response

    async def _switched(
        self, activate: Sequence[str], deactivate: Sequence[str], strictness: int, timeout: float
    ) -> tuple[bool, str]:
        """Return whether the loop has switched within the timeout [s], and its message."""
        switch = self._manager.request_switch(tuple(activate), tuple(deactivate), strictness)
        done = Future()

        def resume() -> None:
            if not done.done():
                done.set_result(None)
                wake(self._node)

        switch.add_done_callback(lambda _: self._dispatcher.post(resume))
        self._dispatcher.post_later(timeout, resume)
        await done
        if not switch.done() and switch.cancel():
            return False, f'the control loop did not switch within {timeout:g} s; it is overloaded'
        result = switch.result()
        self._loader.open_due()
        return result.ok, result.message
