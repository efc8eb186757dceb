# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 run``."""

from __future__ import annotations

from argparse import REMAINDER
from collections.abc import Sequence
import os
from pathlib import Path
import shlex
import sys

from armsim_ros2.errors import CliError, hint
from armsim_ros2.packages import is_program, programs_of
from armsim_ros2.parsing import Parser


def run(argv: Sequence[str]) -> int:
    """
    Become a program of a package; does not return unless only help was requested.

    What is not installed is passed to ``armsim run``, if armsim_ros is in this environment.

    :raises CliError: arguments are missing, or the package or program does not exist.
    """
    parser = Parser(prog='ros2 run', description='run a program of a package', allow_abbrev=False)
    parser.add_argument('--prefix', default='', metavar='COMMAND',
                        help='command to put before the program, such as a debugger')
    parser.add_argument('package', help='name of the package')
    # Options after the package are the program's.
    parser.add_argument('program', nargs=REMAINDER, help='the program and its arguments')
    options = parser.parse_args(argv)
    if not options.program:
        parser.error('the following arguments are required: program')
    package, (program, *rest) = options.package, options.program
    try:
        files = programs_of(package)
        if not rest and program in ('-h', '--help'):
            rows = [f'  ros2 run {package} {file.name}' for file in files]
            print('\n'.join([f"programs of '{package}' (each has its own --help):", *rows]))
            return 0
        start = [_choose(package, program, files)]
    except CliError as failure:
        armsim = Path(sys.prefix, 'bin', 'armsim')
        if not is_program(armsim):
            raise
        start = [str(armsim), 'run', f'--failure={failure}', package, program]
    command = [*shlex.split(options.prefix), *start, *rest]
    try:
        os.execvp(command[0], command)
    except OSError as error:
        raise CliError(f'cannot start {command[0]}: {error.strerror}') from None


def _choose(package: str, program: str, files: Sequence[Path]) -> str:
    found = [str(file) for file in files if file.name == program]
    if len(found) > 1:
        raise CliError('\n- '.join(['Multiple executables found:', *found]))
    if not found:
        names = [file.name for file in files]
        raise CliError(f"No executable found: package '{package}' has no program '{program}'"
                       f'{hint(program, names)} (it has: {", ".join(names) or "none"})')
    return found[0]
