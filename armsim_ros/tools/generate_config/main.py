# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program generate_config."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import sys

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.packages import split_path
from armsim_ros.tools.words import argparse_words, part_words


def main(argv: Sequence[str] | None = None) -> int:
    """
    Write a first set of files for a URDF, and check it.

    :param argv: the words after the program's name; those of this process where None.
    :returns: check_config's status for the new files: 0, 1 with warnings, 2 with errors.
    :raises ConfigError: the URDF has errors, or the files are there already.
    """
    words, _ = split_ros_args(sys.argv[1:] if argv is None else argv)
    words, arguments = part_words(words, _parser())
    options = _parser().parse_args(argparse_words(words))
    # Slow to import, and not needed for --help.
    from armsim_ros.tools.check_config.report import exit_status, report_lines
    from armsim_ros.tools.check_config.robot_check import check_robot
    from armsim_ros.tools.generate_config.generation import generate_config

    target = options.to or Path.cwd() / options.urdf.name.split('.')[0]
    for line in generate_config(options.urdf, target, states=options.states, seed=options.seed,
                                copy=options.copy, arguments=arguments,
                                packages_path=options.packages_path):
        print(line, flush=True)
    check = check_robot(str(target), arguments=arguments, packages_path=options.packages_path)
    for line in report_lines(check):
        print(line)
    given = [f'{name}:={value}' for name, value in arguments.items()]
    if options.packages_path:
        given.append(f"packages_path:={':'.join(map(str, options.packages_path))}")
    print(' '.join([f'start it with: bringup robot:={target}', *given]))
    return exit_status(check)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='generate_config',
        description='Write SRDF, controllers, joint limits, kinematics and simulation settings '
                    'for a robot of which there is only a URDF.',
        epilog='exit status: that of check_config for the new files')
    parser.add_argument('urdf', type=Path, metavar='URDF', help='URDF or xacro file; the '
                        'arguments of a xacro follow as name:=value')
    parser.add_argument('--to', type=Path, metavar='DIR',
                        help="folder for the files; without it a folder with the URDF's name")
    parser.add_argument('--packages-path', type=split_path, default=(), metavar='DIR:...',
                        help='folders that are searched first for packages')
    parser.add_argument('--states', type=int, default=10_000, metavar='N',
                        help='random states that are checked for collisions (%(default)s)')
    parser.add_argument('--seed', type=int, default=0, help='of the random numbers (%(default)s)')
    parser.add_argument('--copy', action='store_true',
                        help='copy the URDF in place of a link to it')
    return parser
