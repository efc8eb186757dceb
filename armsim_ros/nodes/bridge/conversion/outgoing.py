# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From messages to plain values: dictionaries for JSON and for CBOR."""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter
from typing import Any

import cbor2

from armsim_ros.nodes.bridge.conversion.fields import (
    fields_of,
    FieldType,
    Kind,
    per_type,
    Shape,
)

Plain = dict[str, Any]
Convert = Callable[[Any], Any]

#: Type of IDL -> tag of a typed array of little-endian numbers (RFC 8746).
CBOR_TAGS = {
    'uint16': 69, 'uint32': 70, 'uint64': 71, 'int8': 72, 'int16': 77, 'int32': 78, 'int64': 79,
    'float': 85, 'double': 86,
}


@per_type
def json_values(cls: type[Any]) -> Callable[[Any], Plain]:
    """Return the function from a message of a class to values of JSON."""
    return _compile(cls, _json_converter)


@per_type
def cbor_values(cls: type[Any]) -> Callable[[Any], Plain]:
    """Return the function from a message of a class to values of CBOR."""
    return _compile(cls, _cbor_converter)


def _compile(cls: type[Any], converter: Callable[[FieldType], Convert | None]
             ) -> Callable[[Any], Plain]:
    fields = fields_of(cls)
    names = tuple(fields)
    special = tuple((name, convert) for name, kind in fields.items()
                    if (convert := converter(kind)) is not None)
    if not names:
        return lambda _: {}
    # Past the properties, whose values are the same.
    read = attrgetter(*(f'_{name}' for name in names))
    if len(names) == 1:
        name, convert = names[0], special[0][1] if special else None
        if convert is None:
            return lambda message: {name: read(message)}
        return lambda message: {name: convert(read(message))}

    def values(message: Any) -> Plain:
        found = dict(zip(names, read(message), strict=False))
        for name, convert in special:
            found[name] = convert(found[name])
        return found

    return values


def _json_converter(kind: FieldType) -> Convert | None:
    """Return what makes a value of JSON, None where it is a value of JSON."""
    if kind.kind is Kind.MESSAGE:
        return _nested(kind, json_values)
    if kind.is_bytes:
        return memoryview
    return _as_list(kind)


def _cbor_converter(kind: FieldType) -> Convert | None:
    if kind.kind is Kind.MESSAGE:
        return _nested(kind, cbor_values)
    if kind.is_bytes:
        return lambda value: value.tobytes()
    tag = CBOR_TAGS.get(kind.basic)
    if kind.is_numeric_array and tag is not None:
        return lambda value: cbor2.CBORTag(tag, value.tobytes())
    return _as_list(kind)


def _as_list(kind: FieldType) -> Convert | None:
    if kind.is_numeric_array:
        return lambda value: value.tolist()
    if kind.kind is Kind.OCTET:
        if kind.shape is Shape.SINGLE:
            return lambda value: value[0]
        return lambda value: [item[0] for item in value]
    return None


def _nested(kind: FieldType, of: Callable[..., Callable[[Any], Plain]]) -> Convert:
    assert kind.message is not None
    convert = of(kind.message)
    if kind.shape is Shape.SINGLE:
        return convert
    return lambda value: [convert(item) for item in value]
