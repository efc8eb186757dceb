# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The move_group program: planning, kinematics, the planning scene, execution."""

from __future__ import annotations

from collections.abc import Sequence

from armsim_ros.cli.environment import QuietEnd
from armsim_ros.nodes.robot_program import serve


def main(argv: Sequence[str] | None = None) -> int:
    """
    Serve until SIGINT or SIGTERM.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 after a signal, 2 after a user's error.
    """
    end = QuietEnd(1)
    end.status = status = serve('armsim_ros.nodes.move_group.program', 'MoveGroupProgram', argv)
    return status
