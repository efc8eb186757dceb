# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program that replaces an upstream program."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
import sys

from armsim_ros.cli.arguments import UsageError
from armsim_ros.errors import nearest

#: Program -> module with its ``main``.
PROGRAMS = {
    'ros2_control_node': 'armsim_ros.nodes.upstream.ros2_control_node',
    'move_group': 'armsim_ros.nodes.upstream.move_group',
    'servo_node': 'armsim_ros.nodes.upstream.servo_node',
    'robot_state_publisher': 'armsim_ros.nodes.upstream.robot_state_publisher',
    'joint_state_publisher': 'armsim_ros.nodes.upstream.joint_state_publisher',
    'static_transform_publisher': 'armsim_ros.nodes.upstream.static_transform_publisher',
    'spawner': 'armsim_ros.nodes.spawner.main',
    'unspawner': 'armsim_ros.nodes.spawner.unspawner',
    'hardware_spawner': 'armsim_ros.nodes.spawner.hardware_spawner',
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
    return int(import_module(PROGRAMS[program]).main(rest))
