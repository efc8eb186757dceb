# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 run``."""

from __future__ import annotations

from collections.abc import Sequence
import os
import shlex

from armsim_ros2.errors import CliError, hint
from armsim_ros2.packages import programs_of
from armsim_ros2.parsing import USAGE_STATUS

USAGE = 'usage: ros2 run [--prefix COMMAND] PACKAGE PROGRAM [argument ...]'


def run(argv: Sequence[str]) -> int:
    """
    Become a program of a package; does not return unless only help was requested.

    :raises CliError: arguments are missing, or the package or program does not exist.
    """
    words = list(argv)
    before: list[str] = []
    while words and words[0].startswith('-'):
        option = words.pop(0)
        if option in ('-h', '--help'):
            print(f'{USAGE}\n\nrun a program of a package')
            return 0
        if option == '--prefix' and words:
            before = shlex.split(words.pop(0))
        elif option.startswith('--prefix='):
            before = shlex.split(option.partition('=')[2])
        else:
            raise CliError(f"{USAGE}\nros2 run: error: unknown option '{option}'", USAGE_STATUS)
    if len(words) == 2 and words[1] in ('-h', '--help'):
        rows = [f'  ros2 run {words[0]} {file.name}' for file in programs_of(words[0])]
        print('\n'.join([f"programs of '{words[0]}' (each has its own --help):", *rows]))
        return 0
    if len(words) < 2:
        raise CliError(f'{USAGE}\nros2 run: error: a package and a program are required',
                       USAGE_STATUS)
    package, program, *rest = words
    files = programs_of(package)
    found = [str(file) for file in files if file.name == program]
    if len(found) > 1:
        raise CliError('\n- '.join(['Multiple executables found:', *found]))
    if not found:
        names = [file.name for file in files]
        raise CliError(f"No executable found: package '{package}' has no program '{program}'"
                       f'{hint(program, names)} (it has: {", ".join(names) or "none"})')
    command = [*before, found[0], *rest]
    try:
        os.execvp(command[0], command)
    except OSError as error:
        raise CliError(f'cannot start {command[0]}: {error.strerror}') from None
