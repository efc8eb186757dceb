# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program check_config."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
import os
from pathlib import Path
import sys

from armsim_ros.cli.arguments import argument_table, parse_arguments, split_ros_args
from armsim_ros.tools.check_config.schema import write_schemas
from armsim_ros.tools.words import argparse_words

#: Arguments of this program alone; all others are those of bringup.
_OWN = ('strict', 'keys', 'schema')


def main(argv: Sequence[str] | None = None) -> int:
    """
    Check a robot's folder, or single files.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 where all is well, 1 for warnings, 2 for errors.
    """
    words, _ = split_ros_args(sys.argv[1:] if argv is None else argv)
    launch_words = [word for word in words
                    if ':=' in word and word.partition(':=')[0].strip('-') not in _OWN]
    options = _parser().parse_args(argparse_words(
        word for word in words if word not in launch_words))
    if options.schema is not None:
        for path in write_schemas(options.schema):
            print(path)
        return 0
    # Slow to import, and not needed for --help and --schema.
    from armsim_ros.cli.settings import survey_options
    from armsim_ros.tools.check_config.report import exit_status, report_lines
    from armsim_ros.tools.check_config.robot_check import check_file, check_robot

    given = [f'{entry.name}:={getattr(options, entry.name)}' for entry in argument_table()
             if getattr(options, entry.name) is not None]
    arguments = parse_arguments([*launch_words, *given], xacro=True)
    sources = survey_options(arguments)
    is_named = any(word.startswith('robot:=') for word in (*launch_words, *given))
    targets = [*options.targets, *([arguments.robot] if is_named else [])] or [arguments.robot]
    status = 0
    for target in targets:
        path = Path(target).expanduser()
        check = check_file(path) if path.is_file() else check_robot(
            target, strict=options.strict, **sources)
        try:
            for line in report_lines(check, list_keys=options.keys):
                print(line)
            sys.stdout.flush()
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = max(status, exit_status(check))
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='check_config',
        description="Read a robot's files, start nothing, and report every error with file and "
                    'line, what each key does here, and which controllers move which planning '
                    'group.',
        epilog='exit status: 0 all is well, 1 warnings, 2 errors')
    parser.add_argument('targets', nargs='*', metavar='DIR|NAME|FILE',
                        help="a robot's folder or name, or single YAML, launch and URDF files")
    for entry in argument_table():
        option = parser.add_argument(
            f"--{entry.name.replace('_', '-')}", help=entry.metadata['description'],
            metavar=entry.metadata['placeholder'])
        if isinstance(entry.default, bool):
            option.nargs, option.const = '?', 'true'
    parser.add_argument('--strict', action='store_true',
                        help='treat as an error what upstream silently ignores')
    parser.add_argument('--keys', action='store_true',
                        help='list every key with what it does here')
    parser.add_argument('--schema', type=Path, metavar='DIR',
                        help='write JSON Schemas of all files for editors, check nothing')
    return parser
