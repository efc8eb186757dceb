# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The programs list and copy: the robots that bringup finds, and copies of their files."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import shlex
import shutil
import sys

from armsim_ros.cli.arguments import argparse_words, split_ros_args
from armsim_ros.config.package_files import PackageFiles
from armsim_ros.errors import ArmsimError
from armsim_ros.packages import Packages, split_path
from armsim_ros.resources import cell_names, PACKAGE, robot_names, share_folder


def list_robots(argv: Sequence[str] | None = None) -> int:
    """
    Print the robots, a line each: the word for ``robot:=`` and where it lies.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0.
    """
    words, _ = split_ros_args(sys.argv[1:] if argv is None else argv)
    options = _list_parser().parse_args(argparse_words(words))
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


def _list_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='armsim list',
        description='List the robots that bringup finds: those of this package, and MoveIt '
                    'packages in the workspace around the working folder or installed.')
    parser.add_argument('--packages-path', type=split_path, default=(), metavar='DIR:...',
                        help='further folders to search for packages')
    return parser


def copy(argv: Sequence[str] | None = None) -> int:
    """
    Copy, and print how to start the copy.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0.
    :raises ArmsimError: there is no such robot, it is a package, or the folder exists.
    """
    words, _ = split_ros_args(sys.argv[1:] if argv is None else argv)
    options = _copy_parser().parse_args(argparse_words(words))
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
    from armsim_ros.config.robot_folder import find_files  # slow, and the list needs none of it

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


def _copy_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='armsim copy',
        description="Copy a robot's files into a new folder, to change them there.")
    parser.add_argument('robot', help="a robot's name (see armsim list) or folder")
    parser.add_argument('to', type=Path, metavar='FOLDER', help='new folder')
    parser.add_argument('--packages-path', type=split_path, default=(), metavar='DIR:...',
                        help='further folders to search for packages')
    return parser
