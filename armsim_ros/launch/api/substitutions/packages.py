# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Substitutions of packages and their programs."""

from __future__ import annotations

import os

from armsim_ros.launch.api.context import LaunchContext
from armsim_ros.launch.api.entity import SomeText, Substitution
from armsim_ros.launch.api.substitutions.files import PathJoinSubstitution
from armsim_ros.launch.api.utilities import (
    describe_text,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from armsim_ros.launch.failures import MissingPackageError, SubstitutionFailure
from armsim_ros.launch.lookup import current_lookup, NOWHERE


class FindPackage(Substitution):
    """
    A folder of a package.

    :param package: its name.
    """

    def __init__(self, package: SomeText) -> None:
        self.package = normalize_to_list_of_substitutions(package)

    def perform(self, context: LaunchContext) -> str:
        """
        Return the folder.

        Of a package that is nowhere it is a path that does not exist: many a path is handed on
        and never opened. Opening it reports this.
        """
        package = perform_substitutions(context, self.package)
        try:
            return self.find(package)
        except MissingPackageError as error:
            if context.engine is None:
                raise
            context.engine.tell_missing(error)
            return str(NOWHERE / package)

    def find(self, package_name: str) -> str:
        """
        Return the folder of a package of this name.

        :raises MissingPackageError: where it is nowhere.
        """
        return str(current_lookup().share(package_name))

    def __truediv__(self, other: SomeText) -> PathJoinSubstitution:
        """Return a path below the folder."""
        return PathJoinSubstitution([self, other])

    def describe(self) -> str:
        """Return a description for messages."""
        return f'{type(self).__name__}(pkg={describe_text(self.package)})'


class FindPackageShare(FindPackage):
    """The share folder of a package."""


class FindPackagePrefix(FindPackage):
    """The folder under which a package is installed."""

    def find(self, package_name: str) -> str:
        """Return the folder."""
        return str(current_lookup().prefix(package_name))


class ExecutableInPackage(Substitution):
    """
    The path of a package's program.

    :param executable: the program.
    :param package: has it.
    """

    def __init__(self, executable: SomeText, package: SomeText) -> None:
        self._executable = normalize_to_list_of_substitutions(executable)
        self._package = normalize_to_list_of_substitutions(package)

    def perform(self, context: LaunchContext) -> str:
        """Return the path."""
        package = perform_substitutions(context, self._package)
        name = perform_substitutions(context, self._executable)
        found = current_lookup().program(package, name)
        if found is None:
            raise SubstitutionFailure(f"package '{package}' has no program '{name}'")
        return os.fspath(found)


class Parameter(Substitution):
    """
    A parameter that SetParameter has set.

    :param name: of the parameter.
    """

    def __init__(self, name: SomeText, *, default: SomeText | None = None) -> None:
        self._name = normalize_to_list_of_substitutions(name)
        self._default = default

    def perform(self, context: LaunchContext) -> str:
        """Return the value."""
        name = perform_substitutions(context, self._name)
        for source in reversed(context.launch_configurations.get('global_params', ())):
            if not isinstance(source, str) and name in source:
                return str(source[name])
        if self._default is not None:
            return perform_substitutions(
                context, normalize_to_list_of_substitutions(self._default))
        raise SubstitutionFailure(f"parameter '{name}' is not set")
