# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controllers of every controller manager, and their switch."""

from __future__ import annotations

from typing import Any

from controller_manager_msgs.srv import ListControllers, SwitchController

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.web.page import Page, PanelCommand, Part
from armsim_ros.nodes.web.parts.watch import WatchPart
from armsim_ros.nodes.web.session import Session

_PERIOD = 0.5


class Switch(PanelCommand):
    """Activate a controller, or deactivate it."""

    manager: str
    name: str
    active: bool


class ControllersPart(Part):
    """
    Shows the controllers that the managers list.

    :param watch: queries them.
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
            self._publish()
            await self._watch.rest(_PERIOD)

    def _publish(self) -> None:
        self.page.publish('controllers', [
            {'manager': manager, 'name': controller.name, 'type': controller.type,
             'state': controller.state,
             'joints': sorted({interface.rpartition('/')[0] for interface in (
                 *controller.required_command_interfaces, *controller.required_state_interfaces)})}
            for manager, controllers in self._watch.managers.items()
            for controller in controllers])

    async def _switch(self, _session: Session, command: Switch) -> None:
        if command.manager not in self._watch.managers:
            raise ArmsimError(f"there is no controller manager '{command.manager}'")
        request = SwitchController.Request(strictness=SwitchController.Request.STRICT)
        if command.active:
            request.activate_controllers = [command.name]
        else:
            request.deactivate_controllers = [command.name]
        answer = await self.page.call(
            SwitchController, f'{command.manager}/switch_controller', request)
        listed = await self.page.call(ListControllers, f'{command.manager}/list_controllers')
        self._watch.managers[command.manager] = list(listed.controller)
        self._publish()
        if not answer.ok:
            reason = getattr(answer, 'message', '') or 'its log has the reason'
            raise ArmsimError(f"'{command.name}' was not switched: {reason}")
