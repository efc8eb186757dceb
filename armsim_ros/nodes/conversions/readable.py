# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Lists of messages of which some cannot be read."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from armsim_ros.errors import PlanningError

Value = TypeVar('Value')


def readable(
    convert: Callable[[Any], Value], messages: Iterable[Any]
) -> tuple[tuple[Value, ...], tuple[PlanningError, ...]]:
    """Return what could be converted, and why the rest could not."""
    values: list[Value] = []
    errors: list[PlanningError] = []
    for message in messages:
        try:
            values.append(convert(message))
        except PlanningError as error:
            errors.append(error)
    return tuple(values), tuple(errors)
