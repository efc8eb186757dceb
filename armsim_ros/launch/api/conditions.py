# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Conditions of actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from armsim_ros.launch.api.context import LaunchContext, Placed, SomeText
from armsim_ros.launch.api.utilities import describe_text, perform_text, to_bool
from armsim_ros.launch.failures import LaunchError


class InvalidConditionExpressionError(LaunchError):
    """A condition is neither true nor false."""


class Condition(Placed):
    """
    A predicate over the context.

    :param predicate: returns whether the condition holds.
    """

    def __init__(self, *, predicate: Callable[[LaunchContext], bool] | None = None) -> None:
        self._predicate = predicate

    def evaluate(self, context: LaunchContext) -> bool:
        """Return whether it holds."""
        return self._predicate is None or bool(self._predicate(context))

    def _predicate_func(self, context: LaunchContext) -> bool:
        """Return whether it holds; some launch files call this private name of upstream."""
        return self.evaluate(context)

    def describe(self) -> str:
        """Return a description for messages."""
        return type(self).__name__


def evaluate_condition_expression(context: LaunchContext, expression: SomeText) -> bool:
    """
    Return the truth of a text.

    :raises InvalidConditionExpressionError: where it is neither true, false, 1 nor 0.
    """
    try:
        return to_bool(perform_text(context, expression), 'a condition')
    except LaunchError as failure:
        raise InvalidConditionExpressionError(failure.what, failure.where) from None


class IfCondition(Condition):
    """
    Holds if a text is true.

    :param predicate_expression: gives true, false, 1 or 0.
    """

    def __init__(self, predicate_expression: SomeText | Any) -> None:
        super().__init__()
        self._expression = predicate_expression
        describe_text(predicate_expression)

    def evaluate(self, context: LaunchContext) -> bool:
        """Return whether the text is true."""
        try:
            return evaluate_condition_expression(context, self._expression)
        except LaunchError as failure:
            raise failure.at(self.where) from None

    def describe(self) -> str:
        """Return a description for messages."""
        return f'{type(self).__name__}({describe_text(self._expression)})'


class UnlessCondition(IfCondition):
    """Holds if a text is false."""

    def evaluate(self, context: LaunchContext) -> bool:
        """Return whether the text is false."""
        return not super().evaluate(context)


class LaunchConfigurationEquals(Condition):
    """
    Holds if a configuration has a given value.

    :param launch_configuration_name: of the configuration.
    :param expected_value: None for: it is not set.
    """

    def __init__(self, launch_configuration_name: str, expected_value: SomeText | None) -> None:
        super().__init__()
        self._name = launch_configuration_name
        self._expected = expected_value

    def evaluate(self, context: LaunchContext) -> bool:
        """Compare."""
        value = context.launch_configurations.get(self._name)
        if self._expected is None or value is None:
            return self._expected is None and value is None
        return bool(value == perform_text(context, self._expected))


class LaunchConfigurationNotEquals(LaunchConfigurationEquals):
    """Holds if a configuration does not have a given value."""

    def evaluate(self, context: LaunchContext) -> bool:
        """Compare."""
        return not super().evaluate(context)
