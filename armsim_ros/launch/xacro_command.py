# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The xacro command of launch files, run inside this process."""

from __future__ import annotations

from pathlib import Path

from armsim_ros.errors import ConfigError, Location
from armsim_ros.install_rules.xacro_run import XacroCommand
from armsim_ros.launch.failures import MissingPackageError, SubstitutionFailure
from armsim_ros.launch.lookup import check_not_missing, current_lookup
from armsim_ros.model.description.xacro_text import read_description


def run_xacro(command: XacroCommand, where: Location | None) -> str:
    """
    Return the robot description of a xacro file.

    :param where: the line of the launch file.
    :raises SubstitutionFailure: where it makes none; the text names the xacro file.
    :raises MissingPackageError: where it names a package that is nowhere.
    """
    lookup = current_lookup()
    file = Path(command.file)
    if not file.is_file():
        check_not_missing(file)
        raise SubstitutionFailure(f"xacro file '{command.file}' does not exist", where)
    try:
        return read_description(file, mappings=command.mappings,
                                packages=lookup.packages.beside(file))
    except ConfigError as error:
        text = str(error)
        package = missing_in(text)
        if package:
            raise MissingPackageError(package, text) from None
        raise SubstitutionFailure(text, where) from None


def missing_in(text: str) -> str:
    """Return the package that an error message of the lookup names, '' if there is none."""
    _, found, rest = text.partition("package '")
    name, end, _ = rest.partition("' is not found")
    return name if found and end and "'" not in name else ''
