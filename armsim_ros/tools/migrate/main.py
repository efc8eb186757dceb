# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program migrate."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import sys

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.tools.migrate.migration import migrate, REPORT
from armsim_ros.tools.words import argparse_words


def main(argv: Sequence[str] | None = None) -> int:
    """
    Write a robot's files in the layout of ROS 2.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0.
    :raises ConfigError: the robot's files have errors.
    """
    words, _ = split_ros_args(sys.argv[1:] if argv is None else argv)
    options = _parser().parse_args(argparse_words(words))
    for line in migrate(options.robot, options.to):
        print(line)
    print(f'written to {options.to}, with this report as {REPORT}')
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='migrate',
        description="Write a robot's files in the layout of ROS 2, with their comments, and a "
                    'report of what went where; the files themselves stay as they are.')
    parser.add_argument('robot', metavar='DIR|NAME', help="the robot's folder or name")
    parser.add_argument('--to', type=Path, required=True, metavar='OUT',
                        help='a new folder for the files')
    return parser
