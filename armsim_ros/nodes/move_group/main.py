# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The move_group program: planning, kinematics, the planning scene, execution."""

from __future__ import annotations

import atexit
from collections.abc import Sequence
import os
import sys

from armsim_ros.cli.arguments import parse_arguments
from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.stop_signals import StopSignals

#: Exit status of a wrong command line or configuration.
_USAGE_STATUS = 2


def main(argv: Sequence[str] | None = None) -> int:
    """
    Serve until SIGINT or SIGTERM.

    What takes time is imported only now, so that a signal finds us listening.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 after a signal, 2 after a mistake of the user's.
    """
    end = _QuietEnd()
    end.status = _serve(argv)
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


def _serve(argv: Sequence[str] | None) -> int:
    signals = StopSignals()
    try:
        arguments = parse_arguments(sys.argv[1:] if argv is None else argv)
        from armsim_ros.nodes.move_group.program import MoveGroupProgram

        if signals.wanted:
            return 0
        program = MoveGroupProgram(arguments, lambda: signals.wanted)
        signals.on_stop = program.stop
        return program.run()
    except ArmsimError as error:
        print(error, file=sys.stderr, flush=True)
        return _USAGE_STATUS
