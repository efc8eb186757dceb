# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program that replaces an upstream program."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
import sys

from armsim_ros.cli.arguments import UsageError
from armsim_ros.errors import nearest

#: Program -> module and function here.
PROGRAMS = {
    **{name: (f'upstream.{name}', 'main') for name in (
        'static_transform_publisher', 'tf2_echo', 'tf2_monitor', 'view_frames')},
    'static_transform_broadcaster_node': ('upstream.static_transform_publisher', 'component'),
    **{name: ('upstream.state_publishers', name) for name in (
        'robot_state_publisher', 'joint_state_publisher')},
    **{name: ('upstream.robot_programs', name) for name in (
        'ros2_control_node', 'move_group', 'servo_node')},
    'rosbridge_websocket': ('bridge.main', 'main'),
    'foxglove_bridge': ('bridge.main', 'foxglove_bridge'),
    'spawner': ('upstream.spawner', 'main'),
    'unspawner': ('upstream.spawner', 'unspawn'),
    'hardware_spawner': ('upstream.spawner', 'set_hardware'),
}


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run such a program.

    :param argv: the program's name, then the words that the upstream program would get.
    :returns: its exit status.
    :raises UsageError: for a name that is none of them.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    if not words or words[0] not in PROGRAMS:
        given = words[0] if words else ''
        hint = nearest(given, tuple(PROGRAMS)) or f"known: {', '.join(PROGRAMS)}"
        raise UsageError(f"there is no replacement of '{given}'; {hint}")
    program, *rest = words
    if program == 'spawner':
        # A vendor's controller that is not known here must not keep the arm's own away.
        rest.insert(0, '--keep-going')
    module, function = PROGRAMS[program]
    return int(getattr(import_module(f'armsim_ros.nodes.{module}'), function)(rest))
