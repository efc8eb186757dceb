# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The base of all settings (frozen, checked, unknown keys refused) and of those of controllers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, model_validator

from armsim_ros.errors import nearest


class Settings(BaseModel):
    """A block of settings; it never changes after it was read."""

    model_config = ConfigDict(
        frozen=True,
        extra='forbid',
        arbitrary_types_allowed=True,
        validate_default=True,
        # A robot has a few of the many blocks; the others are not made ready at each start.
        defer_build=True,
    )


class KeyedSettings(Settings):
    """Settings that besides their own keys hold a block per name, such as one for each joint."""

    model_config = ConfigDict(extra='allow')
    #: What a key is not that is neither its own nor a block.
    is_no: ClassVar[str] = 'parameter, and no block'

    @model_validator(mode='before')
    @classmethod
    def _only_blocks_beside(cls, data: Any) -> Any:
        if isinstance(data, Mapping):
            for key, value in data.items():
                if key not in cls.model_fields and not isinstance(value, (Mapping, Settings)):
                    hint = nearest(str(key), tuple(cls.model_fields))
                    raise ValueError(f"'{key}' is not a {cls.is_no}{'; ' if hint else ''}{hint}")
        return data


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


def unique_names(names: tuple[str, ...]) -> tuple[str, ...]:
    """
    Return the names.

    :raises ValueError: an entry is defined twice.
    """
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f'named twice: {", ".join(twice)}')
    return names


class ControllerParameters(Settings):
    """The base of the parameters of all kinds of controllers."""

    update_rate: int = parameter(
        0, "updates per second, by default the manager's rate [Hz]", read_only=True, ge=0
    )
    is_async: bool = parameter(
        False, 'has no effect: all controllers run in the same control loop', read_only=True
    )
    thread_priority: int = parameter(
        -100, 'has no effect: all controllers run in the same control loop', read_only=True
    )


class StandInParameters(ControllerParameters):
    """Parameters that a replacement reads; all others are the vendor's and ignored."""

    model_config = ConfigDict(extra='ignore')

    state_publish_rate: float = parameter(
        100.0, 'messages a second, where it publishes anything [Hz]', read_only=True, gt=0.0)
