# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Substitutions of paths and of the content of files."""

from __future__ import annotations

from collections.abc import Iterable
import os
from pathlib import Path

from armsim_ros.launch.api.context import LaunchContext, SomeText, Substitution
from armsim_ros.launch.api.utilities import (
    describe_text,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)
from armsim_ros.launch.failures import SubstitutionFailure
from armsim_ros.launch.lookup import check_not_missing


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
