# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The base of a vendor's endpoints, and what they get to work with.

A vendor's table names ``module:function``; the function gets an :class:`ArmNodes` and returns
:class:`Endpoints`. What changes the arm runs between two ticks of the control loop.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import import_module
import math
from traceback import format_exception
from typing import Any, Protocol

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from armsim_ros.control.arm_state import ArmState
from armsim_ros.control.controller import Controller, LifecycleState
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.errors import SimulationError
from armsim_ros.model.cell import Robot
from armsim_ros.nodes.simulation.dispatcher import Dispatcher, wake
from armsim_ros.nodes.simulation.world.answers import Work
from armsim_ros.sim.control_loop import ControlLoop

#: The names of the field for a text in the answer of a service.
_TEXTS = ('message', 'answer', 'error')


class ArmNodes:
    """
    An arm, and what is needed to give it endpoints.

    :param new_node: makes a further node in that namespace.
    """

    def __init__(
        self, robot: Robot, manager: ControllerManager, loop: ControlLoop, dispatcher: Dispatcher,
        node: Node, new_node: Callable[[str], Node]
    ) -> None:
        self.robot, self.manager, self.loop, self.node = robot, manager, loop, node
        self.new_node, self.dispatcher = new_node, dispatcher
        self._work = Work(node, loop, dispatcher)
        self._group = ReentrantCallbackGroup()
        self._waiting: list[tuple[Callable[[], bool], Future]] = []
        #: Why the program ends, '' while it runs.
        self.ending = ''

    @property
    def arm(self) -> ArmState:
        """The state of drives and safety."""
        return self.manager.arm

    @property
    def time_ns(self) -> int:
        """Simulated time [ns]."""
        return self.loop.clock.now_ns

    async def change(self, function: Callable[[], Any]) -> Any:
        """
        Return the result of a function that may change the arm; controllers have followed then.

        :raises SimulationError: the simulation ends.
        """
        def call() -> Any:
            self.arm.time_ns = self.time_ns
            result = function()
            if self.arm.changed:
                self.manager.stops.follow(self.time_ns)
            return result
        return await self._work.in_loop(call)

    def service(self, node: Node, kind: Any, name: str,
                answer: Callable[[Any, Any], object]) -> None:
        """
        Create a service; whatever fails is answered, since clients wait for ever otherwise.

        :param answer: fills the response to a request; may change the arm.
        """
        async def handle(request: Any, response: Any) -> Any:
            try:
                await self.change(lambda: answer(request, response))
            except SimulationError as error:
                _fail(response, str(error))
            except Exception as error:  # noqa: BLE001 - logged, and answered to the client
                node.get_logger().error(f'{name}: {"".join(format_exception(error))}')
                _fail(response, f'{type(error).__name__}: {error}')
            return response
        node.create_service(kind, name, handle, callback_group=self._group)

    def trigger(
        self, node: Node, name: str, function: Callable[[], str | None], done: str = ''
    ) -> None:
        """
        Create a ``std_srvs/Trigger``.

        :param function: returns why it is refused; '' or None where it is not.
        :param done: the message of a success; '' for the arm's state.
        """
        def answer(_: Any, response: Any) -> None:
            refusal = function()
            arm = self.arm
            response.success = not refusal
            response.message = refusal or done or f'{arm.mode.value}, {arm.safety.value}'
        self.service(node, Trigger, name, answer)

    def set_payload(self, mass: float, centre: Sequence[float]) -> str:
        """Have the drives compensate a load at the vendor's tool; return why that fails."""
        tool = self.arm.vendor.tool
        link = next((name for name in self.robot.model.links if name.endswith(tool)), '')
        if not link or mass < 0.0 or not all(map(math.isfinite, (mass, *centre))):
            return (f"no payload of {mass:g} kg with centre {[*centre]} at link '{tool}'; "
                    'allowed: finite numbers, 0 kg or more')
        self.manager.hardware.set_payload(link, mass, centre)
        return ''

    async def until(self, condition: Callable[[], bool]) -> None:
        """Return once a condition holds, or the program ends; it is checked as time goes on."""
        done = Future()
        self._waiting.append((condition, done))
        await done

    def once_active(self, controller: Controller[Any], node: Node,
                    create: Callable[[], object]) -> None:
        """Have services created at the first activation of a controller, as drivers do."""
        async def offer() -> None:
            await self.until(lambda: controller.active)
            if not self.ending:
                with suppress(InvalidHandle):  # the controller was unloaded meanwhile
                    create()
        assert node.executor is not None
        node.executor.create_task(offer())

    def check_waiting(self) -> None:
        """Resume coroutines whose condition holds; in the publishing thread."""
        for entry in list(self._waiting):
            condition, done = entry
            if self.ending or condition():
                self._waiting.remove(entry)
                done.set_result(None)
                wake(self.node)

    def end(self, sentence: str) -> None:
        """Resume all coroutines; from any thread."""
        self.ending = sentence
        self.dispatcher.post(self.check_waiting)


class ControllerEndpoints(Protocol):
    """The endpoints of a controller that publish at the rate of /clock."""

    def publish(self, time_ns: int) -> None:
        """Publish what is due [ns]."""


class Endpoints:
    """The endpoints of an arm without a vendor: none."""

    def __init__(self, nodes: ArmNodes) -> None:
        self.nodes = nodes
        self._of_controllers: list[tuple[Controller[Any], ControllerEndpoints]] = []

    def create(self) -> None:
        """Create those that belong to no controller."""

    def open(self, controller: Controller[Any], node: Node) -> None:
        """Create those of a controller that has been configured; in the executor's thread."""

    def add(self, controller: Controller[Any], endpoints: ControllerEndpoints) -> None:
        """Have a controller's endpoints publish until the controller is unloaded."""
        self._of_controllers.append((controller, endpoints))

    def publish(self, time_ns: int) -> None:
        """Publish what is due at the rate of /clock; also while time is paused [ns]."""
        unloaded = [entry for entry in self._of_controllers
                    if entry[0].state is LifecycleState.FINALIZED]
        for _, endpoints in tuple(self._of_controllers):
            endpoints.publish(time_ns)
        for entry in unloaded:
            self._of_controllers.remove(entry)

    @property
    def pending(self) -> int:
        """Goals without a result."""
        return 0

    def end(self, sentence: str) -> None:
        """Abort running goals, with the reason; only from the executor's thread."""


def endpoints_of(nodes: ArmNodes) -> Endpoints:
    """Return the endpoints of the arm's vendor; those whose messages are missing are left out."""
    place = nodes.arm.vendor.endpoints
    if not place:
        return Endpoints(nodes)
    module, _, function = place.partition(':')
    try:
        made: Endpoints = getattr(import_module(module), function)(nodes)
    except ImportError as error:
        nodes.node.get_logger().warning(
            f"the endpoints of vendor '{nodes.arm.vendor.name}' are left out: {error}")
        return Endpoints(nodes)
    return made


def _fail(response: Any, text: str) -> None:
    for field in ('success', *_TEXTS):
        if hasattr(response, field):
            setattr(response, field, False if field == 'success' else text)
