# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""LaunchService, for launch files that are run as scripts, and LaunchIntrospector."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from armsim_ros.launch.api.context import LaunchContext
from armsim_ros.launch.api.description import LaunchDescription
from armsim_ros.launch.api.entity import LaunchDescriptionEntity
from armsim_ros.launch.api.utilities import normalize_to_list_of_entities
from armsim_ros.launch.failures import LaunchError


class LaunchService:
    """
    Replaces launch's service; ``armsim launch`` itself runs the descriptions.

    :param argv: the words of the command line.
    """

    def __init__(self, *, argv: Iterable[str] | None = None, **_kwargs: Any) -> None:
        self.context = LaunchContext(argv=argv)
        self._descriptions: list[LaunchDescription] = []

    def include_launch_description(self, launch_description: Any) -> None:
        """Remember a description."""
        self._descriptions.append(launch_description)

    def run(self, **_kwargs: Any) -> int:
        """Refuse: the launch that evaluates this file is running."""
        raise LaunchError('a launch file cannot run a LaunchService of its own; return the '
                            'description from generate_launch_description()')

    def shutdown(self) -> None:
        """Do nothing: nothing runs."""


class LaunchIntrospector:
    """Shows what is in a description."""

    def format_launch_description(self, launch_description: LaunchDescription) -> str:
        """Return it as a tree of lines."""
        return '\n'.join(format_entities(launch_description.entities))

    def get_launch_description(self) -> None:
        """Return None: nothing is read."""


def format_entities(entities: Iterable[LaunchDescriptionEntity], indent: str = '') -> list[str]:
    """Return entities and those inside them as a tree of lines."""
    lines: list[str] = []
    for entity in entities:
        lines.append(f'{indent}{entity.describe()}')
        lines += format_entities(entity.describe_sub_entities(), indent + '  ')
        for when, inside in entity.describe_conditional_sub_entities():
            lines.append(f'{indent}  if {when}:')
            lines += format_entities(normalize_to_list_of_entities(inside), indent + '    ')
    return lines
