# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
From serialized messages to plain values: dictionaries for JSON and for CBOR.

The bytes are read here and not by rclpy, which holds all other threads up until it has made a
message of them: for a second where it has half a million parts.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator
from functools import partial
from itertools import islice
import secrets
import struct
from typing import Any

import cbor2
from rclpy.serialization import deserialize_message, serialize_message

from armsim_ros.nodes.bridge.message_fields import (
    CODES,
    fields_of,
    FieldType,
    flat_layout,
    HEAD,
    Kind,
    per_type,
    Shape,
)
from armsim_ros.nodes.json_text import LongList

Plain = dict[str, Any]
#: From bytes and a place to the value there and the place behind it; places begin after the head.
Read = Callable[[memoryview, int], tuple[Any, int]]
#: Returns what makes the value of an array of numbers from its bytes.
ArrayForm = Callable[[FieldType], Callable[[memoryview], Any]]

#: Type of IDL -> tag of a typed array of little-endian numbers (RFC 8746).
CBOR_TAGS = {
    'uint16': 69, 'uint32': 70, 'uint64': 71, 'int8': 72, 'int16': 77, 'int32': 78, 'int64': 79,
    'float': 85, 'double': 86,
}
#: From this size on a list, or an array of numbers, is made and encoded in pieces of this size.
_LONG = 1000
#: From this size on bytes are not copied.
_LONG_BYTES = 1 << 14
#: Is in their place until the rest is encoded; no message can contain it.
_MARK = secrets.token_bytes(16)
_BYTES, _ARRAY, _TAG = 2, 4, 6
_count = struct.Struct('<I').unpack_from


@per_type
def json_values(cls: type[Any]) -> Callable[[bytes | memoryview], Plain]:
    """Return the function from a serialized message of a class to values of JSON."""
    return partial(_read_all, cls, _message(cls, _json_array))


@per_type
def cbor_values(cls: type[Any]) -> Callable[[bytes | memoryview], Plain]:
    """Return the function from a serialized message of a class to values of :func:`to_cbor`."""
    return partial(_read_all, cls, _message(cls, _cbor_array))


def values_of(message: Any) -> Plain:
    """Return the values of JSON of a message."""
    return json_values(type(message))(serialize_message(message))


class Packed:
    """
    Bytes that are not copied.

    :param tag: of the value; 0 for none.
    """

    def __init__(self, view: memoryview, tag: int = 0) -> None:
        self.view, self.tag = view, tag


def to_cbor(value: Any) -> list[bytes | memoryview]:
    """Return a value in CBOR, in parts."""
    views: list[memoryview] = []

    def encode(encoder: Any, part: Any) -> None:
        if isinstance(part, LongList):
            encoder.encode_length(_ARRAY, part.size)
            for piece in part.pieces:
                for item in piece:
                    encoder.encode(item)
        elif isinstance(part, Packed):
            if part.tag:
                encoder.encode_length(_TAG, part.tag)
            encoder.encode_length(_BYTES, len(part.view))
            encoder.write(_MARK)
            views.append(part.view)
        else:
            raise TypeError(f'{type(part).__name__} is not a value of CBOR')

    payload = cbor2.dumps(value, default=encode)
    if not views:
        return [payload]
    first, *others = payload.split(_MARK)
    return [first, *(part for pair in zip(views, others, strict=True) for part in pair)]


# With the first value of an unknown type cbor2 imports the modules of all types that it knows:
# half a megabyte, which would stay where what is needed for a moment could be returned.
to_cbor(Packed(memoryview(b'')))


def _read_all(cls: type[Any], read: Read, raw: bytes | memoryview) -> Plain:
    if raw[:len(HEAD)] != HEAD:  # of a machine with another order of bytes
        raw = serialize_message(deserialize_message(bytes(raw), cls))
    found: Plain = read(memoryview(raw)[len(HEAD):], 0)[0]
    return found


def _message(cls: type[Any], form: ArrayForm) -> Read:
    fields = fields_of(cls)
    if not fields:
        return lambda data, at: ({}, at + 1)  # a structure has at least one byte
    names = tuple(fields)
    layout = flat_layout(cls)
    if layout is not None:
        unpack, size, mask = layout.unpack_from, layout.size, layout.size // len(names) - 1

        def read_flat(data: memoryview, at: int) -> tuple[Any, int]:
            at += -at & mask
            return dict(zip(names, unpack(data, at), strict=False)), at + size

        return read_flat
    readers = tuple((name, _field(kind, form)) for name, kind in fields.items())

    def read(data: memoryview, at: int) -> tuple[Any, int]:
        found = {}
        for name, reader in readers:
            found[name], at = reader(data, at)
        return found, at

    return read


def _field(kind: FieldType, form: ArrayForm) -> Read:
    if kind.shape is Shape.SINGLE:
        return _single(kind, form)
    if kind.basic:
        return _numbers(kind, form(kind))
    single = _single(kind, form)
    layout = flat_layout(kind.message) if kind.message else None
    if kind.message is not None and layout is not None:
        return _flat_messages(kind, kind.message, layout)

    def several(data: memoryview, at: int) -> tuple[Any, int]:
        size, at = _size(kind, data, at)
        found = []
        for _ in range(size):
            item, at = single(data, at)
            found.append(item)
        return found if size < _LONG else LongList(size, _sliced(found)), at

    return several


def _flat_messages(kind: FieldType, cls: type[Any], layout: struct.Struct) -> Read:
    names = tuple(fields_of(cls))
    mask = layout.size // len(names) - 1

    def several(data: memoryview, at: int) -> tuple[Any, int]:
        size, at = _size(kind, data, at)
        at += -at & mask if size else 0
        end = at + size * layout.size
        found = (dict(zip(names, values, strict=False))
                 for values in layout.iter_unpack(data[at:end]))
        if size < _LONG:
            return list(found), end
        return LongList(size, iter(lambda: list(islice(found, _LONG)), [])), end

    return several


def _numbers(kind: FieldType, convert: Callable[[memoryview], Any]) -> Read:
    width = struct.calcsize(CODES[kind.basic])

    def numbers(data: memoryview, at: int) -> tuple[Any, int]:
        size, at = _size(kind, data, at)
        at += -at & width - 1 if size else 0
        end = at + size * width
        return convert(data[at:end]), end

    return numbers


def _size(kind: FieldType, data: memoryview, at: int) -> tuple[int, int]:
    """Return how many items there are, and where they begin, but for their alignment."""
    if kind.shape is Shape.FIXED:
        return kind.size, at
    at += -at & 3
    return _count(data, at)[0], at + 4


def _single(kind: FieldType, form: ArrayForm) -> Read:
    if kind.message is not None:
        return _message(kind.message, form)
    if kind.kind is Kind.TEXT:
        return _wide_text if kind.is_wide else _text
    number = struct.Struct(f'<{CODES[kind.basic]}')
    unpack, width = number.unpack_from, number.size

    def read(data: memoryview, at: int) -> tuple[Any, int]:
        at += -at & width - 1
        return unpack(data, at)[0], at + width

    return read


def _text(data: memoryview, at: int) -> tuple[str, int]:
    begin = at + (-at & 3) + 4
    end = begin + _count(data, begin - 4)[0]
    return str(data[begin:end - 1], 'utf-8', 'replace'), end


def _wide_text(data: memoryview, at: int) -> tuple[str, int]:
    begin = at + (-at & 3) + 4
    end = begin + 4 * _count(data, begin - 4)[0]
    units = array('H', data[begin:end].cast('I'))  # of UTF-16, four bytes each
    return units.tobytes().decode('utf-16-le', 'replace'), end


def _json_array(kind: FieldType) -> Callable[[memoryview], Any]:
    if kind.is_bytes:
        return lambda data: data
    code = CODES[kind.basic]

    def numbers(data: memoryview) -> Any:
        values = data.cast(code)  # type: ignore[call-overload] # one of its codes
        return values.tolist() if len(values) < _LONG else LongList(
            len(values), (piece.tolist() for piece in _sliced(values)))

    return numbers


def _cbor_array(kind: FieldType) -> Callable[[memoryview], Any]:
    tag = CBOR_TAGS.get(kind.basic, 0)
    if not tag and not kind.is_bytes:
        return _json_array(kind)

    def packed(data: memoryview) -> Any:
        if len(data) >= _LONG_BYTES:
            return Packed(data, tag)
        return cbor2.CBORTag(tag, bytes(data)) if tag else bytes(data)

    return packed


def _sliced(values: Any) -> Iterator[Any]:
    return (values[start:start + _LONG] for start in range(0, len(values), _LONG))
