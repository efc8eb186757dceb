# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Text from substitutions, and typed values from text."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
import os
from typing import Any

import yaml

from armsim_ros.errors import Location
from armsim_ros.launch.api.context import (
    LaunchContext,
    LaunchDescriptionEntity,
    SomeText,
    Substitution,
)
from armsim_ros.launch.failures import LaunchError

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
                      for substitution in normalize_to_list_of_substitutions(text))


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


def create_future(_loop: Any) -> None:
    """Return None: the event loop keeps track of what to wait for."""
    return None


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


def ensure_argument_type(argument: Any, types: Any, name: str, caller: str | None = None) -> None:
    """Refuse an argument of a wrong type with a TypeError, as launch does."""
    kinds = tuple(types) if isinstance(types, Sequence) else (types,)
    if not isinstance(argument, kinds):
        names = ', '.join(kind.__name__ for kind in kinds)
        raise TypeError(f"{caller + ': ' if caller else ''}'{name}' is '{argument}' of type "
                        f'{type(argument).__name__}; allowed: {names}')


def is_a(value: Any, kind: type) -> bool:
    """Return whether a value is of a type."""
    return isinstance(value, kind)


def is_a_subclass(value: Any, kind: type) -> bool:
    """Return whether a value is a subclass of another."""
    return isinstance(value, type) and issubclass(value, kind)
