# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The base classes of a launch description, its texts, and the state of a launch."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, MutableMapping, Sequence
import os
from types import SimpleNamespace
from typing import Any, TYPE_CHECKING, Union

from typing_extensions import Self
import yaml

from armsim_ros.errors import Location
from armsim_ros.launch.failures import LaunchError, Placed, SubstitutionFailure

if TYPE_CHECKING:
    from armsim_ros.launch.engine import Engine


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
        try:
            return self.execute(context)
        finally:
            if context.engine is not None:
                context.engine.executed(self)

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
        engine: Engine | None = None
    ) -> None:
        self.argv = list(argv or ())
        self.noninteractive, self.engine = noninteractive, engine
        self.launch_configurations: dict[str, Any] = {}
        self.is_shutdown = False
        self.asyncio_loop = None
        self._globals: dict[str, Any] = {}
        self._locals: list[dict[str, Any]] = [{}]
        self._configurations: list[dict[str, Any]] = []
        self._environments: list[dict[str, str]] = []
        self._first_environment = dict(os.environ)

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

    @property
    def environment(self) -> MutableMapping[str, str]:
        """The environment of this process, which the processes of the launch inherit."""
        return os.environ

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
        replace_environment(self._environments.pop())

    def reset_environment(self) -> None:
        """Restore the environment that the launch began with."""
        replace_environment(self._first_environment)

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


def replace_environment(variables: Mapping[str, str]) -> None:
    """Make these the environment of this process."""
    os.environ.clear()
    os.environ.update(variables)


_TRUE = ('true', '1', 'on', 'yes')
_FALSE = ('false', '0', 'off', 'no')


class TextSubstitution(Substitution):
    """
    A plain text.

    :param text: the text.
    """

    def __init__(self, *, text: str) -> None:
        if not isinstance(text, str):
            raise TypeError(
                f"TextSubstitution expected a text, got '{text}' of {type(text).__name__}")
        self.text = text

    def perform(self, context: LaunchContext) -> str:
        """Return the text."""
        return self.text

    def describe(self) -> str:
        """Return it in quotes."""
        return f"'{self.text}'"


def normalize_to_list_of_substitutions(subs: SomeText | Iterable[Any]) -> list[Substitution]:
    """
    Return a text, a substitution, or a sequence of them, as a list of substitutions.

    :raises TypeError: where an item is neither.
    """
    if isinstance(subs, Substitution):
        return [subs]
    if isinstance(subs, str):
        return [TextSubstitution(text=subs)]
    if isinstance(subs, os.PathLike):
        return [TextSubstitution(text=os.fspath(subs))]
    if isinstance(subs, Iterable):
        return [substitution for item in subs
                for substitution in normalize_to_list_of_substitutions(item)]
    raise TypeError(f"a text or a substitution is needed, not '{subs}' "
                    f'of type {type(subs).__name__}')


def perform_substitutions(context: LaunchContext, subs: Iterable[Substitution]) -> str:
    """Return the concatenated texts of substitutions."""
    return ''.join(context.perform_substitution(substitution) for substitution in subs)


def perform_text(context: LaunchContext, text: SomeText | Iterable[Any]) -> str:
    """Return a text, a substitution, or a sequence of them, as a single text."""
    return perform_substitutions(context, normalize_to_list_of_substitutions(text))


def normalize_to_list_of_entities(
    entities: Iterable[Any],
) -> list[LaunchDescriptionEntity]:
    """Return nested sequences of entities as a flat list."""
    flat: list[LaunchDescriptionEntity] = []
    for entity in entities:
        if isinstance(entity, (list, tuple)):
            flat += normalize_to_list_of_entities(entity)
        elif entity is not None:
            flat.append(entity)
    return flat


def describe_text(text: SomeText | Iterable[Any]) -> str:
    """Return a description of a text for messages."""
    return ' + '.join(substitution.describe()
                      for substitution in normalize_to_list_of_substitutions(text)) or "''"


def to_bool(text: str, what: str) -> bool:
    """
    Return a text as a boolean.

    :param what: the expression's kind, for the message.
    :raises LaunchError: for any other text.
    """
    word = text.strip().lower()
    if word in _TRUE:
        return True
    if word in _FALSE:
        return False
    raise LaunchError(f"{what} is '{text}'; allowed: true, false, 1, 0")


def as_yaml_value(text: str) -> Any:
    """
    Return a text's value in YAML: number, boolean, list or the text itself.

    What YAML cannot read, or reads as a block of keys, is the text.
    """
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        return text
    if value is None and text.strip() not in ('', '~', 'null', 'Null', 'NULL'):
        return text
    if isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, list) and not any(isinstance(item, (dict, list)) for item in value):
        return value
    return text


def coerce(text: Any, kind: Any) -> Any:
    """
    Return a text as a value of a type.

    :param kind: bool, int, float, str, ``list`` of these (``List[int]``), or None for YAML's.
    :raises LaunchError: where the text is no such value.
    """
    if not isinstance(text, str):
        return text
    if kind is str:
        return text
    value = yaml.safe_load(text) if kind not in (None, Any) else as_yaml_value(text)
    if kind in (None, Any):
        return value
    inner = getattr(kind, '__args__', None)
    if inner:
        items = value if isinstance(value, list) else [value]
        return [inner[0](item) if inner[0] in (int, float, str, bool) else item for item in items]
    if kind is bool:
        return to_bool(text, 'a true/false value')
    if kind is float and isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if kind is float:
        try:
            return float(text)
        except ValueError:
            pass
    if isinstance(value, kind):
        return value
    raise LaunchError(f"'{text}' is not a valid {getattr(kind, '__name__', kind)}")


def entities_of_result(result: Any, where: Location | None
                       ) -> list[LaunchDescriptionEntity] | None:
    """
    Return the result of a user's function as a list of entities.

    :param where: the line of the action that called the function.
    :raises LaunchError: where it is none.
    """
    if result is None:
        return None
    if isinstance(result, LaunchDescriptionEntity):
        return [result]
    if isinstance(result, Iterable):
        return normalize_to_list_of_entities(result)
    raise LaunchError(f"the function returned '{result}' of type {type(result).__name__}; "
                      'allowed: None, or a list of actions', where)
