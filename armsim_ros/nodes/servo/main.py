# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The servo_node program: twists, joint jogs and poses to joint commands."""

from __future__ import annotations

from collections.abc import Sequence

from armsim_ros.nodes.robot_program import serve


def main(argv: Sequence[str] | None = None) -> int:
    """
    Serve until SIGINT or SIGTERM.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 after a signal, 2 after a user's error.
    """
    return serve('armsim_ros.nodes.servo.program', 'ServoProgram', argv)
