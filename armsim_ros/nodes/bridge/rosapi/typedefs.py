# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Descriptions of types for rosapi: fields, lengths of arrays, constants."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rosapi_msgs.msg import TypeDef

from armsim_ros.nodes.bridge.conversion.fields import fields_of, FieldType, Kind, Shape
from armsim_ros.nodes.bridge.conversion.outgoing import values_of
from armsim_ros.nodes.serving.json_text import to_json

#: Type of IDL -> its name in definitions of messages.
_NAMES = {'boolean': 'bool', 'octet': 'byte', 'float': 'float32', 'double': 'float64'}


def typedefs(cls: type[Any]) -> list[TypeDef]:
    """Return the description of a class, then those of all types in it, each once."""
    return [_typedef(found) for found in _classes(cls, set())]


def _classes(cls: type[Any], seen: set[type[Any]]) -> Iterator[type[Any]]:
    seen.add(cls)
    yield cls
    for kind in fields_of(cls).values():
        if kind.message is not None and kind.message not in seen:
            yield from _classes(kind.message, seen)


def _typedef(cls: type[Any]) -> TypeDef:
    found = TypeDef(type=_short_name(cls))
    defaults = values_of(cls())
    for name, kind in fields_of(cls).items():
        found.fieldnames.append(name)
        found.fieldtypes.append(_field_name(kind))
        found.fieldarraylen.append(
            {Shape.SINGLE: -1, Shape.SEQUENCE: 0, Shape.FIXED: kind.size}[kind.shape])
        empty = '{}' if kind.kind is Kind.MESSAGE else to_json(defaults[name])
        found.examples.append('[]' if kind.shape is not Shape.SINGLE else empty)
    for name, value in _constants(cls):
        found.constnames.append(name)
        found.constvalues.append(value)
    return found


def _constants(cls: type[Any]) -> Iterator[tuple[str, str]]:
    """Yield the constants, which are properties of the class's metaclass."""
    for name in vars(type(cls)):
        if name.isupper() and not name.startswith('_') and not name.endswith('__DEFAULT'):
            value = getattr(cls, name)
            yield name, str(value[0]) if isinstance(value, bytes) and value else str(value)


def _field_name(kind: FieldType) -> str:
    if kind.message is not None:
        return _short_name(kind.message)
    return _NAMES.get(kind.basic, kind.basic) if kind.basic else 'string'


def _short_name(cls: type[Any]) -> str:
    return f'{cls.__module__.partition(".")[0]}/{cls.__name__}'
