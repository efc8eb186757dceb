# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
From plain values to serialized messages; what does not fit is refused with its path.

What large frames of clients hold is read in threads, so that other clients do not wait.
"""

from __future__ import annotations

import array
import asyncio
from base64 import b64decode
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar
import json
import math
from operator import itemgetter
import struct
from typing import Any, TypeVar

import numpy as np
from rclpy.serialization import deserialize_message

from armsim_ros.errors import ArmsimError, nearest
from armsim_ros.nodes.bridge.message_fields import (
    CODES,
    fields_of,
    FieldType,
    flat_layout,
    HEAD,
    INTEGER_RANGES,
    is_header,
    is_stamp,
    Kind,
    per_type,
    Shape,
)
from armsim_ros.nodes.bridge.outgoing import values_of
from armsim_ros.nodes.json_text import to_json

#: Words that JSON has no number for.
_WORDS = {None: math.nan, 'NaN': math.nan, 'Infinity': math.inf, '-Infinity': -math.inf}
_LARGEST_FLOAT = 3.4028235677973366e38
#: Values that are converted at once; other threads run in between.
_PIECE = 1 << 16
#: Names of ROS 1 -> of ROS 2.
_OLD_NAMES = {'secs': 'sec', 'nsecs': 'nanosec'}
_count = struct.Struct('<I').pack
#: From this size on a frame is large [bytes].
LARGE = 1 << 18
#: Large frames that are read at the same time.
_THREADS = ThreadPoolExecutor(4, 'decoding')
#: Of the frame that is being served; tasks that it starts inherit it.
_is_large = ContextVar('_is_large', default=False)

T = TypeVar('T')
#: Returns seconds and nanoseconds of the ROS clock.
Now = Callable[[], tuple[int, int]]
#: Adds a value to the bytes behind the head.
Write = Callable[[Any, Now, bytearray], None]
#: Returns the number that is added for a value.
Check = Callable[[Any], Any]


class ConversionError(ArmsimError):
    """A value does not fit a message; the text names its path."""


class _MisfitError(Exception):
    """
    A value does not fit.

    :param text: what is wrong.
    :param owner: the class that has the field.
    """

    def __init__(self, text: str, owner: type[Any], *path: str) -> None:
        super().__init__(text)
        self.owner, self.path = owner, list(path)


async def aside(size: int, work: Callable[..., T], *values: Any) -> T:
    """
    Do what begins a frame, and note its size for what follows.

    :param size: [bytes].
    """
    _is_large.set(size >= LARGE)
    return await _run(work, *values)


async def message_of(cls: type[Any], values: Any, now: Now) -> Any:
    """
    Make a message.

    :raises ConversionError: a field is unknown, or a value does not fit.
    """
    return deserialize_message(await serialized_of(cls, values, now), cls)


async def serialized_of(cls: type[Any], values: Any, now: Now) -> bytes:
    """
    Make a serialized message as :func:`serialized` does.

    :raises ConversionError: a field is unknown, or a value does not fit.
    """
    if not _is_large.get():
        return serialized(cls, values, now)
    stamp = now()  # in this thread
    return await _run(serialized, cls, values, lambda: stamp)


async def _run(work: Callable[..., T], *values: Any) -> T:
    if not _is_large.get():
        return work(*values)
    return await asyncio.get_running_loop().run_in_executor(_THREADS, work, *values)


def serialized(cls: type[Any], values: Any, now: Now) -> bytes:
    """
    Make a serialized message; fields that are missing or null keep their defaults, a float is NaN.

    It is not made by rclpy, which holds all other threads up until it has read all of it.

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
    body = bytearray()
    try:
        _writer(cls)(values, now, body)
    except _MisfitError as error:
        path = ''.join(error.path).removeprefix('.')
        raise ConversionError(f'{path}{": " if path else ""}{error}; {_label(error.owner)} has '
                              f'{_listed(fields_of(error.owner))}') from None
    return HEAD + body


@per_type
def _writer(cls: type[Any]) -> Write:
    """Return the function that adds an object as a message of a class."""
    fields = fields_of(cls)
    defaults = json.loads(to_json(values_of(cls())))
    writers = tuple((name, defaults[name], _field(kind, cls),
                     kind.kind is Kind.FLOAT and kind.shape is Shape.SINGLE)
                    for name, kind in fields.items())
    stamp, header = is_stamp(cls), is_header(cls)

    def write(values: Any, now: Now, body: bytearray) -> None:
        if stamp:
            values = _stamp(values, now)
        if not isinstance(values, Mapping):
            raise _MisfitError(f'expected {Kind.MESSAGE.value}, got {_shown(values)}', cls)
        if header and values.get('stamp') is None:
            values = {**values, 'stamp': 'now'}
        if not values.keys() <= fields.keys():
            for name in values.keys() - fields.keys() - ({'seq'} if header else set()):
                hint = nearest(name, tuple(fields))
                raise _MisfitError(f'no such field{"; " + hint if hint else ""}', cls,
                                   f'.{str(name)[:100]}')
        try:
            for name, default, add, takes_null in writers:
                value = values.get(name, default)
                add(default if value is None and not takes_null else value, now, body)
        except _MisfitError as error:
            error.path.insert(0, f'.{name}')
            raise
        if not fields:
            body.append(0)  # a structure has at least one byte

    layout = flat_layout(cls)
    return write if layout is None else _quickly(layout, tuple(fields), write)


def _stamp(values: Any, now: Now) -> Any:
    if values == 'now':
        return dict(zip(('sec', 'nanosec'), now(), strict=True))
    if isinstance(values, Mapping) and not values.keys().isdisjoint(_OLD_NAMES):
        return {_OLD_NAMES.get(name, name): value for name, value in values.items()}
    return values


def _quickly(layout: struct.Struct, names: tuple[str, ...], write: Write) -> Write:
    """Return what adds the numbers of a flat message at once, where they are what they should."""
    width = layout.size // len(names)
    get = itemgetter(*names) if len(names) > 1 else lambda values: (values[names[0]],)

    def quick(values: Any, now: Now, body: bytearray) -> None:
        try:
            numbers = get(values)
            data = layout.pack(*numbers)
        except (KeyError, TypeError, OverflowError, struct.error):
            write(values, now, body)
            return
        if bool in map(type, numbers) or len(values) != len(names):
            write(values, now, body)
            return
        _align(body, width)
        body += data

    return quick


def _align(body: bytearray, width: int) -> None:
    gap = -len(body) & width - 1
    if gap:
        body += bytes(gap)


def _field(kind: FieldType, owner: type[Any]) -> Write:
    single = _single(kind, owner)
    if kind.shape is Shape.SINGLE:
        return single
    if kind.kind in (Kind.INTEGER, Kind.FLOAT):
        return _numbers(kind, owner)

    def several(value: Any, now: Now, body: bytearray) -> None:
        if kind.kind is Kind.OCTET and isinstance(value, str):
            value = _decoded(value, owner)
        for _ in _each(_counted(value, kind, owner, body), 0,
                       lambda item: single(item, now, body)):
            pass

    return several


def _numbers(kind: FieldType, owner: type[Any]) -> Write:
    """Return what adds an array of machine numbers."""
    code, check = CODES[kind.basic], _number(kind, owner)
    width = struct.calcsize(code)

    def numbers(value: Any, _: Now, body: bytearray) -> None:
        if kind.is_bytes and isinstance(value, str):
            value = _decoded(value, owner)
        items = _counted(value, kind, owner, body)
        if items:
            _align(body, width)
        for start in range(0, len(items), _PIECE):
            piece = items[start:start + _PIECE]
            try:
                part = array.array(code, piece)
                exact = not isinstance(piece, list) or (
                    (code != 'f' or not np.isinf(part).any()) and bool not in map(type, piece))
            except (TypeError, OverflowError):
                exact = False
            body += (part if exact else array.array(code, _each(piece, start, check))).tobytes()

    return numbers


def _each(items: Any, start: int, work: Callable[[Any], Any]) -> Iterator[Any]:
    """Yield what becomes of each item; errors name its place."""
    for index, item in enumerate(items, start):
        try:
            yield work(item)
        except _MisfitError as error:
            error.path.insert(0, f'[{index}]')
            raise


def _counted(value: Any, kind: FieldType, owner: type[Any], body: bytearray) -> Any:
    """Check a list, add how many items it has where that is free, and return it."""
    if not isinstance(value, (list, bytes)):
        raise _MisfitError(f'expected a list, got {_shown(value)}', owner)
    if kind.shape is Shape.FIXED and len(value) != kind.size:
        raise _MisfitError(f'expected {kind.size} values, got {len(value)}', owner)
    if kind.shape is Shape.SEQUENCE and 0 < kind.size < len(value):
        raise _MisfitError(f'expected at most {kind.size} values, got {len(value)}', owner)
    if kind.shape is Shape.SEQUENCE:
        _align(body, 4)
        body += _count(len(value))
    return value


def _single(kind: FieldType, owner: type[Any]) -> Write:
    if kind.message is not None:
        return _writer(kind.message)
    if kind.kind is Kind.TEXT:
        return _text(kind, owner)
    check, layout = _number(kind, owner), struct.Struct(f'<{CODES[kind.basic]}')
    pack, width = layout.pack, layout.size

    def write(value: Any, _: Now, body: bytearray) -> None:
        _align(body, width)
        body += pack(check(value))

    return write


def _number(kind: FieldType, owner: type[Any]) -> Check:
    return {Kind.BOOL: _bool, Kind.FLOAT: _float}.get(kind.kind, _integer)(kind, owner)


def _bool(kind: FieldType, owner: type[Any]) -> Check:
    def check(value: Any) -> Any:
        if not isinstance(value, bool):
            raise _MisfitError(f'expected {kind.kind.value}, got {_shown(value)}', owner)
        return value

    return check


def _integer(kind: FieldType, owner: type[Any]) -> Check:
    least, most = INTEGER_RANGES.get(kind.basic, (0, 255))

    def check(value: Any) -> Any:
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int):
            raise _MisfitError(f'expected {kind.kind.value}, got {_shown(value)}', owner)
        if not least <= value <= most:
            raise _MisfitError(
                f'expected {least} to {most} ({kind.basic}), got {_shown(value)}', owner)
        return value

    return check


def _float(kind: FieldType, owner: type[Any]) -> Check:
    def check(value: Any) -> Any:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            if value is None or (isinstance(value, str) and value in _WORDS):
                return _WORDS[value]
            raise _MisfitError(f'expected {kind.kind.value}, got {_shown(value)}', owner)
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        too_large = math.isinf(number) and isinstance(value, int)
        if kind.basic == 'float' and math.isfinite(number):
            too_large = abs(number) >= _LARGEST_FLOAT
        if too_large:
            raise _MisfitError(f'too large for {kind.basic}: {_shown(value)}', owner)
        return number

    return check


def _text(kind: FieldType, owner: type[Any]) -> Write:
    def write(value: Any, _: Now, body: bytearray) -> None:
        if not isinstance(value, str):
            raise _MisfitError(f'expected {kind.kind.value}, got {_shown(value)}', owner)
        if 0 < kind.text_limit < len(value):
            raise _MisfitError(f'expected at most {kind.text_limit} characters, got {len(value)}',
                               owner)
        try:
            data = array.array('I', array.array('H', value.encode('utf-16-le'))).tobytes() \
                if kind.is_wide else value.encode() + b'\0'
        except UnicodeEncodeError:
            raise _MisfitError('half of a surrogate pair is no character', owner) from None
        _align(body, 4)
        body += _count(len(data) // 4 if kind.is_wide else len(data))
        body += data

    return write


def _decoded(value: str, owner: type[Any]) -> bytes:
    try:
        return b64decode(''.join(value.split()), validate=True)  # MIME has lines
    except ValueError as error:
        raise _MisfitError(f'expected base64 or a list of numbers: {error}', owner) from None


def _label(cls: type[Any]) -> str:
    return cls.__name__.replace('_', ' ')


def _listed(fields: Mapping[str, FieldType]) -> str:
    return ', '.join(fields) or 'no fields'


def _shown(value: Any) -> str:
    """Return the start of a value as JSON."""
    if isinstance(value, (list, dict)):
        return 'a list' if isinstance(value, list) else 'an object'
    text = json.dumps(value) if not isinstance(value, int) or abs(value) < 1 << 64 \
        else f'a number of {value.bit_length()} bits'
    return text if len(text) <= 60 else f'{text[:60]}...'
