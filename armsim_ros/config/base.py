# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The base of all settings: frozen, checked, unknown keys refused."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


class Settings(BaseModel):
    """A block of settings; it never changes after it was read."""

    model_config = ConfigDict(
        frozen=True, extra='forbid', arbitrary_types_allowed=True, validate_default=True
    )


def parameter(
    default: Any = ..., description: str = '', *, read_only: bool = False, **constraints: Any
) -> Any:
    """
    Declare a field that is also a ROS parameter.

    :param default: the default; ``...`` where the user must give a value.
    :param description: what it means, with the unit in brackets.
    :param read_only: whether it keeps its value after the controller was loaded.
    :param constraints: pydantic's ``ge``, ``gt``, ``le``, ``lt``, ``alias`` ...
    """
    return Field(
        default, description=description, json_schema_extra={'read_only': read_only}, **constraints
    )
