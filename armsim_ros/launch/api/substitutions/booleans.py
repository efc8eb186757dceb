# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Boolean substitutions: comparisons and combinations of them."""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import Any

from armsim_ros.launch.api.conditions import evaluate_condition_expression
from armsim_ros.launch.api.context import LaunchContext, SomeText, Substitution
from armsim_ros.launch.api.substitutions.texts import parts_of
from armsim_ros.launch.api.utilities import as_yaml_value, perform_text


class _Combination(Substitution):
    """
    A combination of several booleans.

    :param values: each true or false; one by one or as one sequence.
    """

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
        left, right = (perform_text(context, side) for side in self._sides)
        if left == right:
            return True
        first, other = as_yaml_value(left), as_yaml_value(right)
        numbers = all(isinstance(each, (int, float)) for each in (first, other))
        if numbers and isinstance(first, bool) is isinstance(other, bool):
            return math.isclose(float(first), float(other))
        return False


class NotEqualsSubstitution(EqualsSubstitution):
    """True if two values differ."""

    def perform(self, context: LaunchContext) -> str:
        """Compare."""
        return 'false' if self._equal(context) else 'true'


def _plain(value: Any) -> SomeText:
    if value is None:
        return ''
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (int, float)):
        return str(value)
    kept: SomeText = value
    return kept
