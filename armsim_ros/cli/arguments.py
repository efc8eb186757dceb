# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arguments that bringup, simulation, move_group and the launch file share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, Field, field, fields
from typing import Any, TYPE_CHECKING

from armsim_ros.cli.launch_answers import HARMLESS_VALUES, REPLACED_ARGUMENTS, SPAWNER_FLAGS
from armsim_ros.errors import ArmsimError, nearest

if TYPE_CHECKING:
    import argparse

#: Prefix of an argument of the robot's xacro whose name the program uses, too.
XACRO = 'xacro:'
TRUE_WORDS = ('true', '1', 'yes', 'on')
FALSE_WORDS = ('false', '0', 'no', 'off')


class UsageError(ArmsimError):
    """The command line cannot be understood; the text names the right words."""


def _argument(default: Any, description: str, placeholder: str = 'true|false') -> Any:
    """Return a dataclass field that carries what ``--help`` and ``ros2 launch -s`` show."""
    return field(default=default,
                 metadata={'description': description, 'placeholder': placeholder})


@dataclass(frozen=True)
class ProgramArguments:
    """
    What the user asked a program to run, checked; a field per argument.

    An empty text leaves it to the robot's configuration.

    :param xacro: arguments unknown to the program; the robot's xacro may declare them.
    :param ros_args: everything between ``--ros-args`` and ``--``, those two included, for rclpy.
    """

    robot: str = _argument(
        'sunday', 'robot or cell: the name of a folder under config/, a path to a folder, or the '
        'name of a package', 'NAME|DIR')
    config: str = _argument(
        '', "folder with the YAML files, in place of the robot's own; for a package it is "
        'searched before its own', 'DIR')
    urdf: str = _argument('', "URDF or xacro file, in place of the robot's own", 'FILE')
    srdf: str = _argument('', "SRDF file, in place of the robot's own", 'FILE')
    controllers: str = _argument(
        '', "files with the controllers of ros2_control, in place of the robot's own", 'FILE,...')
    packages_path: str = _argument('', 'folders that are searched first for packages', 'DIR:...')
    world: str = _argument(
        '', "world, in place of the robot's own: a name under worlds/, or a file", 'NAME|FILE')
    scene_from_world: str = _argument(
        '', 'part of the world in the planning scene, in place of the configuration: all objects '
        'at their current poses, fixed objects only, or nothing', 'live|fixed|false')
    namespace: str = _argument(
        '', "namespace of the controllers and joint states, in place of the configuration's", 'NS')
    x: str = _argument('', 'position of the robot in the world [m]', 'METRES')
    y: str = _argument('', 'position of the robot in the world [m]', 'METRES')
    z: str = _argument('', 'position of the robot in the world [m]', 'METRES')
    initial_positions: str = _argument(
        '', 'start positions of joints, in place of those of the configuration [rad or m]',
        'JOINT=VALUE,...')
    overrides: str = _argument(
        '', 'settings by their dotted paths, in place of those of the files, such as '
        "'{simulation.gravity: [0, 0, 0]}'", '{PATH: VALUE, ...}')
    use_sim_time: bool = _argument(True, 'use the time of /clock in all nodes')
    servo: bool = _argument(False, 'also start servo_node, for streams of commands')
    camera: bool = _argument(
        False, 'also start the program that renders the cameras of simulation.yaml')
    octomap: bool = _argument(
        False, 'plans avoid obstacles in the images of the cameras of simulation.yaml')
    paused: bool = _argument(False, 'start paused')
    mode: str = _argument(
        'realtime', 'realtime follows the wall clock; in lockstep time begins at 0 and advances '
        'only by steps, so that a run can be repeated exactly', 'realtime|lockstep')
    seed: str = _argument('', "seed of the planner's random numbers; 0 in lockstep", 'NUMBER')
    record: str = _argument(
        '', 'recording (MCAP) of the run, at most of its last ten minutes, written when the '
        'simulation ends', 'FILE')
    web: bool = _argument(
        False, 'serve the page that shows and moves the robot; true at a terminal unless this '
        'argument is given')
    bridge: bool = _argument(False, 'also start rosbridge and rosapi, for clients without ROS')
    host: str = _argument(
        '', 'address on which the page is served (default: 127.0.0.1); with another address '
        'browsers need the token that is printed', 'ADDRESS')
    xacro: tuple[tuple[str, str], ...] = ()
    ros_args: tuple[str, ...] = ()

    def to_argv(self) -> list[str]:
        """Return the command line that gives these arguments, without those at their default."""
        words = [f'{entry.name}:={to_word(getattr(self, entry.name))}'
                 for entry in argument_table()
                 if getattr(self, entry.name) != entry.default]
        words += [f'{XACRO}{name}:={value}' for name, value in self.xacro]
        return [*words, *self.ros_args]


def argument_table() -> tuple[Field[Any], ...]:
    """Return the fields that are arguments: name, default, and the texts in their metadata."""
    return tuple(entry for entry in fields(ProgramArguments) if entry.metadata)


def parse_arguments(argv: Sequence[str], *, xacro: bool = False) -> ProgramArguments:
    """
    Read a program's command line.

    ``name:=value`` (as in ros2 launch), ``--name value`` and ``--name=value`` are equivalent;
    ``--name`` alone switches a true/false argument on. The last of several wins.

    ``xacro:name:=value`` is an argument of the robot's xacro even where the program has
    an argument of that name.

    :param argv: the words after the program's name.
    :param xacro: whether ``name:=value`` may be an argument of the robot's xacro; it is kept for
        :func:`check_xacro_words` then.
    :raises UsageError: for an unknown argument or a value of the wrong kind.
    """
    words, ros_args = split_ros_args(argv)
    table = {entry.name: entry for entry in argument_table()}
    values: dict[str, Any] = {}
    unknown: dict[str, str] = {}
    position = 0
    while position < len(words):
        word = words[position]
        position += 1
        name, sign, text = _take_apart(word)
        if xacro and name not in table and sign == ':=':
            unknown[name.removeprefix(XACRO)] = text
            continue
        if name in HARMLESS_VALUES and name not in table:
            if not sign and position < len(words) and _is_value(words[position], True):
                text = words[position]
                position += 1
            if _to_flag(name, text or 'true') is HARMLESS_VALUES[name]:
                continue
        if name not in table:
            raise UsageError(_unknown(word, name, tuple(table)))
        flag = isinstance(table[name].default, bool)
        if not sign:
            if position < len(words) and _is_value(words[position], flag):
                text = words[position]
                position += 1
            elif flag:
                text = 'true'
            else:
                raise UsageError(f"argument '{name}' needs a value: {name}:="
                                 f"{table[name].metadata['placeholder']}")
        values[name] = _to_flag(name, text) if flag else text
    return ProgramArguments(**values, xacro=tuple(unknown.items()), ros_args=ros_args)


def check_xacro_words(arguments: ProgramArguments, declared: Iterable[str]) -> None:
    """
    Refuse the words that neither the programs nor the robot's xacro know.

    :param declared: the arguments that the robot's xacro declares.
    :raises UsageError: names the arguments that there are.
    """
    names = tuple(declared)
    table = tuple(entry.name for entry in argument_table())
    for name, text in arguments.xacro:
        if name in names or is_harmless(name, text):
            continue
        hint = _unknown(f'{name}:={text}', name, (*table, *names))
        if names and 'known: ' in hint:
            hint += f"; the robot's xacro declares: {', '.join(names)}"
        raise UsageError(hint)


def is_harmless(name: str, text: str) -> bool:
    """Return whether an argument of other launch files asks for what is the case here anyway."""
    return (name in HARMLESS_VALUES and text.lower() in TRUE_WORDS + FALSE_WORDS
            and _to_flag(name, text) is HARMLESS_VALUES[name])


def shadowed_xacro_words(arguments: ProgramArguments, declared: Iterable[str]) -> list[str]:
    """
    Return a line for each argument that was given to the program and that the xacro declares, too.

    :param declared: the arguments that the robot's xacro declares.
    """
    given = dict(arguments.xacro)
    return [f"{entry.name}:={to_word(getattr(arguments, entry.name))} is the program's argument; "
            f"the robot's xacro has an argument of that name, set by {XACRO}{entry.name}:=VALUE"
            for entry in argument_table()
            if entry.name in declared and entry.name not in given
            and getattr(arguments, entry.name) != entry.default]


def split_ros_args(argv: Sequence[str]) -> tuple[list[str], tuple[str, ...]]:
    """
    Part the words of the program from those of ROS.

    :returns: the program's words, and every ``--ros-args ... [--]`` section in order, each with
        its end mark (https://design.ros2.org/articles/ros_command_line_arguments.html).
    """
    own: list[str] = []
    ros: list[str] = []
    inside = False
    for word in argv:
        if word == '--ros-args' and not inside:
            inside = True
        if not inside:
            own.append(word)
            continue
        ros.append(word)
        if word == '--':
            inside = False
    if inside:
        ros.append('--')
    return own, tuple(ros)


def format_help(program: str, summary: str) -> str:
    """Return the text of ``--help`` of a program with these arguments."""
    rows = []
    for entry in argument_table():
        note = f' (default: {to_word(entry.default)})' if entry.default != '' else ''
        rows.append((f"{entry.name}:={entry.metadata['placeholder']}",
                     f"{entry.metadata['description']}{note}"))
    rows.append(('--ros-args ...', 'remappings and parameters, as for any ROS 2 program'))
    width = max(len(left) for left, _ in rows)
    lines = [f'  {left:<{width}}  {right}' for left, right in rows]
    return '\n'.join([
        f'usage: armsim {program} [NAME:=VALUE ...] [--ros-args ...]', '', summary, '',
        'arguments (--name VALUE is the same as name:=VALUE):', *lines])


def to_word(value: object) -> str:
    """Return an argument's value as it is written on a command line."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _take_apart(word: str) -> tuple[str, str, str]:
    """Return name, sign and value of a word; the sign is empty where the value follows."""
    if word.startswith('--'):
        name, sign, text = word[2:].partition('=')
        if name.endswith(':'):
            name, sign = name[:-1], ':='
        return name.replace('-', '_'), sign, text
    name, sign, text = word.partition(':=')
    if word in SPAWNER_FLAGS:
        raise UsageError(f"'{word}' is a flag of spawn_model; in its place: "
                         f'{SPAWNER_FLAGS[word]}')
    if not sign or not name:
        raise UsageError(f"cannot read '{word}': arguments are written name:=value or "
                         '--name value; --help lists them')
    return name, sign, text


def _is_value(word: str, flag: bool) -> bool:
    if flag:
        return word.lower() in TRUE_WORDS + FALSE_WORDS
    return not word.startswith('--') and ':=' not in word


def _to_flag(name: str, text: str) -> bool:
    if text.lower() in TRUE_WORDS:
        return True
    if text.lower() in FALSE_WORDS:
        return False
    raise UsageError(f"argument '{name}' is '{text}'; allowed: true, false")


def _unknown(word: str, name: str, known: tuple[str, ...]) -> str:
    if name in REPLACED_ARGUMENTS:
        return f"argument '{name}' is not used here; in its place: {REPLACED_ARGUMENTS[name]}"
    hint = nearest(name, known) or f"known: {', '.join(dict.fromkeys(known))}"
    from armsim_ros.config.simulation import SimulationSettings  # slow, and not needed otherwise

    if name in SimulationSettings.model_fields:
        hint = (f"it is a key of simulation.yaml: overrides:='{{simulation.{name}: VALUE}}', or "
                'the file')
    return f"unknown argument '{word}'; {hint}"


def part_words(words: Iterable[str], parser: argparse.ArgumentParser
               ) -> tuple[list[str], dict[str, str]]:
    """
    Part the words of a program from the arguments for a robot's xacro.

    :returns: the words that are no ``name:=value`` or name an option of the parser, and the
        others by name.
    """
    own: list[str] = []
    others: dict[str, str] = {}
    for word in words:
        name, sign, value = word.partition(':=')
        if sign and f"--{name.strip('-').replace('_', '-')}" not in parser._option_string_actions:
            others[name] = value
        else:
            own.append(word)
    return own, others


def argparse_words(words: Iterable[str]) -> list[str]:
    """Return the words with each ``name:=value`` as ``--name=value``."""
    result = []
    for word in words:
        name, sign, value = word.partition(':=')
        if sign and name.strip('-').replace('_', '').isalnum():
            result.append(f"--{name.strip('-').replace('_', '-')}={value}")
        else:
            result.append(word)
    return result
