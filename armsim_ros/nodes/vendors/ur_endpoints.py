# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All endpoints of an arm of Universal Robots."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
import math
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from ur_dashboard_msgs.msg import RobotMode, SafetyMode
from ur_msgs.msg import Analog, Digital, IOStates, ToolDataMsg
from ur_msgs.srv import SetAnalogOutput, SetIO, SetPayload, SetSpeedSliderFraction

from armsim_ros.control.arm_state import ArmState, Program
from armsim_ros.control.controller import Controller
from armsim_ros.errors import SimulationError
from armsim_ros.nodes import qos
from armsim_ros.nodes.qos import WantedPublisher
from armsim_ros.nodes.vendors.endpoints import ArmNodes, Endpoints
from armsim_ros.nodes.vendors.ur_dashboard import (
    Dashboard,
    headless,
    robot_mode,
    safety_mode,
    StateHelper,
)
from armsim_ros.nodes.vendors.ur_urscript import UrScript

DIGITAL_PINS, ANALOG_PINS = 18, 2
TOOL_VOLTAGES = (0, 12, 24)
#: Of a payload, in the order of the driver; older ``ur_msgs`` have none.
INERTIA = ('ixx', 'iyy', 'izz', 'ixy', 'ixz', 'iyz')
#: Begin of the parameters that set inputs.
INPUT = 'io.'


class IoAndStatus:
    """Topics and services of a ``ur_controllers/GPIOController``."""

    def __init__(self, nodes: ArmNodes, controller: Controller[Any], node: Node) -> None:
        self._nodes, self._arm, self._controller = nodes, nodes.arm, controller
        self._logger = node.get_logger()
        self._headless = headless(nodes.robot.model.urdf)
        self._states = WantedPublisher(node, IOStates, '~/io_states', qos.STATE)
        self._tool = WantedPublisher(node, ToolDataMsg, '~/tool_data', qos.STATE)
        self._latched = [
            (node.create_publisher(kind, f'~/{name}', qos.LATCHED), read)
            for kind, name, read in (
                (RobotMode, 'robot_mode', robot_mode), (SafetyMode, 'safety_mode', safety_mode),
                (Bool, 'robot_program_running', _program_running))]
        self._published: list[Any] = [None] * len(self._latched)
        services: tuple[tuple[Any, str, Callable[[Any], str]], ...] = (
            (SetIO, 'set_io', self._set_io),
            (SetAnalogOutput, 'set_analog_output', self._set_analog_output),
            (SetSpeedSliderFraction, 'set_speed_slider',
             lambda request: self._arm.set_slider(request.speed_slider_fraction)),
            (SetPayload, 'set_payload', self._set_payload),
            (Trigger, 'resend_robot_program', self._resend_robot_program),
            (Trigger, 'hand_back_control', self._hand_back_control),
            (Trigger, 'zero_ftsensor', self._zero_ftsensor))
        for kind, name, function in services:
            nodes.service(node, kind, f'~/{name}', partial(self._answer, function))
        for pin in range(DIGITAL_PINS):
            node.declare_parameter(f'{INPUT}digital_in_{pin}', False)
        for pin in range(ANALOG_PINS):
            node.declare_parameter(f'{INPUT}analog_in_{pin}', 0.0)
        node.add_post_set_parameters_callback(self._set_inputs)

    def publish(self, time_ns: int) -> None:
        """Publish inputs and outputs while the controller is active, and modes that changed."""
        if not self._controller.active:
            return
        for i, (publisher, read) in enumerate(self._latched):
            message = read(self._arm)
            if message != self._published[i]:
                self._published[i] = message
                publisher.publish(message)
        if self._states.wanted(time_ns):
            self._states.publish(self._io_states(), time_ns)
        if self._tool.wanted(time_ns):
            signals = self._arm.signals
            self._tool.publish(ToolDataMsg(
                tool_mode=ToolDataMsg.TOOL_RUNNING_MODE,
                tool_output_voltage=int(signals.get('tool_voltage')),
                analog_input2=signals.get('tool_analog_in_0'),
                analog_input3=signals.get('tool_analog_in_1')), time_ns)

    def _set_inputs(self, parameters: Sequence[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name.startswith(INPUT):
                self._nodes.loop.call(partial(
                    self._arm.signals.set, parameter.name.removeprefix(INPUT),
                    float(parameter.value)))

    def _io_states(self) -> IOStates:
        get = self._arm.signals.get
        digital = {side: [Digital(pin=pin, state=get(f'digital_{side}_{pin}') > 0.0)
                          for pin in range(DIGITAL_PINS)] for side in ('in', 'out')}
        analog = {side: [Analog(pin=pin, state=get(f'analog_{side}_{pin}'),
                                domain=int(get(f'analog_{side}_domain_{pin}')))
                         for pin in range(ANALOG_PINS)] for side in ('in', 'out')}
        return IOStates(
            digital_in_states=digital['in'], digital_out_states=digital['out'],
            analog_in_states=analog['in'], analog_out_states=analog['out'])

    def _answer(self, function: Callable[[Any], str], request: Any, response: Any) -> None:
        refusal = function(request) if self._controller.active else (
            'the controller is not active')
        response.success = not refusal
        if hasattr(response, 'message'):
            response.message = refusal
        if refusal:
            self._logger.error(refusal)

    def _set_io(self, request: SetIO.Request) -> str:
        signals, pin = self._arm.signals, request.pin
        if request.fun == SetIO.Request.FUN_SET_DIGITAL_OUT and 0 <= pin < DIGITAL_PINS:
            signals.set(f'digital_out_{pin}', float(request.state != 0.0))
        elif (request.fun == SetIO.Request.FUN_SET_ANALOG_OUT and 0 <= pin < ANALOG_PINS
                and 0.0 <= request.state <= 1.0):
            signals.set(f'analog_out_{pin}', request.state)
        elif (request.fun == SetIO.Request.FUN_SET_TOOL_VOLTAGE
                and request.state in TOOL_VOLTAGES):
            signals.set('tool_voltage', request.state)
        else:
            return (f'set_io: no function {request.fun} with pin {pin} and state '
                    f'{request.state:g}; allowed: 1 with pins 0 to 17, 3 with pins 0 and 1 '
                    'and 0 to 1, 4 with 0, 12 or 24')
        return ''

    def _set_analog_output(self, request: SetAnalogOutput.Request) -> str:
        data = request.data
        if data.pin >= ANALOG_PINS or data.domain not in (Analog.CURRENT, Analog.VOLTAGE):
            return f'no analog output {data.pin} with domain {data.domain}; allowed: 0 and 1'
        if not 0.0 <= data.state <= 1.0:
            return f'analog output {data.pin} cannot be at {data.state:g}; allowed: 0 to 1'
        self._arm.signals.set(f'analog_out_domain_{data.pin}', data.domain)
        self._arm.signals.set(f'analog_out_{data.pin}', data.state)
        return ''

    def _set_payload(self, request: SetPayload.Request) -> str:
        inertia = [getattr(request, name) for name in INERTIA if hasattr(request, name)]
        if not all(map(math.isfinite, inertia)):
            return f'set_payload: inertia {inertia} has a number that is not finite'
        centre = request.center_of_gravity
        return self._nodes.set_payload(request.mass, (centre.x, centre.y, centre.z))

    def _resend_robot_program(self, _: Any) -> str:
        if not self._headless:
            return ('the program can be sent only with headless_mode:=true; '
                    'call dashboard_client/play')
        return self._arm.play()

    def _hand_back_control(self, _: Any) -> str:
        self._arm.stop_program()
        return ''

    def _zero_ftsensor(self, _: Any) -> str:
        self._nodes.manager.hardware.tare()
        return ''


def _program_running(arm: ArmState) -> Bool:
    return Bool(data=arm.program is not Program.STOPPED)


class Freedrive:
    """The topic of a ``ur_controllers/FreedriveModeController``."""

    def __init__(self, nodes: ArmNodes, controller: Controller[Any], node: Node) -> None:
        self._nodes, self._controller = nodes, controller
        self._last_ns, self._began = 0, False
        receive: Any = self._receive  # an executor runs coroutines, too
        node.create_subscription(Bool, '~/enable_freedrive_mode', receive, 10)

    def publish(self, time_ns: int) -> None:
        """End its freedrive once nothing requests it in time, or the controller is inactive."""
        timeout_ns = self._controller.parameters.inactive_timeout * 1_000_000_000
        if not self._nodes.arm.freedrive:
            self._began = False
        elif self._began and not (
                self._controller.active and 0 <= time_ns - self._last_ns < timeout_ns):
            self._nodes.loop.call(lambda: self._nodes.arm.set_freedrive(False))

    async def _receive(self, message: Bool) -> None:
        arm = self._nodes.arm
        self._last_ns = self._nodes.time_ns
        if message.data == arm.freedrive or not self._controller.active:
            return
        if message.data and arm.obstacle:
            self._controller.events.warn(self._last_ns, f'no freedrive: {arm.obstacle}')
            return
        try:
            await self._nodes.change(lambda: arm.set_freedrive(message.data))
        except SimulationError:
            return
        self._began = message.data


class UniversalRobots(Endpoints):
    """Dashboard, state helper and URScript of an arm, and what its controllers offer."""

    def create(self) -> None:
        """Create the nodes that are programs of their own beside the real arm."""
        Dashboard(self.nodes)
        self._helper = StateHelper(self.nodes)
        UrScript(self.nodes)

    def open(self, controller: Controller[Any], node: Node) -> None:
        """Create what a controller of ``ur_controllers`` offers."""
        kind = controller.type.rpartition('/')[2]
        if kind == 'GPIOController':
            self.add(controller, IoAndStatus(self.nodes, controller, node))
        elif controller.frees_arm:
            self.add(controller, Freedrive(self.nodes, controller, node))

    def publish(self, time_ns: int) -> None:
        """Publish states, and end a freedrive that nothing keeps alive."""
        super().publish(time_ns)
        self.nodes.check_waiting()

    @property
    def pending(self) -> int:
        """Goals of ``set_mode`` without a result."""
        return self._helper.pending
