# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The fields of message classes, as the conversions need them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from importlib import import_module
import struct
from typing import Any, TypeVar

from rosidl_parser.definition import (
    AbstractNestedType,
    AbstractString,
    AbstractWString,
    Array,
    BasicType,
    BoundedSequence,
    NamespacedType,
)

T = TypeVar('T')

#: What a serialized message begins with: plain CDR (OMG DDS-XTypes), little-endian. Each value is
#: aligned to its own size from the end of this on.
HEAD = b'\x00\x01\x00\x00'
#: Type of IDL -> letter of its array.
CODES = {
    'float': 'f', 'double': 'd', 'int8': 'b', 'uint8': 'B', 'int16': 'h', 'uint16': 'H',
    'int32': 'i', 'uint32': 'I', 'int64': 'q', 'uint64': 'Q', 'boolean': '?', 'octet': 'B',
}
#: Integer type -> its smallest and largest value.
INTEGER_RANGES = {
    **{f'int{bits}': (-(1 << bits - 1), (1 << bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f'uint{bits}': (0, (1 << bits) - 1) for bits in (8, 16, 32, 64)},
}


class Kind(Enum):
    """What a value is, apart from how many there are."""

    BOOL = 'true or false'
    INTEGER = 'an integer'
    FLOAT = 'a number'
    OCTET = 'a byte'
    TEXT = 'a string'
    MESSAGE = 'an object'


class Shape(Enum):
    """How many values a field has."""

    SINGLE = 'single'
    SEQUENCE = 'sequence'
    FIXED = 'fixed'


@dataclass(frozen=True)
class FieldType:
    """
    A field's type.

    :param basic: the name in IDL of a number, '' for others.
    :param message: the class of a message, None for others.
    :param size: of a fixed array, or the most values of a bounded sequence; 0 where unbounded.
    :param text_limit: the most characters of a string; 0 where unbounded.
    :param is_wide: whether it is a wstring.
    """

    kind: Kind
    shape: Shape
    basic: str = ''
    message: type[Any] | None = None
    size: int = 0
    text_limit: int = 0
    is_wide: bool = False

    @property
    def is_bytes(self) -> bool:
        """Whether it is an array of uint8, which JSON has as base64."""
        return self.shape is not Shape.SINGLE and self.basic == 'uint8'


def per_type(make: Callable[[type[Any]], T]) -> Callable[[type[Any]], T]:
    """Return a function that makes something once for each class."""
    made: dict[Any, T] = {}

    def get(cls: type[Any]) -> T:
        found = made.get(cls)
        if found is None:
            found = made[cls] = make(cls)
        return found

    return get


@per_type
def fields_of(cls: type[Any]) -> Mapping[str, FieldType]:
    """Return the fields of a message class in the order of its definition."""
    names = cls.get_fields_and_field_types()
    return {name: _field_type(slot) for name, slot in zip(names, cls.SLOT_TYPES, strict=False)}


@per_type
def flat_layout(cls: type[Any]) -> struct.Struct | None:
    """Return the layout of a class of numbers of the same size, as a point is; else None."""
    fields = fields_of(cls).values()
    if any(kind.kind not in (Kind.INTEGER, Kind.FLOAT) or kind.shape is not Shape.SINGLE
           for kind in fields):
        return None
    codes = [CODES[kind.basic] for kind in fields]
    return struct.Struct('<' + ''.join(codes)) if len(
        {struct.calcsize(code) for code in codes}) == 1 else None


def type_name(cls: type[Any]) -> str:
    """Return the ROS name of a message class, such as ``geometry_msgs/msg/Point``."""
    package, group = cls.__module__.split('.')[:2]
    return f'{package}/{group}/{cls.__name__}'


def is_stamp(cls: type[Any]) -> bool:
    """Return whether a class is a time or a duration."""
    return cls.__module__.startswith('builtin_interfaces.msg')


def is_header(cls: type[Any]) -> bool:
    """Return whether a class is the header with stamp and frame."""
    return cls.__module__.startswith('std_msgs.msg') and cls.__name__ == 'Header'


def _field_type(slot: Any) -> FieldType:
    shape, size = Shape.SINGLE, 0
    if isinstance(slot, AbstractNestedType):
        shape = Shape.FIXED if isinstance(slot, Array) else Shape.SEQUENCE
        if isinstance(slot, Array):
            size = slot.size
        elif isinstance(slot, BoundedSequence):
            size = slot.maximum_size
        slot = slot.value_type
    if isinstance(slot, BasicType):
        basic = slot.typename
        kinds = {'boolean': Kind.BOOL, 'octet': Kind.OCTET, 'float': Kind.FLOAT,
                 'double': Kind.FLOAT}
        return FieldType(kinds.get(basic, Kind.INTEGER), shape, basic, size=size)
    if isinstance(slot, (AbstractString, AbstractWString)):
        limit = getattr(slot, 'maximum_size', 0)
        return FieldType(Kind.TEXT, shape, size=size, text_limit=limit,
                         is_wide=isinstance(slot, AbstractWString))
    assert isinstance(slot, NamespacedType)
    return FieldType(Kind.MESSAGE, shape, message=_message_class(slot), size=size)


def _message_class(slot: NamespacedType) -> type[Any]:
    """Return the class of a nested message, also of a part of an action."""
    module = import_module('.'.join(slot.namespaces))
    found = getattr(module, slot.name, None)
    if found is None:
        name, _, part = slot.name.rpartition('_')
        found = getattr(getattr(module, name), part)
    return found  # type: ignore[no-any-return] # of a module that is imported by name
