# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Copies the files of a robot, its URDF included, into a folder that bringup can start."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import shlex
import shutil
import sys

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.config.robot_folder import find_files
from armsim_ros.errors import ArmsimError
from armsim_ros.packages import split_path
from armsim_ros.tools.words import argparse_words


def main(argv: Sequence[str] | None = None) -> int:
    """
    Copy, and print how to start the copy.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0.
    :raises ArmsimError: there is no such robot, it is a package, or the folder exists.
    """
    words, _ = split_ros_args(sys.argv[1:] if argv is None else argv)
    options = _parser().parse_args(argparse_words(words))
    target = copy_robot(options.robot, options.to, options.packages_path)
    for file in sorted(target.iterdir()):
        print(f'wrote {file}')
    print(f"start it with: {shlex.join(['armsim', 'bringup', f'robot:={options.to}'])}")
    return 0


def copy_robot(robot: str, target: Path, packages_path: Sequence[Path] = ()) -> Path:
    """
    Copy a robot's folder; meshes and what its xacro includes stay where they are.

    :param robot: a name under ``config/``, or a path to a folder.
    :param target: the new folder.
    :raises ArmsimError: there is no such robot, it is a package, or the folder exists.
    """
    files = find_files(robot, packages_path=packages_path)
    if files.package is not None:
        raise ArmsimError(f"'{robot}' is a package, whose files refer to each other; copy "
                          f"'{files.folder}' as a whole into a workspace")
    if target.exists():
        raise ArmsimError(f"'{target}' exists and is left as it is; name a new folder")
    if not target.parent.is_dir():
        raise ArmsimError(f"'{target.parent}' is not a folder")
    shutil.copytree(files.folder, target, ignore=shutil.ignore_patterns('.*', '__pycache__'))
    for file in (files.urdf_file, files.srdf_file):
        if file is not None and not (target / file.name).exists():
            shutil.copy(file, target)
    return target


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='armsim copy',
        description="Copy a robot's files into a new folder, to change them there.")
    parser.add_argument('robot', help="a robot's name (see armsim list) or folder")
    parser.add_argument('to', type=Path, metavar='FOLDER', help='new folder')
    parser.add_argument('--packages-path', type=split_path, default=(), metavar='DIR:...',
                        help='further folders to search for packages')
    return parser
