# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Messages with anything in any field, and good ones with a few fields spoiled."""

from __future__ import annotations

import copy
from functools import cache
from importlib import import_module
import math
import re
from typing import Any

from hypothesis import strategies as st

FLOATS = (
    0.0, 1.0, -1.0, 0.5, 1e-3, 1e-12, 1e6, 1e300, -1e300, math.nan, math.inf, -math.inf, math.pi,
)
INTEGERS = {'uint8': (0, 255), 'int8': (-128, 127), 'uint16': (0, 2**16 - 1),
            'int16': (-(2**15), 2**15 - 1), 'uint32': (0, 2**32 - 1),
            'int32': (-(2**31), 2**31 - 1), 'uint64': (0, 2**64 - 1),
            'int64': (-(2**63), 2**63 - 1), 'octet': (0, 255), 'byte': (0, 255)}
MOST_ITEMS = 2


def words(names: tuple[str, ...]) -> Any:
    """Return texts: mostly names that exist, also none and nonsense."""
    usual = st.sampled_from((*names, '', '/', 'nobody', '<octomap>', 'a/b', 'ünï'))
    odd = st.text(st.characters(exclude_categories=('Cs',), exclude_characters='\0'), max_size=12)
    return st.one_of(usual, usual, usual, odd)


@cache
def anything(kind: str, names: tuple[str, ...]) -> Any:
    """
    Return the strategy of a field.

    :param kind: as ``get_fields_and_field_types`` writes it.
    :param names: texts that mean something to the server.
    """
    array = re.fullmatch(r'(?:sequence<(.+?)(?:, (\d+))?>|(.+)\[(\d+)\])', kind)
    if array:
        element = anything(array[1] or array[3], names)
        if array[4]:
            return st.lists(element, min_size=int(array[4]), max_size=int(array[4]))
        return st.lists(element, max_size=min(MOST_ITEMS, int(array[2] or MOST_ITEMS)))
    if kind in ('double', 'float'):
        narrow = kind == 'float'
        known = [v for v in FLOATS if not narrow or not math.isfinite(v) or abs(v) < 1e38]
        return st.one_of(st.sampled_from(known), st.floats(-2.0, 2.0, width=32 if narrow else 64))
    if kind == 'boolean':
        return st.booleans()
    if kind in ('octet', 'byte'):
        return st.integers(0, 5).map(lambda value: bytes([value]))
    if kind in INTEGERS:
        low, high = INTEGERS[kind]
        return st.one_of(st.integers(max(low, 0), 5), st.sampled_from((low, high)))
    if kind.startswith('string'):
        return words(names)
    return message(kind, names)


@cache
def message(kind: str, names: tuple[str, ...]) -> Any:
    """Return the strategy of a message type such as ``geometry_msgs/Pose``."""
    package, _, name = kind.partition('/')
    made = getattr(import_module(f'{package}.msg'), name)
    return of_type(made, names)


def of_type(made: Any, names: tuple[str, ...]) -> Any:
    """Return the strategy of a message class."""
    fields = {
        field: anything(kind, names)
        for field, kind in made.get_fields_and_field_types().items()
    }
    return st.fixed_dictionaries(fields).map(lambda values: made(**values))


@st.composite
def spoiled(draw: Any, good: Any, names: tuple[str, ...]) -> Any:
    """Draw a good message with up to five of its parts replaced by anything."""
    result = copy.deepcopy(good)
    for _ in range(draw(st.integers(1, 5))):
        _spoil(draw, result, names)
    return result


def _spoil(draw: Any, part: Any, names: tuple[str, ...]) -> None:
    """Replace one field somewhere in a message."""
    while True:
        fields = part.get_fields_and_field_types()
        name = draw(st.sampled_from(sorted(fields)))
        value = getattr(part, name)
        if hasattr(value, 'get_fields_and_field_types') and draw(st.integers(0, 9)):
            part = value
            continue
        inner = isinstance(value, list) and value and hasattr(
            value[0], 'get_fields_and_field_types'
        )
        if inner and draw(st.integers(0, 9)):
            part = draw(st.sampled_from(value))
            continue
        setattr(part, name, draw(anything(fields[name], names)))
        return
