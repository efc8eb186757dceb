# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The base classes of a launch description, and the state of a launch that they see."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
import os
from pathlib import Path
import sys
from types import SimpleNamespace
from typing import Any, TYPE_CHECKING, Union

from typing_extensions import Self

from armsim_ros.errors import Location
from armsim_ros.launch.failures import SubstitutionFailure

if TYPE_CHECKING:
    from armsim_ros.launch.engine import Engine


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


class LaunchContext:
    """
    The state that substitutions and actions read and write.

    :param argv: the words of the command line.
    :param engine: runs the launch; None while nothing runs.
    """

    def __init__(
        self, *, argv: Iterable[str] | None = None, noninteractive: bool = True,
        engine: Engine | None = None,
    ) -> None:
        self.argv = list(argv or ())
        self.noninteractive = noninteractive
        self.engine = engine
        self.launch_configurations: dict[str, Any] = {}
        self.environment: dict[str, str] = dict(os.environ)
        self.is_shutdown = False
        self.asyncio_loop = None
        self._globals: dict[str, Any] = {}
        self._locals: list[dict[str, Any]] = [{}]
        self._configurations: list[dict[str, Any]] = []
        self._environments: list[dict[str, str]] = []

    def perform_substitution(self, substitution: Substitution) -> str:
        """
        Return the text of a substitution.

        :raises SubstitutionFailure: where it has none; with the line that made it.
        """
        try:
            return substitution.perform(self)
        except SubstitutionFailure as failure:
            raise failure.at(substitution.where) from None

    # Configurations and environment, scoped by groups.

    def push_launch_configurations(self) -> None:
        """Begin a scope."""
        self._configurations.append(dict(self.launch_configurations))

    def pop_launch_configurations(self) -> None:
        """End a scope, restoring the configurations from before it."""
        self.launch_configurations = self._configurations.pop()

    def push_environment(self) -> None:
        """Begin a scope of the environment."""
        self._environments.append(dict(self.environment))

    def pop_environment(self) -> None:
        """End a scope of the environment."""
        self.environment = self._environments.pop()

    # Values by name, as event handlers and OpaqueFunctions use them.

    @property
    def locals(self) -> SimpleNamespace:
        """The values of the current scope."""
        return SimpleNamespace(**self.get_locals_as_dict())

    def get_locals_as_dict(self) -> dict[str, Any]:
        """Return the values of the current scope."""
        return {**self._globals, **self._locals[-1]}

    def extend_globals(self, extension: Mapping[str, Any]) -> None:
        """Add values for the rest of the launch."""
        self._globals.update(extension)

    def extend_locals(self, extension: Mapping[str, Any]) -> None:
        """Add values to the current scope."""
        self._locals[-1].update(extension)

    def push_locals(self) -> None:
        """Begin a scope of values that starts as a copy of its parent scope."""
        self._locals.append(dict(self._locals[-1]))

    def pop_locals(self) -> None:
        """End a scope of values."""
        self._locals.pop()

    # Events.

    def register_event_handler(self, handler: Any, append: bool = False) -> None:
        """Register a handler for events from now on."""
        if self.engine is not None:
            self.engine.capture_scope(handler)
            self.engine.handlers.insert(len(self.engine.handlers) if append else 0, handler)

    def unregister_event_handler(self, handler: Any) -> None:
        """Unregister a handler."""
        if self.engine is not None and handler in self.engine.handlers:
            self.engine.handlers.remove(handler)

    def emit_event_sync(self, event: Any) -> None:
        """Queue an event."""
        if self.engine is not None:
            self.engine.emit(event)

    async def emit_event(self, event: Any) -> None:
        """Queue an event."""
        self.emit_event_sync(event)

    @property
    def current_file(self) -> str:
        """The launch file that is being visited, '' if there is none."""
        return str(self.get_locals_as_dict().get('current_launch_file_path', ''))
