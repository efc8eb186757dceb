# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``dashboard_client``: what the vendor's dashboard server does, and what it answers."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from ur_dashboard_msgs.msg import ProgramState, SafetyStatus, VersionInformation
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

from armsim_ros.control.safety.arm_state import Mode, Program, Safety
from armsim_ros.nodes.vendors.endpoints import ArmNodes
from armsim_ros.nodes.vendors.universal_robots.modes import robot_mode, SAFETIES, safety_mode

VERSION = (5, 21, 0, 0)
SERIAL_NUMBER = 20215500001
WAIT = ('Cannot unlock protective stop until 5s after occurrence. Always inspect cause of '
        'protective stop before unlocking')


class Dashboard:
    """The node ``dashboard_client``; its services answer as the dashboard server does."""

    def __init__(self, nodes: ArmNodes) -> None:
        self._arm = nodes.arm
        self._model = nodes.robot.model.name
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
        queries: tuple[tuple[Any, str, Callable[[], str], Callable[[Any], object]], ...] = (
            (GetRobotMode, 'get_robot_mode', self._robot_mode, self._fill_robot_mode),
            (GetSafetyMode, 'get_safety_mode', self._safety_mode, self._fill_safety_mode),
            (GetSafetyStatus, 'get_safety_status', self._safety_status, self._fill_status),
            (IsProgramRunning, 'program_running', self._running, self._fill_running),
            (GetProgramState, 'program_state', self._program_state, self._fill_program_state),
            (GetLoadedProgram, 'get_loaded_program', self._loaded_program,
             lambda response: setattr(response, 'program_name', f'/programs/{self._program}')),
            (IsProgramSaved, 'program_saved', self._saved, self._fill_saved),
            (IsInRemoteControl, 'is_in_remote_control', lambda: 'true',
             lambda response: setattr(response, 'remote_control', True)),
            (GetPolyScopeVersion, 'get_polyscope_version', _version, _fill_version),
            (GetRobotModel, 'get_robot_model', self._robot_model,
             lambda response: setattr(response, 'robot_model', self._robot_model())),
            (GetSerialNumber, 'get_serial_number', lambda: str(SERIAL_NUMBER),
             lambda response: setattr(response, 'serial_number', SERIAL_NUMBER)),
        )
        for kind, name, text, fill in queries:
            nodes.service(node, kind, f'~/{name}', partial(_answer, text, fill))
        nodes.service(node, Load, '~/load_program', self._load_program)
        nodes.service(node, Load, '~/load_installation', self._load_installation)
        nodes.service(node, Popup, '~/popup', self._popup)
        nodes.service(node, AddToLog, '~/add_to_log', self._add_to_log)
        nodes.service(node, RawRequest, '~/raw_request', self._raw_request)
        self._texts: dict[str, Callable[[], str]] = {
            'robotmode': self._robot_mode, 'safetymode': self._safety_mode,
            'safetystatus': self._safety_status, 'running': self._running,
            'programState': self._program_state, 'get loaded program': self._loaded_program,
            'isProgramSaved': self._saved, 'is in remote control': lambda: 'true',
            'PolyscopeVersion': _version, 'get robot model': self._robot_model,
            'get serial number': lambda: str(SERIAL_NUMBER),
        }

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

    def _robot_mode(self) -> str:
        return f'Robotmode: {self._arm.mode.value}'

    def _fill_robot_mode(self, response: Any) -> None:
        response.robot_mode = robot_mode(self._arm)

    def _safety_mode(self) -> str:
        return f'Safetymode: {SAFETIES[self._arm.safety][1]}'

    def _fill_safety_mode(self, response: Any) -> None:
        response.safety_mode = safety_mode(self._arm)

    def _safety_status(self) -> str:
        return f'Safetystatus: {SAFETIES[self._arm.safety][1]}'

    def _fill_status(self, response: Any) -> None:
        response.safety_status = SafetyStatus(status=SAFETIES[self._arm.safety][0])

    def _running(self) -> str:
        return f'Program running: {str(self._arm.program is Program.PLAYING).lower()}'

    def _fill_running(self, response: Any) -> None:
        response.program_running = self._arm.program is Program.PLAYING

    def _program_state(self) -> str:
        return f'{self._arm.program.value} {self._program}'

    def _fill_program_state(self, response: Any) -> None:
        response.state = ProgramState(state=self._arm.program.value)
        response.program_name = self._program

    def _loaded_program(self) -> str:
        return f'Loaded program: /programs/{self._program}'

    def _saved(self) -> str:
        return f'true {self._program}'

    def _fill_saved(self, response: Any) -> None:
        response.program_saved, response.program_name = True, self._program

    def _robot_model(self) -> str:
        return self._model.upper()

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


def _answer(text: Callable[[], str], fill: Callable[[Any], object], _: Any,
            response: Any) -> None:
    response.success, response.answer = True, text()
    fill(response)


def _nothing() -> str:
    return ''


def _done(function: Callable[[], None]) -> Callable[[], str]:
    def call() -> str:
        function()
        return ''
    return call


def _version() -> str:
    return 'URSoftware ' + '.'.join(map(str, VERSION))


def _fill_version(response: Any) -> None:
    major, minor, bugfix, build = VERSION
    response.version = VersionInformation(major=major, minor=minor, bugfix=bugfix, build=build)
