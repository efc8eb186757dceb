# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Packages in the ament index: where they are installed, their programs and interfaces."""

from __future__ import annotations

import os
from pathlib import Path
import sys

from armsim_ros2.errors import CliError, hint


def package_prefixes() -> list[Path]:
    """Return the folders that packages are installed under: sourced ones, then this Python's."""
    sourced = [Path(entry) for entry in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
               if entry]
    own = Path(sys.prefix)
    return sourced if own in sourced else [*sourced, own]


def resources(kind: str) -> dict[str, Path]:
    """
    Return the packages with a resource of a kind, sorted by name.

    :param kind: such as ``packages`` or ``rosidl_interfaces``.
    :returns: name of the package -> its prefix; the first prefix that has it counts.
    """
    found: dict[str, Path] = {}
    for prefix in package_prefixes():
        folder = prefix / 'share' / 'ament_index' / 'resource_index' / kind
        if folder.is_dir():
            for file in folder.iterdir():
                if file.is_file() and not file.name.startswith('.'):
                    found.setdefault(file.name, prefix)
    return dict(sorted(found.items()))


def prefix_of(package: str, message: str = "Package '{}' not found") -> Path:
    """
    Return the prefix of a package.

    :param message: of the failure; {} is the name.
    :raises CliError: the package is not installed.
    """
    known = resources('packages')
    if package not in known:
        raise CliError(message.format(package) + hint(package, known))
    return known[package]


def programs_of(package: str) -> list[Path]:
    """
    Return the executable files of a package, sorted.

    :raises CliError: the package is not installed.
    """
    folder = prefix_of(package) / 'lib' / package
    return sorted(file for file in folder.rglob('*')
                  if is_program(file) and '/.' not in str(file.relative_to(folder).parent))


def is_program(path: Path) -> bool:
    """Return whether a path is an executable file."""
    return path.is_file() and os.access(path, os.X_OK)
