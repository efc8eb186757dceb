# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Lists the robots that bringup would find: ours, and the MoveIt packages around the user."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import sys

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.config.moveit_config.files import PackageFiles
from armsim_ros.packages import Packages, split_path
from armsim_ros.resources import cell_names, PACKAGE, robot_names, share_folder
from armsim_ros.tools.words import argparse_words


def main(argv: Sequence[str] | None = None) -> int:
    """
    Print the robots, a line each: the word for ``robot:=`` and where it lies.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0.
    """
    words, _ = split_ros_args(sys.argv[1:] if argv is None else argv)
    options = _parser().parse_args(argparse_words(words))
    rows = [(name, share_folder(PACKAGE) / 'config' / name)
            for name in (*robot_names(), *cell_names())]
    rows += moveit_packages(Packages(options.packages_path, near=(Path.cwd() / 'x',)))
    width = max((len(name) for name, _ in rows), default=0)
    for name, place in rows:
        print(f'{name:<{width}}  {place}')
    return 0


def moveit_packages(packages: Packages) -> list[tuple[str, Path]]:
    """Return name and folder of the packages that describe a robot for planning."""
    return [(name, folder) for name, folder in sorted(packages.names().items())
            if name != PACKAGE and PackageFiles(folder, packages).srdf() is not None]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='armsim list',
        description='List the robots that bringup finds: those of this package, and MoveIt '
                    'packages in the workspace around the working folder or installed.')
    parser.add_argument('--packages-path', type=split_path, default=(), metavar='DIR:...',
                        help='further folders to search for packages')
    return parser
