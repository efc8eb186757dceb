# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controllers of every controller manager, and the safety of each arm, with their switches."""

from __future__ import annotations

import json
from typing import Any, Literal

from controller_manager_msgs.srv import ListControllers, SwitchController
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes import qos
from armsim_ros.nodes.web.page import Page, PanelCommand, Part, Session
from armsim_ros.nodes.web.parts.watch import WatchPart

_PERIOD = 0.5


class Switch(PanelCommand):
    """Activate a controller, or deactivate it."""

    manager: str
    name: str
    active: bool


class ControllersPart(Part):
    """Shows the controllers that the managers list."""

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


_SAFETY_PERIOD = 0.2
_STOP, _CLEAR = 'protective_stop', 'clear_stop'


class ArmCommand(PanelCommand):
    """Stop an arm, or clear its stop."""

    arm: str
    what: Literal['stop', 'clear']


class SafetyPart(Part):
    """Shows the state of each arm that publishes ``safety``."""

    def __init__(self, page: Page, watch: WatchPart) -> None:
        super().__init__(page)
        self._watch = watch
        self._topics: dict[str, Any] = {}
        self._states: dict[str, dict[str, Any]] = {}

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {'safety': (ArmCommand, self._command)}

    async def run(self) -> None:
        """Publish the states as they come."""
        while True:
            arms = {name.removesuffix(_STOP) for name, kind in self._watch.services.items()
                    if name.endswith(f'/{_STOP}') and kind == 'std_srvs/srv/SetBool'}
            for arm in arms - set(self._topics):
                self._topics[arm] = self.page.link.poll(String, f'{arm}safety', qos.DESCRIPTION)
                self.page.link.prepare(SetBool, f'{arm}{_STOP}')
                self.page.link.prepare(Trigger, f'{arm}{_CLEAR}')
            for arm in set(self._topics) - arms:
                self._topics.pop(arm).close()
                self._states.pop(arm, None)
            for arm, topic in self._topics.items():
                for message in topic.take():
                    self._states[arm] = json.loads(message.data)
            self.page.publish('safety', [
                {'arm': arm, **state} for arm, state in sorted(self._states.items())])
            await self._watch.rest(_SAFETY_PERIOD)

    async def _command(self, _session: Session, command: ArmCommand) -> None:
        if command.arm not in self._topics:
            raise ArmsimError(f"there is no arm '{command.arm}' that can be stopped")
        if command.what == 'stop':
            answer = await self.page.call(
                SetBool, f'{command.arm}{_STOP}', SetBool.Request(data=True))
        else:
            answer = await self.page.call(Trigger, f'{command.arm}{_CLEAR}')
        if not answer.success:
            raise ArmsimError(answer.message)
