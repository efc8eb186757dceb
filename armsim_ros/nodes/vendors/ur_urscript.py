# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
``urscript_interface/script_command``: the commands of URScript that clients send most.

A script is read as a whole before any of it runs. As on the arm, a script takes control away from
the program of the driver, unless it is a ``sec`` block, which cannot move.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
import re
from typing import Any

from std_msgs.msg import String

from armsim_ros.control.arm_state import Program
from armsim_ros.errors import SimulationError
from armsim_ros.nodes.vendors.endpoints import ArmNodes

#: Command -> the names of its arguments; those with a default may be left out.
COMMANDS: dict[str, tuple[tuple[str, object], ...]] = {
    'set_digital_out': (('n', None), ('b', None)),
    'set_standard_digital_out': (('n', None), ('b', None)),
    'set_tool_voltage': (('voltage', None),),
    'popup': (('s', None), ('title', 'Popup'), ('warning', False), ('error', False),
              ('blocking', False)),
    'textmsg': (('s1', None), ('s2', '')),
    'stopj': (('a', 2.0),),
    'movej': (('q', None), ('a', 1.4), ('v', 1.05), ('t', 0.0), ('r', 0.0)),
    'sleep': (('t', None),),
}
MOVES = ('movej', 'stopj', 'sleep')
DIGITAL_PINS = 18
_BLOCK = re.compile(r'(def|sec)\s+(\w+)\s*\(\s*\)\s*:')
_CALL = re.compile(r'(\w+)\s*\((.*)\)')


class ScriptError(Exception):
    """A line that cannot run here."""


@dataclass(frozen=True, slots=True)
class Command:
    """A command with all its arguments."""

    name: str
    arguments: dict[str, Any]


def read_script(text: str, joints: int) -> tuple[bool, tuple[Command, ...]]:
    """
    Return whether a script is secondary, and its commands.

    :param joints: of the arm.
    :raises ScriptError: a line is not understood.
    """
    commands: list[Command] = []
    secondary, block = False, ''
    for number, line in enumerate(text.splitlines(), 1):
        code = line.partition('#')[0].strip()
        opening = _BLOCK.fullmatch(code)
        if opening and not block:
            secondary, block = opening[1] == 'sec', opening[2]
        elif code and code != 'end' and code.replace(' ', '') != f'{block}()':
            try:
                commands.append(_command(code, joints))
                if secondary and commands[-1].name in MOVES:
                    raise ValueError('a secondary program cannot move or wait')
            except ValueError as error:
                raise ScriptError(f"line {number}, '{code}': {error}") from None
    return secondary, tuple(commands)


def _command(code: str, joints: int) -> Command:
    match = _CALL.fullmatch(code)
    name = match[1] if match else ''
    if match is None or name not in COMMANDS:
        raise ValueError(f'only {", ".join(COMMANDS)} are simulated')
    try:
        call = ast.parse(f'f({match[2]})', mode='eval').body
        assert isinstance(call, ast.Call)
        values = [_value(argument) for argument in call.args]
        named = {str(entry.arg): _value(entry.value) for entry in call.keywords}
    except SyntaxError:
        raise ValueError('it cannot be read') from None
    given = {key for key, _ in COMMANDS[name][:len(values)]}
    known = dict(COMMANDS[name])
    if len(values) > len(known) or given & set(named) or not set(named) <= set(known):
        raise ValueError(f'its arguments are {", ".join(known)}')
    arguments = {**known, **dict(zip(known, values, strict=False)), **named}
    if any(value is None for value in arguments.values()):
        raise ValueError(f'its arguments are {", ".join(known)}')
    _check(name, arguments, joints)
    return Command(name, arguments)


def _value(node: ast.expr) -> Any:
    if isinstance(node, ast.Subscript):
        raise ValueError('poses p[...] are not simulated; give the joints [...]')
    try:
        return ast.literal_eval(node)
    except ValueError:
        raise ValueError('its arguments must be constants') from None


def _check(name: str, arguments: dict[str, Any], joints: int) -> None:
    numbers = {key: value for key, value in arguments.items()
               if key in ('a', 'v', 't', 'r', 'voltage')}
    if not all(isinstance(value, (int, float)) and value >= 0.0 for value in numbers.values()):
        raise ValueError(f'{", ".join(numbers)} must be numbers of 0 or more')
    if 'n' in arguments and not (
            isinstance(arguments['n'], int) and 0 <= arguments['n'] < DIGITAL_PINS):
        raise ValueError(f'n must be 0 to {DIGITAL_PINS - 1}')
    if name == 'set_tool_voltage' and arguments['voltage'] not in (0, 12, 24):
        raise ValueError('the voltage must be 0, 12 or 24')
    if name == 'movej':
        q = arguments['q']
        if not (isinstance(q, list) and len(q) == joints
                and all(isinstance(value, (int, float)) for value in q)):
            raise ValueError(f'q must have {joints} numbers')
        if not (arguments['t'] > 0.0 or (arguments['a'] > 0.0 and arguments['v'] > 0.0)):
            raise ValueError('a and v, or t, must be above 0')


class UrScript:
    """The node ``urscript_interface``."""

    def __init__(self, nodes: ArmNodes) -> None:
        self._nodes = nodes
        self._runs = 0
        node = nodes.new_node('urscript_interface')
        self._logger = node.get_logger()
        receive: Any = self._receive  # an executor runs coroutines, too
        node.create_subscription(String, '~/script_command', receive, 1)

    async def _receive(self, message: String) -> None:
        nodes = self._nodes
        self._runs += 1
        run = self._runs
        try:
            secondary, commands = read_script(message.data, len(nodes.manager.stops.arm_joints))
            if not secondary:
                await nodes.change(nodes.arm.stop_program)
                await nodes.until(lambda: bool(nodes.manager.stops.reason))
            for command in commands:
                await self._do(command)
                if run != self._runs or nodes.ending:
                    return
        except ScriptError as error:
            self._logger.error(f'script: {error}')
        except SimulationError:
            return

    async def _do(self, command: Command) -> None:
        nodes, given = self._nodes, command.arguments
        stops, arm = nodes.manager.stops, nodes.arm
        if command.name in ('set_digital_out', 'set_standard_digital_out'):
            await nodes.change(
                lambda: arm.signals.set(f'digital_out_{given["n"]}', float(bool(given['b']))))
        elif command.name == 'set_tool_voltage':
            await nodes.change(lambda: arm.signals.set('tool_voltage', given['voltage']))
        elif command.name in ('popup', 'textmsg'):
            texts = ('s',) if command.name == 'popup' else ('s1', 's2')
            self._logger.info(f'{command.name}: {"".join(str(given[key]) for key in texts)}')
        elif command.name == 'sleep':
            end_ns = nodes.time_ns + round(given['t'] * 1e9)
            await nodes.until(lambda: nodes.time_ns >= end_ns)
        else:
            self._check_control(command)
            targets = given['q'] if command.name == 'movej' else None
            await nodes.change(lambda: stops.move(
                targets, given.get('v', 0.0), given['a'], given.get('t', 0.0)))
            await nodes.until(lambda: stops.at_rest)
            self._check_control(command)

    def _check_control(self, command: Command) -> None:
        """Raise where a stop, or the program, has taken the arm from the script."""
        arm = self._nodes.arm
        if not arm.moves or arm.program is not Program.STOPPED:
            raise ScriptError(f'{command.name}: {arm.obstacle or "the program has control"}')
