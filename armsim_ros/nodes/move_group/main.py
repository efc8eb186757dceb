# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The move_group program: planning, kinematics, the planning scene, execution."""

from __future__ import annotations

import atexit
from collections.abc import Sequence
import os
import sys

from armsim_ros.nodes.robot_program import serve


def main(argv: Sequence[str] | None = None) -> int:
    """
    Serve until SIGINT or SIGTERM.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 after a signal, 2 after a mistake of the user's.
    """
    end = _QuietEnd()
    end.status = serve('armsim_ros.nodes.move_group.program', 'MoveGroupProgram', argv)
    return end.status


class _QuietEnd:
    """
    Ends the process before its libraries say what they did not give back.

    OMPL's bindings print a page about that, below what the user should read.
    """

    def __init__(self) -> None:
        self.status = 1
        atexit.register(self._leave)

    def _leave(self) -> None:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(self.status)
