# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Modes of the arm: the vendor's ``dashboard_client`` and ``ur_robot_state_helper/set_mode``."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any
from xml.etree import ElementTree

from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from ur_dashboard_msgs.action import SetMode
from ur_dashboard_msgs.msg import (
    ProgramState,
    RobotMode,
    SafetyMode,
    SafetyStatus,
    VersionInformation,
)
from ur_dashboard_msgs.srv import (
    AddToLog,
    GetLoadedProgram,
    GetPolyScopeVersion,
    GetProgramState,
    GetRobotMode,
    GetRobotModel,
    GetSafetyMode,
    GetSafetyStatus,
    GetSerialNumber,
    IsInRemoteControl,
    IsProgramRunning,
    IsProgramSaved,
    Load,
    Popup,
    RawRequest,
)

from armsim_ros.control.arm_state import ArmState, Mode, Program, Safety
from armsim_ros.errors import SimulationError
from armsim_ros.nodes import qos
from armsim_ros.nodes.vendors.endpoints import ArmNodes

MODES: dict[Mode, int] = {
    Mode.POWER_OFF: RobotMode.POWER_OFF, Mode.POWER_ON: RobotMode.POWER_ON,
    Mode.IDLE: RobotMode.IDLE, Mode.RUNNING: RobotMode.RUNNING}
SAFETIES: dict[Safety, tuple[int, str]] = {
    Safety.NORMAL: (SafetyMode.NORMAL, 'NORMAL'),
    Safety.REDUCED: (SafetyMode.REDUCED, 'REDUCED'),
    Safety.PROTECTIVE_STOP: (SafetyMode.PROTECTIVE_STOP, 'PROTECTIVE_STOP'),
    Safety.SAFEGUARD_STOP: (SafetyMode.SAFEGUARD_STOP, 'SAFEGUARD_STOP'),
    Safety.EMERGENCY_STOP: (SafetyMode.ROBOT_EMERGENCY_STOP, 'ROBOT_EMERGENCY_STOP'),
    Safety.FAULT: (SafetyMode.FAULT, 'FAULT'),
}


def robot_mode(arm: ArmState) -> RobotMode:
    """Return the mode of the drives."""
    return RobotMode(mode=MODES[arm.mode])


def safety_mode(arm: ArmState) -> SafetyMode:
    """Return the mode of the safety system."""
    return SafetyMode(mode=SAFETIES[arm.safety][0])


def headless(urdf: str) -> bool:
    """Return whether ``<ros2_control>`` has the driver start its program by itself."""
    root = ElementTree.fromstring(urdf)
    return any((param.text or '').strip().lower() == 'true'
               for param in root.iterfind('ros2_control//param[@name="headless_mode"]'))


VERSION = (5, 21, 0, 0)
SERIAL_NUMBER = 20215500001
WAIT = ('Cannot unlock protective stop until 5s after occurrence. Always inspect cause of '
        'protective stop before unlocking')


class Dashboard:
    """The node ``dashboard_client``; its services answer as the dashboard server does."""

    def __init__(self, nodes: ArmNodes) -> None:
        self._arm = nodes.arm
        model = nodes.robot.model.name
        self._program, self._installation = 'external_control.urp', 'default.installation'
        node = nodes.new_node('dashboard_client')
        self._logger = node.get_logger()
        #: Command of the server -> service, what it does, and its answer.
        self._commands: dict[str, tuple[str, Callable[[], str], str]] = {
            'power on': ('power_on', partial(self._power, Mode.IDLE), 'Powering on'),
            'power off': ('power_off', partial(self._power, Mode.POWER_OFF), 'Powering off'),
            'brake release': (
                'brake_release', partial(self._power, Mode.RUNNING), 'Brake releasing'),
            'play': ('play', self._arm.play, 'Starting program'),
            'pause': ('pause', self._arm.pause, 'Pausing program'),
            'resume': ('resume', self._arm.play, 'Resuming program'),
            'stop': ('stop', _done(self._arm.stop_program), 'Stopped'),
            'unlock protective stop': ('unlock_protective_stop', self._unlock,
                                       'Protective stop releasing'),
            'restart safety': ('restart_safety', self._restart_safety, 'Restarting safety'),
            'close popup': ('close_popup', _nothing, 'closing popup'),
            'close safety popup': ('close_safety_popup', _nothing, 'closing safety popup'),
            'clear operational mode': (
                'clear_operational_mode', _nothing,
                'No longer controlling the operational mode. Current operational mode: '
                "'AUTOMATIC'."),
            'quit': ('quit', _nothing, 'Disconnected'),
            'shutdown': ('shutdown', partial(self._power, Mode.POWER_OFF), 'Shutting down'),
        }
        for name, function, done in self._commands.values():
            nodes.trigger(node, f'~/{name}', function, done)
        nodes.trigger(node, '~/connect', _nothing, 'Connected')
        #: Query of the server -> service, its name, the answer, and the fields of the response.
        queries: dict[str, tuple[Any, str, Callable[[], str], Callable[[], dict[str, Any]]]] = {
            'robotmode': (
                GetRobotMode, 'get_robot_mode', lambda: f'Robotmode: {self._arm.mode.value}',
                lambda: {'robot_mode': robot_mode(self._arm)}),
            'safetymode': (
                GetSafetyMode, 'get_safety_mode', lambda: f'Safetymode: {self._safety[1]}',
                lambda: {'safety_mode': safety_mode(self._arm)}),
            'safetystatus': (
                GetSafetyStatus, 'get_safety_status', lambda: f'Safetystatus: {self._safety[1]}',
                lambda: {'safety_status': SafetyStatus(status=self._safety[0])}),
            'running': (
                IsProgramRunning, 'program_running',
                lambda: f'Program running: {str(self._runs).lower()}',
                lambda: {'program_running': self._runs}),
            'programState': (
                GetProgramState, 'program_state',
                lambda: f'{self._arm.program.value} {self._program}',
                lambda: {'state': ProgramState(state=self._arm.program.value),
                         'program_name': self._program}),
            'get loaded program': (
                GetLoadedProgram, 'get_loaded_program',
                lambda: f'Loaded program: /programs/{self._program}',
                lambda: {'program_name': f'/programs/{self._program}'}),
            'isProgramSaved': (
                IsProgramSaved, 'program_saved', lambda: f'true {self._program}',
                lambda: {'program_saved': True, 'program_name': self._program}),
            'is in remote control': (
                IsInRemoteControl, 'is_in_remote_control', lambda: 'true',
                lambda: {'remote_control': True}),
            'PolyscopeVersion': (
                GetPolyScopeVersion, 'get_polyscope_version',
                lambda: 'URSoftware ' + '.'.join(map(str, VERSION)),
                lambda: {'version': VersionInformation(
                    major=VERSION[0], minor=VERSION[1], bugfix=VERSION[2], build=VERSION[3])}),
            'get robot model': (
                GetRobotModel, 'get_robot_model', model.upper,
                lambda: {'robot_model': model.upper()}),
            'get serial number': (
                GetSerialNumber, 'get_serial_number', lambda: str(SERIAL_NUMBER),
                lambda: {'serial_number': SERIAL_NUMBER}),
        }
        self._texts = {query: text for query, (_, _, text, _) in queries.items()}
        for kind, name, text, fields in queries.values():
            nodes.service(node, kind, f'~/{name}', partial(_answer, text, fields))
        nodes.service(node, Load, '~/load_program', self._load_program)
        nodes.service(node, Load, '~/load_installation', self._load_installation)
        nodes.service(node, Popup, '~/popup', self._popup)
        nodes.service(node, AddToLog, '~/add_to_log', self._add_to_log)
        nodes.service(node, RawRequest, '~/raw_request', self._raw_request)

    @property
    def _safety(self) -> tuple[int, str]:
        """Number and name of the safety mode."""
        return SAFETIES[self._arm.safety]

    @property
    def _runs(self) -> bool:
        return self._arm.program is Program.PLAYING

    def _power(self, mode: Mode) -> str:
        if self._arm.pressed and mode is not Mode.POWER_OFF:
            return 'the emergency stop is pressed; release it first'
        if mode is Mode.IDLE and self._arm.mode is Mode.RUNNING:
            return ''  # it has power already
        self._arm.power_to(mode)
        return ''

    def _unlock(self) -> str:
        arm = self._arm
        if arm.safety is not Safety.PROTECTIVE_STOP:
            return ''
        if arm.time_ns < arm.since_ns + arm.unlock_delay_ns:
            return WAIT
        return arm.clear_stop()

    def _restart_safety(self) -> str:
        arm = self._arm
        if arm.pressed:
            return 'the emergency stop is pressed; release it first'
        arm.power_to(Mode.POWER_OFF)
        return arm.clear_stop() if arm.safety is Safety.FAULT else ''

    def _load_program(self, request: Load.Request, response: Load.Response) -> None:
        response.success = request.filename.endswith('.urp')
        if not response.success:
            response.answer = f'File not found: {request.filename}'
            return
        self._arm.stop_program()
        self._program = request.filename.rpartition('/')[2]
        response.answer = f'Loading program: {request.filename}'

    def _load_installation(self, request: Load.Request, response: Load.Response) -> None:
        response.success = request.filename.endswith('.installation')
        response.answer = (f'Loading installation: {request.filename}' if response.success
                           else f'File not found: {request.filename}')
        if response.success:
            self._installation = request.filename

    def _popup(self, request: Popup.Request, response: Popup.Response) -> None:
        self._logger.info(f'popup: {request.message}')
        response.success, response.answer = True, 'showing popup'

    def _add_to_log(self, request: AddToLog.Request, response: AddToLog.Response) -> None:
        self._logger.info(request.message)
        response.success, response.answer = True, 'Added log message'

    def _raw_request(self, request: RawRequest.Request, response: RawRequest.Response) -> None:
        query = request.query.strip()
        if query in self._commands:
            _, function, done = self._commands[query]
            response.answer = function() or done
        elif query in self._texts:
            response.answer = self._texts[query]()
        else:
            response.answer = f"could not understand: '{query}'"


def _answer(
    text: Callable[[], str], fields: Callable[[], dict[str, Any]], _: Any, response: Any
) -> None:
    for name, value in {'success': True, 'answer': text(), **fields()}.items():
        setattr(response, name, value)


def _nothing() -> str:
    return ''


def _done(function: Callable[[], None]) -> Callable[[], str]:
    def call() -> str:
        function()
        return ''
    return call


TARGETS = {RobotMode.POWER_OFF: Mode.POWER_OFF, RobotMode.IDLE: Mode.IDLE,
           RobotMode.RUNNING: Mode.RUNNING}


class StateHelper:
    """The node ``ur_robot_state_helper``."""

    def __init__(self, nodes: ArmNodes) -> None:
        self._nodes = nodes
        self._arm = nodes.arm
        self.pending = 0
        node = nodes.new_node('ur_robot_state_helper')
        self._server = ActionServer(
            node, SetMode, '~/set_mode', self._execute,
            callback_group=ReentrantCallbackGroup(), **qos.ACTION_SERVICES)

    async def _execute(self, handle: ServerGoalHandle) -> Any:
        self.pending += 1
        try:
            refusal = await self._reach(handle)
        except SimulationError as error:
            refusal = str(error)
        finally:
            self.pending -= 1
        if refusal:
            handle.abort()
        else:
            handle.succeed()
        return SetMode.Result(success=not refusal, message=refusal or 'Reached target robot mode.')

    async def _reach(self, handle: ServerGoalHandle) -> str:
        """Bring the arm into the mode of a goal; return why it is not there."""
        goal, arm = handle.request, self._arm
        target = TARGETS.get(goal.target_robot_mode)
        if target is None:
            return (f'the mode {goal.target_robot_mode} cannot be chosen; allowed: '
                    f'{", ".join(map(str, TARGETS))}')
        refusal = str(await self._nodes.change(lambda: self._begin(target, goal.stop_program)))
        shown = (-1, -1)
        while not refusal and arm.mode is not target and not self._nodes.ending:
            now = robot_mode(arm).mode, safety_mode(arm).mode
            if now != shown:
                shown = now
                handle.publish_feedback(SetMode.Feedback(
                    current_robot_mode=now[0], current_safety_mode=now[1]))
            await self._change_of_state()
            if arm.safety not in (Safety.NORMAL, Safety.REDUCED):
                refusal = f'the arm did not reach mode {MODES[target]}: {arm.obstacle}'
        if not refusal and target is Mode.RUNNING and goal.play_program:
            refusal = str(await self._nodes.change(arm.play))
        return refusal or self._nodes.ending

    async def _change_of_state(self) -> None:
        before = self._arm.generation
        await self._nodes.until(lambda: self._arm.generation != before)

    def _begin(self, target: Mode, stop_program: bool) -> str:
        """Clear what stops the arm and start towards the mode; return why that fails."""
        arm = self._arm
        if stop_program and arm.program is not Program.STOPPED:
            arm.stop_program()
        refusal = arm.clear_stop()
        if refusal or arm.mode is target:
            return refusal
        if target is Mode.IDLE and arm.mode is Mode.RUNNING:
            arm.power_to(Mode.POWER_OFF)  # brakes cannot be applied directly
        arm.power_to(target)
        return ''
