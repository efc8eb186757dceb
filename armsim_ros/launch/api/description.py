# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""LaunchDescription: what a launch file returns; what shows it, and what would run it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from armsim_ros.launch.api.actions.configuration import declared_arguments, DeclareLaunchArgument
from armsim_ros.launch.api.context import LaunchContext, LaunchDescriptionEntity
from armsim_ros.launch.api.utilities import normalize_to_list_of_entities
from armsim_ros.launch.failures import LaunchError


class LaunchDescription(LaunchDescriptionEntity):
    """
    Entities that are visited in order.

    :param initial_entities: the first of them.
    """

    def __init__(
        self, initial_entities: Iterable[Any] | None = None, *,
        deprecated_reason: str | None = None,
    ) -> None:
        self._entities = normalize_to_list_of_entities(initial_entities or ())
        self.deprecated_reason = deprecated_reason

    @property
    def entities(self) -> list[LaunchDescriptionEntity]:
        """What is visited."""
        return self._entities

    @property
    def deprecated(self) -> bool:
        """Whether its file should no longer be used."""
        return self.deprecated_reason is not None

    def add_entity(self, entity: Any) -> None:
        """Add an entity at the end."""
        self._entities += normalize_to_list_of_entities([entity])

    def add_action(self, action: Any) -> None:
        """Add an action at the end."""
        self.add_entity(action)

    def visit(self, context: LaunchContext) -> Iterable[LaunchDescriptionEntity]:
        """Return the entities."""
        if self.deprecated_reason and context.engine is not None:
            context.engine.log('WARNING', f'deprecated launch file: {self.deprecated_reason}')
        return self._entities

    def describe_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the entities."""
        return self._entities

    def get_launch_arguments(self, conditional_inclusion: bool = False
                             ) -> list[DeclareLaunchArgument]:
        """Return the arguments that it declares, without those of includes."""
        return declared_arguments(self._entities)


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
