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

from armsim_ros.control.safety.arm_state import ArmState, Mode, Program, Safety
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


def _answer(text: Callable[[], str], fill: Callable[[Any], object], _: Any, response: Any) -> None:
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
