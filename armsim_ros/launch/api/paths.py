# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Substitutions of paths, of the content of files and of packages; ament_index_python."""

from __future__ import annotations

from collections.abc import Iterable
import os
from pathlib import Path
import re
from typing import Any

from armsim_ros.launch.api.context import (
    describe_text,
    LaunchContext,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    SomeText,
    Substitution,
)
from armsim_ros.launch.failures import MissingPackageError, SubstitutionFailure
from armsim_ros.launch.lookup import check_not_missing, current_lookup, NOWHERE
from armsim_ros.packages import sourced_prefixes


class PathJoinSubstitution(Substitution):
    """
    The parts of a path, joined.

    :param substitutions: the parts; each a text, a substitution, or several in a row.
    """

    def __init__(self, substitutions: Iterable[SomeText]) -> None:
        self._parts = [normalize_to_list_of_substitutions(part) for part in substitutions]

    def perform(self, context: LaunchContext) -> str:
        """Return the path."""
        return os.path.join(*(perform_substitutions(context, part) for part in self._parts))

    def __truediv__(self, other: SomeText) -> PathJoinSubstitution:
        """Return the path with one more part."""
        return PathJoinSubstitution([*self._parts, normalize_to_list_of_substitutions(other)])

    def describe(self) -> str:
        """Return a description for messages."""
        return f"PathJoin({', '.join(map(describe_text, self._parts))})"


class PathSubstitution(PathJoinSubstitution):
    """
    A path that grows with ``/``.

    :param path: its begin.
    """

    def __init__(self, path: SomeText) -> None:
        super().__init__([path])


class ThisLaunchFile(Substitution):
    """The path of the launch file that is being visited."""

    def perform(self, context: LaunchContext) -> str:
        """Return the path."""
        if not context.current_file:
            raise SubstitutionFailure('ThisLaunchFile: no launch file is being visited')
        return context.current_file

    def describe(self) -> str:
        """Return a description for messages."""
        return 'ThisLaunchFile()'


class ThisLaunchFileDir(ThisLaunchFile):
    """The folder of the launch file that is being visited."""

    def perform(self, context: LaunchContext) -> str:
        """Return the folder."""
        return os.path.dirname(super().perform(context))

    def __truediv__(self, other: SomeText) -> PathJoinSubstitution:
        """Return a path below the folder."""
        return PathJoinSubstitution([self, other])

    def describe(self) -> str:
        """Return a description for messages."""
        return 'ThisLaunchFileDir()'


class LaunchLogDir(Substitution):
    """The folder for the logs of this launch."""

    def perform(self, context: LaunchContext) -> str:
        """Return ROS's own log folder."""
        variables = context.environment
        home = variables.get('ROS_HOME') or str(Path.home() / '.ros')
        return variables.get('ROS_LOG_DIR') or os.path.join(home, 'log')


class FileContent(Substitution):
    """
    The content of a file.

    :param path: of the file.
    """

    def __init__(self, path: SomeText) -> None:
        self._path = normalize_to_list_of_substitutions(path)

    def perform(self, context: LaunchContext) -> str:
        """Return the text."""
        path = perform_substitutions(context, self._path)
        check_not_missing(path)
        try:
            return Path(path).read_text(encoding='utf-8')
        except OSError as error:
            raise SubstitutionFailure(f"file '{path}' cannot be read: {error.strerror}") from None


def get_package_share_directory(package_name: Any, print_warning: bool = True) -> str:
    """
    Return the share folder of a package, or its sources.

    :raises MissingPackageError: where it is nowhere.
    """
    _check(package_name)
    return str(current_lookup().share(str(package_name)))


def get_package_share_path(package_name: Any, print_warning: bool = True) -> Path:
    """Return the same as a path."""
    return Path(get_package_share_directory(package_name))


def get_package_prefix(package_name: Any) -> str:
    """Return the folder under which a package is installed; of sources, the sources."""
    _check(package_name)
    return str(current_lookup().prefix(str(package_name)))


def get_packages_with_prefixes() -> dict[str, str]:
    """Return name -> prefix of all packages."""
    lookup = current_lookup()
    return {name: str(lookup.prefix(name)) for name in lookup.packages.names()}


def get_search_paths() -> list[str]:
    """Return the prefixes that packages are installed under."""
    return [str(prefix) for prefix in sourced_prefixes() if prefix.is_dir()]


def has_resource(resource_type: str, resource_name: str) -> str | bool:
    """Return the prefix that has a resource, False where none has."""
    if resource_type == 'packages':
        found = current_lookup().find(resource_name)
        return str(found) if found is not None else False
    for prefix in get_search_paths():
        if os.path.isfile(_resource(prefix, resource_type, resource_name)):
            return prefix
    return False


def get_resource(resource_type: str, resource_name: str) -> tuple[str, str]:
    """
    Return content and prefix of a resource.

    :raises LookupError: where no prefix has it.
    """
    for prefix in get_search_paths():
        path = _resource(prefix, resource_type, resource_name)
        if os.path.isfile(path):
            return Path(path).read_text(encoding='utf-8'), prefix
    raise LookupError(f"no resource '{resource_name}' of type '{resource_type}'")


def get_resources(resource_type: str) -> dict[str, str]:
    """Return name -> prefix of all resources of a type."""
    found: dict[str, str] = {}
    for prefix in get_search_paths():
        folder = os.path.dirname(_resource(prefix, resource_type, 'x'))
        for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else ():
            found.setdefault(name, prefix)
    return found


def _resource(prefix: str, kind: str, name: str) -> str:
    return os.path.join(prefix, 'share', 'ament_index', 'resource_index', kind, name)


def _check(name: Any) -> None:
    if not re.fullmatch(r'[a-zA-Z0-9_-]+', str(name)):
        raise ValueError(f"'{name}' is not a name of a package")


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
