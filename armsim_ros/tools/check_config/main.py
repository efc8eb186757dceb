# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program check_config."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
import os
from pathlib import Path
import sys

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.packages import split_path
from armsim_ros.tools.check_config.schema import write_schemas
from armsim_ros.tools.words import argparse_words, part_words


def main(argv: Sequence[str] | None = None) -> int:
    """
    Check a robot's folder, or single files.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 where all is well, 1 for warnings, 2 for mistakes.
    """
    words, _ = split_ros_args(sys.argv[1:] if argv is None else argv)
    words, arguments = part_words(words, _parser())
    options = _parser().parse_args(argparse_words(words))
    if options.schema is not None:
        for path in write_schemas(options.schema):
            print(path)
        return 0
    # Slow to import, and not needed for --help and --schema.
    from armsim_ros.tools.check_config.report import exit_status, report_lines
    from armsim_ros.tools.check_config.robot_check import check_file, check_robot

    targets = [*options.targets, *([options.robot] if options.robot else [])] or ['sunday']
    status = 0
    for target in targets:
        path = Path(target).expanduser()
        check = check_file(path) if path.is_file() else check_robot(
            target, config=options.config, urdf=options.urdf, srdf=options.srdf,
            world=options.world, controllers=options.controllers, arguments=arguments,
            packages_path=options.packages_path, strict=options.strict)
        try:
            for line in report_lines(check, list_keys=options.keys):
                print(line)
            sys.stdout.flush()
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        status = max(status, exit_status(check))
    return status


def _files(text: str) -> tuple[Path, ...]:
    return tuple(Path(one).expanduser() for one in text.split(',') if one)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='check_config',
        description="Read a robot's files, start nothing, and tell every mistake with file and "
                    'line, what each key does here, and which controllers move which planning '
                    'group.',
        epilog='exit status: 0 all is well, 1 warnings, 2 mistakes')
    parser.add_argument('targets', nargs='*', metavar='DIR|NAME|FILE',
                        help="a robot's folder or name, or single YAML, launch and URDF files")
    parser.add_argument('--robot', help='the same as naming it', metavar='DIR|NAME')
    parser.add_argument('--config', type=Path, metavar='DIR', help='other folder with YAML files')
    parser.add_argument('--urdf', type=Path, metavar='FILE', help='other URDF or xacro file')
    parser.add_argument('--srdf', type=Path, metavar='FILE', help='other SRDF file')
    parser.add_argument('--controllers', type=_files, default=(), metavar='FILE,...',
                        help="other files with ros2_control's controllers")
    parser.add_argument('--packages-path', type=split_path, default=(), metavar='DIR:...',
                        help='folders in which packages are looked for first')
    parser.add_argument('--strict', action='store_true',
                        help='take for a mistake what the original stack silently ignores')
    parser.add_argument('--world', metavar='NAME|FILE', help='other world')
    parser.add_argument('--keys', action='store_true',
                        help='list every key with what it does here')
    parser.add_argument('--schema', type=Path, metavar='DIR',
                        help='write JSON Schemas of all files for editors, check nothing')
    return parser
