# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Substitutions of configurations, environment and scope, and comparisons of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
import math
import os
from typing import Any

from armsim_ros.errors import nearest
from armsim_ros.launch.api.configuration import evaluate_condition_expression
from armsim_ros.launch.api.context import (
    describe_text,
    LaunchContext,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    perform_text,
    SomeText,
    Substitution,
)
from armsim_ros.launch.failures import SubstitutionFailure


class LaunchConfiguration(Substitution):
    """
    The value of a configuration or argument.

    :param variable_name: its name.
    :param default: where it is not set; if None, that is a failure.
    """

    def __init__(self, variable_name: SomeText, *, default: Any = None) -> None:
        self.variable_name = normalize_to_list_of_substitutions(variable_name)
        if isinstance(default, (bool, int, float)):
            default = str(default)
        self.default = None if default is None else normalize_to_list_of_substitutions(default)

    def perform(self, context: LaunchContext) -> str:
        """Return the value."""
        name = perform_substitutions(context, self.variable_name)
        if name in context.launch_configurations:
            return str(context.launch_configurations[name])
        if self.default is not None:
            return perform_substitutions(context, self.default)
        known = tuple(context.launch_configurations)
        hint = nearest(name, known)
        raise SubstitutionFailure(f"launch configuration '{name}' does not exist"
                                  + (f'; {hint}' if hint else ''))

    def describe(self) -> str:
        """Return a description for messages."""
        return f'LaunchConfig({describe_text(self.variable_name)})'


class EnvironmentVariable(Substitution):
    """
    The value of an environment variable.

    :param name: its name.
    :param default_value: where it is not set; if None, that is a failure.
    """

    def __init__(self, name: SomeText, *, default_value: SomeText | None = None) -> None:
        self._name = normalize_to_list_of_substitutions(name)
        self._default = (None if default_value is None
                         else normalize_to_list_of_substitutions(default_value))

    def perform(self, context: LaunchContext) -> str:
        """Return the value."""
        name = perform_substitutions(context, self._name)
        if name in context.environment:
            return context.environment[name]
        if self._default is not None:
            return perform_substitutions(context, self._default)
        raise SubstitutionFailure(f"environment variable '{name}' is not set")

    def describe(self) -> str:
        """Return a description for messages."""
        return f'EnvVar({describe_text(self._name)})'


class StringJoinSubstitution(Substitution):
    """
    Several texts joined by a delimiter.

    :param substitutions: the texts.
    """

    def __init__(self, substitutions: Iterable[SomeText], delimiter: SomeText = '') -> None:
        self._parts = list(substitutions)
        self._delimiter = delimiter

    def perform(self, context: LaunchContext) -> str:
        """Return the text."""
        return perform_text(context, self._delimiter).join(
            perform_text(context, part) for part in self._parts)


class AnonName(Substitution):
    """
    A unique name, the same for the same text.

    :param name: its begin.
    """

    def __init__(self, name: SomeText) -> None:
        self._name = normalize_to_list_of_substitutions(name)

    def perform(self, context: LaunchContext) -> str:
        """Return the name."""
        text = perform_substitutions(context, self._name)
        key = f'anon_{text}'
        if key not in context.launch_configurations:
            context.launch_configurations[key] = f'{text}_{os.getpid()}_{os.urandom(4).hex()}'
        return str(context.launch_configurations[key])


class LocalSubstitution(Substitution):
    """
    A value of the current scope, such as ``event.name`` in an event handler.

    :param expression: names with dots.
    """

    def __init__(self, expression: str, description: str | None = None) -> None:
        self._names = expression.split('.')
        self._description = description

    def perform(self, context: LaunchContext) -> str:
        """Return the value."""
        value: Any = context.get_locals_as_dict()
        for name in self._names:
            known = value if isinstance(value, dict) else vars(value) if hasattr(
                value, '__dict__') else {}
            if isinstance(value, dict) and name in value:
                value = value[name]
            elif hasattr(value, name):
                value = getattr(value, name)
            else:
                raise SubstitutionFailure(f"local '{name}' does not exist",
                                          None) from (KeyError(name) if not known else None)
        return str(value)


class ForLoopIndex(LocalSubstitution):
    """
    The index of a ForLoop.

    :param name: of the index.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)


class ForEachVar(LocalSubstitution):
    """
    A variable of a ForEach.

    :param name: of the variable.
    """

    def __init__(self, name: str, default_value: SomeText | None = None) -> None:
        super().__init__(name)
        self._default = default_value

    def perform(self, context: LaunchContext) -> str:
        """Return the value."""
        try:
            return super().perform(context)
        except SubstitutionFailure:
            if self._default is None:
                raise
            return perform_text(context, self._default)


class IfElseSubstitution(Substitution):
    """
    Either of two texts.

    :param condition: gives true or false.
    """

    def __init__(self, condition: SomeText, if_value: SomeText = '', else_value: SomeText = ''
                 ) -> None:
        self._condition = condition
        self._values = (else_value, if_value)

    def perform(self, context: LaunchContext) -> str:
        """Return the text that the condition chooses."""
        from armsim_ros.launch.api.configuration import evaluate_condition_expression

        chosen = self._values[evaluate_condition_expression(context, self._condition)]
        return perform_text(context, chosen)


def parts_of(values: Sequence[Any]) -> list[SomeText]:
    """Return parts that were given one by one or as one sequence."""
    if len(values) == 1 and isinstance(values[0], (list, tuple)):
        return list(values[0])
    return list(values)


class _Combination(Substitution):
    """A combination of booleans, given one by one or as a sequence."""

    def __init__(self, *values: Any) -> None:
        self._values = parts_of(values)

    def perform(self, context: LaunchContext) -> str:
        truths = [evaluate_condition_expression(context, value) for value in self._values]
        return 'true' if self._holds(truths) else 'false'

    def _holds(self, truths: Sequence[bool]) -> bool:
        raise NotImplementedError


class AndSubstitution(_Combination):
    """True if all are."""

    def _holds(self, truths: Sequence[bool]) -> bool:
        return all(truths)


class OrSubstitution(_Combination):
    """True if any is."""

    def _holds(self, truths: Sequence[bool]) -> bool:
        return any(truths)


class NotSubstitution(_Combination):
    """True if the other is false."""

    def _holds(self, truths: Sequence[bool]) -> bool:
        return not truths[0]


class AllSubstitution(AndSubstitution):
    """True if all are."""


class AnySubstitution(OrSubstitution):
    """True if any is."""


class EqualsSubstitution(Substitution):
    """
    True if two values are equal, as booleans, numbers or strings.

    :param left: a text, number, truth or None.
    """

    def __init__(self, left: Any, right: Any) -> None:
        self._sides = (_plain(left), _plain(right))

    def perform(self, context: LaunchContext) -> str:
        """Compare."""
        return 'true' if self._equal(context) else 'false'

    def _equal(self, context: LaunchContext) -> bool:
        texts = [perform_text(context, side) for side in self._sides]
        left, right = texts
        for read in (_truth, _number):
            first, other = map(read, texts)
            if first is not None and other is not None:
                return math.isclose(first, other)
        return left == right


class NotEqualsSubstitution(EqualsSubstitution):
    """True if two values differ."""

    def perform(self, context: LaunchContext) -> str:
        """Compare."""
        return 'false' if self._equal(context) else 'true'


def _truth(text: str) -> float | None:
    return {'true': 1.0, '1': 1.0, 'false': 0.0, '0': 0.0}.get(text.lower())


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _plain(value: Any) -> SomeText:
    if value is None:
        return ''
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (int, float)):
        return str(value)
    kept: SomeText = value
    return kept
