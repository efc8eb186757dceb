# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The command lines and parameter files of the spawner, with the forms of controller_manager's."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from armsim_ros.config.yaml_node import (
    is_ros2_file,
    names_without_namespace,
    parameters_of_node,
    YamlNode,
)
from armsim_ros.config.yaml_source import read_yaml_file

BLOCK = '--controller'
_ROS_ARGS = '--controller-ros-args'
_USAGE = """spawner NAME... [options]
       spawner [options of all] --controller NAME [options] --controller NAME [options] ..."""


@dataclass(frozen=True)
class ControllerRequest:
    """
    A controller to spawn.

    :param ros_args: ROS arguments of its node, a text for each ``--controller-ros-args``.
    """

    name: str
    files: tuple[str, ...] = ()
    load_only: bool = False
    inactive: bool = False
    ros_args: tuple[str, ...] = ()


@dataclass(frozen=True)
class SpawnerRequest:
    """
    All that the spawner is to do.

    :param ignored: words that mean nothing.
    """

    options: argparse.Namespace
    controllers: tuple[ControllerRequest, ...]
    ignored: tuple[str, ...] = ()


def parse_spawner_arguments(argv: Sequence[str]) -> SpawnerRequest:
    """Read the words after the program's name; leaves with status 2 where they are wrong."""
    words = _joined(argv)
    blocks = BLOCK in words
    parser = argparse.ArgumentParser(
        prog='spawner', usage=_USAGE, description='Load, configure and activate controllers.',
        allow_abbrev=not blocks)
    _add_options(parser, asap=not blocks)
    if not blocks:
        parser.add_argument('controllers', nargs='+', metavar='NAME', help='name of a controller')
        _add_controller_options(parser)
        options = parser.parse_args(words)
        return SpawnerRequest(
            options, tuple(_request(name, options) for name in options.controllers))
    _add_controller_options(parser.add_argument_group('options of a controller'), hidden=True)
    options, rest = parser.parse_known_args([word for word in words if word in ('-h', '--help')])
    common = argparse.ArgumentParser(prog='spawner', add_help=False, allow_abbrev=False)
    _add_options(common, asap=False)
    options, rest = common.parse_known_args(words)
    starts = [place for place, word in enumerate(rest) if word == BLOCK]
    ignored = rest[:starts[0]]
    controllers = []
    for start, end in zip(starts, [*starts[1:], len(rest)], strict=True):
        name, *own = rest[start + 1:end] or ['']
        if not name:
            parser.error(f'{BLOCK} needs the name of a controller')
        block = argparse.ArgumentParser(add_help=False)
        _add_controller_options(block)
        given, unknown = block.parse_known_args(own)
        controllers.append(_request(name, given))
        ignored += unknown
    return SpawnerRequest(options, tuple(controllers), tuple(ignored))


def parse_unspawner_arguments(argv: Sequence[str]) -> argparse.Namespace:
    """Read the words after the program's name; leaves with status 2 where they are wrong."""
    parser = argparse.ArgumentParser(
        prog='unspawner', description='Deactivate and unload controllers.')
    parser.add_argument('controllers', nargs='+', metavar='NAME', help='name of a controller')
    add_manager_options(parser, manager='/controller_manager')
    _add_timeouts(parser)
    return parser.parse_args(list(argv))


def add_manager_options(
    parser: argparse.ArgumentParser, manager: str = 'controller_manager'
) -> None:
    """Add the options of every client of a manager."""
    parser.add_argument(
        '-c', '--controller-manager', default=manager, metavar='MANAGER',
        help=f'name of the manager (default: {manager})')
    parser.add_argument(
        '--controller-manager-timeout', type=float, default=0.0, metavar='S',
        help='time to wait for the manager [s], 0 is forever')


def _add_timeouts(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--switch-timeout', type=float, default=5.0, metavar='S', help='time for a switch [s]')
    parser.add_argument(
        '--service-call-timeout', type=float, default=10.0, metavar='S',
        help='time for an answer of the manager [s]')


def _add_options(parser: argparse.ArgumentParser, *, asap: bool) -> None:
    add_manager_options(parser)
    _add_timeouts(parser)
    parser.add_argument(
        '-n', '--namespace', default='',
        help='deprecated: namespace of manager and controllers; use --ros-args -r __ns:=NS')
    parser.add_argument(
        '-u', '--unload-on-kill', action='store_true',
        help='keep running; deactivate and unload the controllers at the end')
    parser.add_argument(
        '--activate-as-group', action='store_true',
        help='activate all together, at the end, or none')
    parser.add_argument(
        '--switch-asap', action=argparse.BooleanOptionalAction, default=asap,
        help='has no effect: a switch is always done at the next update')
    parser.add_argument(
        '--keep-going', action='store_true',
        help='if a controller cannot be loaded, spawn the others; the status is still 1')


def _add_controller_options(parser: argparse._ActionsContainer, *, hidden: bool = False) -> None:
    def text(line: str) -> str:
        return line + (f'; after {BLOCK} NAME' if hidden else '')

    parser.add_argument(
        '-p', '--param-file', action='append', default=[], metavar='FILE',
        help=text('file with the parameters, in the layout of ROS 1 or ROS 2; may be repeated'))
    parser.add_argument(
        '--load-only', action='store_true', help=text('load, and leave unconfigured'))
    parser.add_argument(
        '--inactive', action='store_true', help=text('load and configure, do not activate'))
    parser.add_argument(
        _ROS_ARGS, action='append', default=[], metavar='ARGS',
        help=text("ROS arguments of the controller's node, such as '-r joint_states:=/other'; "
                  'may be repeated'))


def _joined(argv: Sequence[str]) -> list[str]:
    """Return the words with ROS arguments joined, which argparse would read as options."""
    words: list[str] = []
    for word in argv:
        if words and words[-1] == _ROS_ARGS and ' ' in word:
            words[-1] = f'{_ROS_ARGS}={word}'
        else:
            words.append(word)
    return words


def _request(name: str, given: argparse.Namespace) -> ControllerRequest:
    return ControllerRequest(
        name, tuple(given.param_file), given.load_only, given.inactive,
        tuple(given.controller_ros_args))


@dataclass(frozen=True)
class FileEntries:
    """
    The entries of parameter files for a controller.

    :param files: those that have a block for it.
    :param type: '' where they give none.
    :param remarks: why a file does not count, in sentences.
    """

    files: tuple[str, ...] = ()
    type: str = ''
    fallback_controllers: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()


def entries_of(name: str, namespace: str, files: Sequence[str]) -> FileEntries:
    """
    Read the entries of parameter files for a controller; the first file that has a value wins.

    :param namespace: of the controller, such as ``/sunday``; ``/`` is none.
    :raises ConfigError: a file cannot be read.
    """
    used: list[str] = []
    remarks: list[str] = []
    kind: str = ''
    fallbacks: tuple[str, ...] = ()
    for file in dict.fromkeys(files):
        root = read_yaml_file(Path(file))
        block = parameters_of_node(root, name, namespace) if is_ros2_file(root) \
            else _ros1_block(root, name)
        if block is None:
            if names_without_namespace(root, name):
                remarks.append(
                    f"{file}: '{name}' is only a controller without a namespace; this one is "
                    f'{namespace}/{name}; allowed: {namespace}/{name}, /**/{name}')
            continue
        used.append(file)
        given = block.get('type')
        kind = kind or (given.text if given is not None and not given.is_mapping else '')
        listed = block.get('fallback_controllers')
        fallbacks = fallbacks or (tuple(item.text for item in listed.items)
                                  if listed is not None else ())
    return FileEntries(tuple(used), kind, fallbacks, tuple(remarks))


def _ros1_block(node: YamlNode, name: str) -> YamlNode | None:
    """Return the block of a controller in a file of ROS 1, at any depth."""
    for key, inner in node.entries.items():
        if not inner.is_mapping:
            continue
        if key.rpartition('/')[2] == name:
            return inner
        if (found := _ros1_block(inner, name)) is not None:
            return found
    return None
