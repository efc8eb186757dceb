# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulation program."""

from __future__ import annotations

from collections.abc import Sequence
import sys

from armsim_ros.cli.arguments import parse_arguments
from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.stop_signals import StopSignals

#: Exit status of a wrong command line or configuration.
_USAGE_STATUS = 2


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run the simulation until SIGINT or SIGTERM.

    What takes time is imported only now, so that a signal finds us listening.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 after a signal, 2 after a mistake of the user's, 1 after a failure.
    """
    signals = StopSignals()
    try:
        arguments = parse_arguments(sys.argv[1:] if argv is None else argv)
        from armsim_ros.nodes.simulation.program import SimulationProgram

        if signals.wanted:
            return 0
        program = SimulationProgram(arguments, lambda: signals.wanted)
        signals.on_stop = program.stop
        return program.run()
    except ArmsimError as error:
        print(error, file=sys.stderr, flush=True)
        return _USAGE_STATUS
