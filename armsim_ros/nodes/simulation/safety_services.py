# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services that stop an arm, clear a stop and switch its drives; and the topic ``safety``."""

from __future__ import annotations

from collections.abc import Callable
import json
from typing import Any

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.control.safety.arm_state import ArmState, Mode
from armsim_ros.errors import SimulationError
from armsim_ros.nodes import qos
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.world.work import Work
from armsim_ros.sim.control_loop import ControlLoop


class SafetyServices:
    """
    The state of an arm's drives and safety, in the robot's namespace.

    :param node: a node in that namespace.
    :param manager: whose arm it is.
    """

    def __init__(
        self, node: Node, manager: ControllerManager, loop: ControlLoop, dispatcher: Dispatcher
    ) -> None:
        self._arm: ArmState = manager.arm
        self._clock = loop.clock
        self._work = Work(node, loop, dispatcher)
        self._published = -1
        self._topic = node.create_publisher(String, 'safety', qos.LATCHED)
        group = ReentrantCallbackGroup()
        arm = self._arm
        pressed: dict[str, tuple[Callable[[], Any], Callable[[], Any]]] = {
            'protective_stop': (arm.protective_stop, arm.clear_stop),
            'emergency_stop': (arm.emergency_stop, arm.release_emergency_stop),
        }
        for name, (press, release) in pressed.items():
            node.create_service(SetBool, name, self._switch(press, release),
                                callback_group=group)
        triggers: dict[str, Callable[[], Any]] = {
            'clear_stop': arm.clear_stop,
            'power_on': lambda: arm.power_to(Mode.RUNNING),
            'power_off': lambda: arm.power_to(Mode.POWER_OFF),
        }
        for name, function in triggers.items():
            node.create_service(Trigger, name, self._trigger(function), callback_group=group)
        self.publish_if_changed()

    def publish_if_changed(self) -> None:
        """Publish the state if it is another than before."""
        arm = self._arm
        if arm.generation == self._published:
            return
        self._published = arm.generation
        state = {'mode': arm.mode.value, 'safety': arm.safety.value,
                 'cause': '' if arm.cause is None else str(arm.cause),
                 'since': arm.since_ns * 1e-9}
        self._topic.publish(String(data=json.dumps(state)))

    def _switch(self, press: Callable[[], Any], release: Callable[[], Any]) -> Any:
        async def answer(request: Any, response: Any) -> Any:
            return await self._answer(press if request.data else release, response)
        return answer

    def _trigger(self, function: Callable[[], Any]) -> Any:
        async def answer(_: Any, response: Any) -> Any:
            return await self._answer(function, response)
        return answer

    async def _answer(self, function: Callable[[], Any], response: Any) -> Any:
        """Have the loop call it; a text that it returns is why it was refused."""
        try:
            refusal = await self._work.in_loop(lambda: self._call(function))
        except SimulationError as error:
            refusal = str(error)
        response.success = not refusal
        response.message = refusal or f'{self._arm.mode.value}, {self._arm.safety.value}'
        return response

    def _call(self, function: Callable[[], Any]) -> str:
        self._arm.time_ns = self._clock.now_ns
        return function() or ''
