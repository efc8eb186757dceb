# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From plain values to messages; what does not fit is refused with its path."""

from __future__ import annotations

import array
from base64 import b64decode
from collections.abc import Callable, Mapping
import json
import math
from typing import Any

import numpy as np

from armsim_ros.errors import ArmsimError, nearest
from armsim_ros.nodes.bridge.conversion.fields import (
    ARRAY_CODES,
    fields_of,
    FieldType,
    INTEGER_RANGES,
    is_header,
    is_stamp,
    Kind,
    per_type,
    Shape,
)

#: Words that JSON has no number for.
_WORDS = {None: math.nan, 'NaN': math.nan, 'Infinity': math.inf, '-Infinity': -math.inf}
_LARGEST_FLOAT = 3.4028235677973366e38
_NUMPY_TYPES = {'float': np.float32, 'double': np.float64}
#: Values that are converted at once; other threads run in between.
_PIECE = 1 << 16
#: Names of ROS 1 -> of ROS 2.
_OLD_NAMES = {'secs': 'sec', 'nsecs': 'nanosec'}

#: Returns seconds and nanoseconds of the ROS clock.
Now = Callable[[], tuple[int, int]]
Fill = Callable[[Any, str, Now], Any]


class ConversionError(ArmsimError):
    """A value does not fit a message; the text names its path."""


def to_message(cls: type[Any], values: Any, now: Now) -> Any:
    """
    Make a message; fields that are missing or null keep their defaults, but a float is NaN.

    :param values: an object of JSON; a list has the first fields in order.
    :param now: the time for headers without a stamp.
    :raises ConversionError: a field is unknown, or a value does not fit.
    """
    if isinstance(values, list):
        fields = fields_of(cls)
        if len(values) > len(fields):
            raise ConversionError(
                f'{len(values)} values, but {_label(cls)} has {_listed(fields)}')
        values = dict(zip(fields, values, strict=False))
    return _filler(cls)(values, '', now)


@per_type
def _filler(cls: type[Any]) -> Fill:
    """Return the function from an object to a message of a class."""
    fields = fields_of(cls)
    setters = {name: (f'_{name}', _setter(kind, cls)) for name, kind in fields.items()}
    floats = {name for name, kind in fields.items()
              if kind.kind is Kind.FLOAT and kind.shape is Shape.SINGLE}
    stamp, header = is_stamp(cls), is_header(cls)

    def fill(values: Any, path: str, now: Now) -> Any:
        message = cls()
        if stamp and values == 'now':
            message.sec, message.nanosec = now()
            return message
        if not isinstance(values, Mapping):
            raise _wrong(path, cls, f'expected {Kind.MESSAGE.value}, got {_shown(values)}')
        for name, value in values.items():
            setter = setters.get(name)
            if setter is None and stamp:
                setter = setters.get(_OLD_NAMES.get(name, ''))
            if setter is None:
                if header and name == 'seq':
                    continue
                hint = nearest(name, tuple(fields))
                raise _wrong(_joined(path, str(name)[:100]), cls,
                             f'no such field{"; " + hint if hint else ""}')
            if value is None and name not in floats:
                continue
            setattr(message, setter[0], setter[1](value, _joined(path, name), now))
        if header and values.get('stamp') is None:
            message.stamp.sec, message.stamp.nanosec = now()
        return message

    return fill


def _setter(kind: FieldType, owner: type[Any]) -> Fill:
    single = _single(kind, owner)
    if kind.shape is Shape.SINGLE:
        return single
    if kind.is_numeric_array:
        return _numbers(kind, owner, single)

    def several(value: Any, path: str, now: Now) -> Any:
        if kind.kind is Kind.OCTET and isinstance(value, str):
            value = list(_decoded(value, path, owner))
        items = _checked_list(value, path, kind, owner)
        return [single(item, f'{path}[{index}]', now) for index, item in enumerate(items)]

    return several


def _numbers(kind: FieldType, owner: type[Any], single: Fill) -> Fill:
    """Return what makes an array of machine numbers."""
    code = ARRAY_CODES[kind.basic]
    numpy_type = _NUMPY_TYPES.get(kind.basic, getattr(np, kind.basic, None))

    def numbers(value: Any, path: str, now: Now) -> Any:
        if kind.is_bytes and isinstance(value, str):
            value = _decoded(value, path, owner)
        items = _checked_list(value, path, kind, owner)
        found = array.array(code)
        for start in range(0, len(items), _PIECE):
            piece = items[start:start + _PIECE]
            try:
                part = array.array(code, piece)
                exact = isinstance(piece, bytes) or (
                    (code != 'f' or not np.isinf(part).any()) and bool not in map(type, piece))
            except (TypeError, OverflowError):
                exact = False
            found.extend(part if exact else array.array(code, [
                single(item, f'{path}[{index}]', now) for index, item in enumerate(piece, start)]))
        if kind.shape is Shape.FIXED:
            return np.array(found, dtype=numpy_type)
        return found

    return numbers


def _checked_list(value: Any, path: str, kind: FieldType, owner: type[Any]) -> Any:
    if not isinstance(value, (list, bytes)):
        raise _wrong(path, owner, f'expected a list, got {_shown(value)}')
    if kind.shape is Shape.FIXED and len(value) != kind.size:
        raise _wrong(path, owner, f'expected {kind.size} values, got {len(value)}')
    if kind.shape is Shape.SEQUENCE and 0 < kind.size < len(value):
        raise _wrong(path, owner, f'expected at most {kind.size} values, got {len(value)}')
    return value


def _single(kind: FieldType, owner: type[Any]) -> Fill:
    if kind.kind is Kind.MESSAGE:
        assert kind.message is not None
        return _filler(kind.message)
    return {Kind.BOOL: _bool, Kind.INTEGER: _integer, Kind.FLOAT: _float, Kind.OCTET: _octet,
            Kind.TEXT: _text}[kind.kind](kind, owner)


def _bool(kind: FieldType, owner: type[Any]) -> Fill:
    def convert(value: Any, path: str, _: Now) -> Any:
        if not isinstance(value, bool):
            raise _wrong(path, owner, f'expected {kind.kind.value}, got {_shown(value)}')
        return value

    return convert


def _integer(kind: FieldType, owner: type[Any]) -> Fill:
    least, most = INTEGER_RANGES.get(kind.basic, (0, 255))

    def convert(value: Any, path: str, _: Now) -> Any:
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int):
            raise _wrong(path, owner, f'expected {kind.kind.value}, got {_shown(value)}')
        if not least <= value <= most:
            raise _wrong(path, owner,
                         f'expected {least} to {most} ({kind.basic}), got {_shown(value)}')
        return value

    return convert


def _float(kind: FieldType, owner: type[Any]) -> Fill:
    def convert(value: Any, path: str, _: Now) -> Any:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            if value is None or (isinstance(value, str) and value in _WORDS):
                return _WORDS[value]
            raise _wrong(path, owner, f'expected {kind.kind.value}, got {_shown(value)}')
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        too_large = math.isinf(number) and isinstance(value, int)
        if kind.basic == 'float' and math.isfinite(number):
            too_large = abs(number) >= _LARGEST_FLOAT
        if too_large:
            raise _wrong(path, owner, f'too large for {kind.basic}: {_shown(value)}')
        return number

    return convert


def _octet(kind: FieldType, owner: type[Any]) -> Fill:
    integer = _integer(kind, owner)
    return lambda value, path, now: bytes([integer(value, path, now)])


def _text(kind: FieldType, owner: type[Any]) -> Fill:
    def convert(value: Any, path: str, _: Now) -> Any:
        if not isinstance(value, str):
            raise _wrong(path, owner, f'expected {kind.kind.value}, got {_shown(value)}')
        if 0 < kind.text_limit < len(value):
            raise _wrong(path, owner, f'expected at most {kind.text_limit} characters, '
                         f'got {len(value)}')
        if not value.isascii():
            try:
                value.encode()
            except UnicodeEncodeError:
                raise _wrong(path, owner, 'half of a surrogate pair is no character') from None
        return value

    return convert


def _decoded(value: str, path: str, owner: type[Any]) -> bytes:
    try:
        return b64decode(value, validate=True)
    except ValueError as error:
        raise _wrong(path, owner, f'expected base64 or a list of numbers: {error}') from None


def _wrong(path: str, owner: type[Any], text: str) -> ConversionError:
    place = f'{path}: ' if path else ''
    return ConversionError(f'{place}{text}; {_label(owner)} has {_listed(fields_of(owner))}')


def _label(cls: type[Any]) -> str:
    return cls.__name__.replace('_', ' ')


def _listed(fields: Mapping[str, FieldType]) -> str:
    return ', '.join(fields) or 'no fields'


def _joined(path: str, name: str) -> str:
    return f'{path}.{name}' if path else name


def _shown(value: Any) -> str:
    """Return the start of a value as JSON."""
    if isinstance(value, (list, dict)):
        return 'a list' if isinstance(value, list) else 'an object'
    text = json.dumps(value) if not isinstance(value, int) or abs(value) < 1 << 64 \
        else f'a number of {value.bit_length()} bits'
    return text if len(text) <= 60 else f'{text[:60]}...'
