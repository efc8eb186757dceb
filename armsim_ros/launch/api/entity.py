# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The base classes of a launch description: entity, action, substitution."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
import os
from pathlib import Path
import sys
from typing import Any, TYPE_CHECKING, Union

from typing_extensions import Self

from armsim_ros.errors import Location

if TYPE_CHECKING:
    from armsim_ros.launch.api.context import LaunchContext

_OWN_FOLDER = str(Path(__file__).resolve().parent.parent) + os.sep


def calling_place() -> Location | None:
    """Return the line of the launch file, or of the user's other code, that is being run."""
    frame = sys._getframe(1)
    while frame is not None:
        name = frame.f_code.co_filename
        if not name.startswith((_OWN_FOLDER, '<')):
            return Location(name, frame.f_lineno)
        if frame.f_back is None:
            break
        frame = frame.f_back
    return None


class Placed:
    """Remembers the line of the launch file that made it."""

    where: Location | None = None

    def __new__(cls, *_args: Any, **_kwargs: Any) -> Self:
        """Make it and remember the line."""
        made = super().__new__(cls)
        made.where = calling_place()
        return made


class Substitution(Placed):
    """A text that is known when the launch runs."""

    def perform(self, context: LaunchContext) -> str:
        """Return the text."""
        raise NotImplementedError(f'{type(self).__name__} has no perform()')

    def describe(self) -> str:
        """Return a description of the text for messages."""
        return f"{type(self).__name__}('')"


SomeText = Union[str, 'os.PathLike[str]', Substitution,
                 Sequence[Union[str, 'os.PathLike[str]', Substitution]]]


class LaunchDescriptionEntity(Placed):
    """Anything that a launch description may contain."""

    def visit(self, context: LaunchContext) -> Iterable[LaunchDescriptionEntity] | None:
        """Execute it and return the entities to visit next."""
        raise NotImplementedError(f'{type(self).__name__} has no visit()')

    def describe(self) -> str:
        """Return its name for messages."""
        return type(self).__name__

    def describe_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the entities that are always visited after it."""
        return []

    def describe_conditional_sub_entities(
        self,
    ) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """Return the entities that may be visited after it."""
        return []

    def get_asyncio_future(self) -> None:
        """Return None: the event loop keeps track of what to wait for."""
        return None


class Action(LaunchDescriptionEntity):
    """
    Something to do, if its condition holds.

    :param condition: with ``evaluate(context)``, or a function of the context.
    """

    def __init__(self, *, condition: Any = None) -> None:
        self._condition = condition

    @property
    def condition(self) -> Any:
        """The condition, None if there is none."""
        return getattr(self, '_condition', None)

    @classmethod
    def parse(cls, entity: Any, parser: Any) -> tuple[type[Self], dict[str, Any]]:
        """Return the class and keyword arguments for an element of an XML or YAML file."""
        condition = parser.condition_of(entity)
        return cls, {} if condition is None else {'condition': condition}

    def visit(self, context: LaunchContext) -> Iterable[LaunchDescriptionEntity] | None:
        """Execute it if its condition holds."""
        condition = self.condition
        if condition is not None:
            holds = (condition.evaluate(context) if hasattr(condition, 'evaluate')
                     else condition(context))
            if not holds:
                return None
        return self.execute(context)

    def execute(self, context: LaunchContext) -> Iterable[LaunchDescriptionEntity] | None:
        """Do it."""
        return None
