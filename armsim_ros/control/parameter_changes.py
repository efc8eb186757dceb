# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Changes of the parameters of a loaded controller: which are allowed, and when they count."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import ValidationError

from armsim_ros.config.base import Settings
from armsim_ros.errors import ControllerError, nearest

SettingsT = TypeVar('SettingsT', bound=Settings)


def changed(current: SettingsT, changes: Settings | Mapping[str, Any]) -> SettingsT:
    """
    Return new parameters; the current ones stay as they are.

    :param changes: all parameters anew, or only those that change, by their dotted names.
    :raises ControllerError: an unknown name, a value out of range, a read-only parameter.
    """
    if isinstance(changes, Settings):
        new = type(current).model_validate(changes.model_dump())
    else:
        values = current.model_dump()
        for name, value in changes.items():
            _set(values, name, value)
        try:
            new = type(current).model_validate(values)
        except ValidationError as error:
            raise ControllerError('; '.join(map(describe, error.errors()))) from None
    for name in _read_only_changes(current, new):
        raise ControllerError(f"parameter '{name}' is read-only once the controller is loaded")
    return new


def in_effect(current: SettingsT, requested: SettingsT) -> SettingsT:
    """Return the requested parameters, but current ones where only configure changes them."""
    kept: dict[str, Any] = {}
    for name, field in type(current).model_fields.items():
        before, after = getattr(current, name), getattr(requested, name)
        extra = field.json_schema_extra
        if before == after:
            continue
        if isinstance(extra, dict) and extra.get('on_configure'):
            kept[name] = before
        elif isinstance(before, Settings) and isinstance(after, Settings):
            kept[name] = in_effect(before, after)
    return requested.model_copy(update=kept) if kept else requested


def describe(error: Mapping[str, Any]) -> str:
    """Return an error of pydantic as a phrase that names the parameter."""
    name = '.'.join(map(str, error['loc']))
    text = str(error['msg']).removeprefix('Value error, ')
    return f"parameter '{name}': {text}" if name else text


def _set(values: dict[str, Any], name: str, value: object) -> None:
    block, rest = values, name
    while rest not in block:
        heads = [k for k in block if rest.startswith(f'{k}.') and isinstance(block[k], dict)]
        if not heads:
            hint = nearest(rest, tuple(block))
            raise ControllerError(f"no parameter '{name}'{'; ' if hint else ''}{hint}")
        head = max(heads, key=len)
        block, rest = block[head], rest[len(head) + 1 :]
    block[rest] = value


def _read_only_changes(old: Settings, new: Settings, prefix: str = '') -> list[str]:
    found: list[str] = []
    for name, field in type(old).model_fields.items():
        before, after = getattr(old, name), getattr(new, name)
        extra = field.json_schema_extra
        if before == after:
            continue
        if isinstance(extra, dict) and extra.get('read_only'):
            found.append(prefix + name)
        elif isinstance(before, Settings):
            found += _read_only_changes(before, after, f'{prefix}{name}.')
        elif isinstance(before, dict):
            for key in before:
                if isinstance(before[key], Settings):
                    found += _read_only_changes(before[key], after[key], f'{prefix}{name}.{key}.')
    for key, before in (old.__pydantic_extra__ or {}).items():
        after = (new.__pydantic_extra__ or {}).get(key)
        if isinstance(before, Settings) and isinstance(after, Settings):
            found += _read_only_changes(before, after, f'{prefix}{key}.')
    return found
