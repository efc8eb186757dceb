# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Functions of launch.utilities that users' actions and substitutions call."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from armsim_ros.launch.api.context import LaunchContext, normalize_to_list_of_substitutions
from armsim_ros.launch.api.ros_parameters import is_text, ParameterValue


def normalize_typed_substitution(value: Any, data_type: Any) -> Any:
    """Return a value for perform_typed_substitution: substitutions as a list, others as is."""
    if is_text(value) and not isinstance(value, str):
        return normalize_to_list_of_substitutions(value)
    return value


def perform_typed_substitution(context: LaunchContext, value: Any, data_type: Any) -> Any:
    """
    Return a value, that of substitutions with a type.

    :param data_type: None for the type that YAML sees.
    :raises LaunchError: where it is not of its type.
    """
    return ParameterValue(value, value_type=data_type).evaluate(context)


def create_future(_loop: Any) -> None:
    """Return None: the event loop keeps track of what to wait for."""
    return None


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
