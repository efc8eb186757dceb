# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controllers of every controller manager, and their switch."""

from __future__ import annotations

from typing import Any

from controller_manager_msgs.srv import ListControllers, SwitchController

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.web.page import Ask, Page, Part
from armsim_ros.nodes.web.parts.watch import WatchPart
from armsim_ros.nodes.web.visitor import Visitor

_PERIOD = 0.5


class Switch(Ask):
    """Activate a controller, or deactivate it."""

    manager: str
    name: str
    active: bool


class ControllersPart(Part):
    """
    Shows what the watch was told by the controller managers.

    :param watch: who asks them.
    """

    def __init__(self, page: Page, watch: WatchPart) -> None:
        super().__init__(page)
        self._watch = watch

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {'switch': (Switch, self._switch)}

    async def run(self) -> None:
        """Publish the controllers as they are."""
        while True:
            self._tell()
            await self._watch.rest(_PERIOD)

    def _tell(self) -> None:
        self.page.publish('controllers', [
            {'manager': manager, 'name': controller.name, 'type': controller.type,
             'state': controller.state,
             'joints': sorted({interface.rpartition('/')[0] for interface in (
                 *controller.required_command_interfaces, *controller.required_state_interfaces)})}
            for manager, controllers in self._watch.managers.items()
            for controller in controllers])

    async def _switch(self, _visitor: Visitor, ask: Switch) -> None:
        if ask.manager not in self._watch.managers:
            raise ArmsimError(f"there is no controller manager '{ask.manager}'")
        request = SwitchController.Request(strictness=SwitchController.Request.STRICT)
        if ask.active:
            request.activate_controllers = [ask.name]
        else:
            request.deactivate_controllers = [ask.name]
        answer = await self.page.call(
            SwitchController, f'{ask.manager}/switch_controller', request)
        listed = await self.page.call(ListControllers, f'{ask.manager}/list_controllers')
        self._watch.managers[ask.manager] = list(listed.controller)
        self._tell()
        if not answer.ok:
            reason = getattr(answer, 'message', '') or 'its log says why'
            raise ArmsimError(f"'{ask.name}' was not switched: {reason}")
