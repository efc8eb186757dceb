# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The bringup program: simulation and move_group under one supervisor."""

from __future__ import annotations

from collections.abc import Sequence
import sys

from armsim_ros.cli.arguments import parse_arguments, ProgramArguments
from armsim_ros.nodes.bringup.child import program_command
from armsim_ros.nodes.bringup.domain_lock import lock_domain
from armsim_ros.nodes.bringup.supervisor import Supervisor

#: In starting order: the simulation first, everyone waits for its joint states.
STARTED_PROGRAMS = ('simulation', 'move_group')


def main(argv: Sequence[str] | None = None) -> int:
    """
    Start the stack and stay until it ends.

    :param argv: the words after the program's name; those of this process where None.
    :returns: the exit status, see :meth:`Supervisor.run`.
    :raises UsageError: for an argument that is not known.
    :raises DomainTakenError: where another stack runs in the same ROS domain.
    :raises ConfigError: where the robot's files are wrong; both programs would say so.
    """
    arguments = parse_arguments(sys.argv[1:] if argv is None else argv)
    lock = lock_domain(arguments.ros_args)
    words = arguments.to_argv()
    try:
        check_configuration(arguments)
        return Supervisor({program: program_command(program, words)
                           for program in STARTED_PROGRAMS}).run()
    finally:
        lock.release()


def check_configuration(arguments: ProgramArguments) -> None:
    """
    Read the robot's files once, before two programs do and would each complain.

    :raises ConfigError: where they are wrong.
    """
    # Slow to import, and not needed to say that an argument is wrong or the domain is taken.
    from armsim_ros.cli.settings import cell_of

    cell_of(arguments)
