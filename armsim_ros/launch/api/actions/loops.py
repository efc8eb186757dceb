# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actions that repeat others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
import inspect
from typing import Any

import yaml

from armsim_ros.launch.api.context import LaunchContext
from armsim_ros.launch.api.entity import Action, LaunchDescriptionEntity, SomeText
from armsim_ros.launch.api.utilities import (
    entities_of_result,
    normalize_to_list_of_entities,
    perform_text,
)
from armsim_ros.launch.failures import LaunchError

Entities = list[LaunchDescriptionEntity]


class ForLoop(Action):
    """
    Calls a function for each number.

    :param length: how often, a text.
    :param function: is called with the number, returns entities.
    """

    def __init__(
        self, length: SomeText, *, function: Callable[..., Any] | None = None,
        name: str | None = None, entities: Iterable[Any] | None = None, **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._length, self._function, self._name = length, function, name
        self._entities = normalize_to_list_of_entities(entities or ())

    def execute(self, context: LaunchContext) -> Entities:
        """Return the entities of every round."""
        text = perform_text(context, self._length)
        try:
            count = int(text)
        except ValueError:
            raise LaunchError(f"the length of a ForLoop is '{text}'; allowed: a whole number",
                                self.where) from None
        return [entity for number in range(count) for entity in self._round(number)]

    def _round(self, number: int) -> Entities:
        if self._function is not None:
            return entities_of_result(self._function(number), self.where) or []
        return [_ExtendLocals({self._name or 'i': number}), *self._entities]


class ForEach(Action):
    """
    Calls a function for each set of values.

    :param input_values: blocks of YAML, parted by semicolons.
    :param function: is called with the values of a block by name, returns entities.
    """

    def __init__(
        self, input_values: SomeText, *, function: Callable[..., Any] | None = None,
        entities: Iterable[Any] | None = None, **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self._values, self._function = input_values, function
        self._entities = normalize_to_list_of_entities(entities or ())

    def execute(self, context: LaunchContext) -> Entities:
        """Return the entities of every round."""
        found: Entities = []
        for text in perform_text(context, self._values).split(';'):
            if not text.strip():
                continue
            try:
                values = yaml.safe_load(text)
            except yaml.YAMLError as error:
                raise LaunchError(f"values of ForEach: '{text}' is not YAML: {error}",
                                    self.where) from None
            values = values if isinstance(values, dict) else {}
            if self._function is not None:
                requested = inspect.signature(self._function).parameters
                given = {name: values[name] for name in requested if name in values}
                found += entities_of_result(self._function(**given), self.where) or []
            else:
                found += [_ExtendLocals(values), *self._entities]
        return found


class _ExtendLocals(Action):
    """Sets values of the scope."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        super().__init__()
        self._values = dict(values)

    def execute(self, context: LaunchContext) -> None:
        context.extend_locals(self._values)
