# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a YAML scalar means: YAML 1.1 as ROS reads it, numbers as people write them."""

from __future__ import annotations

import math
import re

_NULL = {'', '~', 'null', 'Null', 'NULL'}
_TRUE = {'true', 'True', 'TRUE', 'yes', 'Yes', 'YES', 'on', 'On', 'ON'}
_FALSE = {'false', 'False', 'FALSE', 'no', 'No', 'NO', 'off', 'Off', 'OFF'}
_INT = re.compile(r'[-+]?[0-9]+')
_LEADING_ZERO = re.compile(r'[-+]?0[0-9]+')
_HEX = re.compile(r'[-+]?0x[0-9a-fA-F]+')
_FLOAT = re.compile(r'[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?')
_INF = re.compile(r'([-+]?)\.(inf|Inf|INF)')
_NAN = {'.nan', '.NaN', '.NAN'}
_ANGLE = re.compile(r'(deg|rad)\((.+)\)')
_PI = re.compile(r'([-+]?)(?:([0-9.]+)\s*\*\s*)?pi(?:\s*/\s*([0-9.]+))?')
_LONGEST_NUMBER = 100


class ScalarError(ValueError):
    """A scalar that cannot be read; with the reason."""


def read_plain_scalar(text: str) -> str | int | float | bool | None:
    """
    Return the value of a scalar without quotes and without a tag.

    ``1e-3`` is a number (a strict YAML 1.1 reader takes it for a text), and so are rosparam's
    ``deg(90)`` and ``rad(pi/2)``. As in YAML 1.1, ``010`` is octal and ``08`` a text.
    """
    if text in _NULL:
        return None
    if text in _TRUE:
        return True
    if text in _FALSE:
        return False
    if len(text) > _LONGEST_NUMBER:
        return text
    if _LEADING_ZERO.fullmatch(text):
        return text if {'8', '9'} & set(text) else int(text, 8)
    number = _read_number(text)
    if number is not None:
        return number
    angle = _ANGLE.fullmatch(text)
    return _read_angle(angle[1], angle[2]) if angle else text


def read_tagged_scalar(tag: str, text: str) -> str | int | float | bool | None:
    """
    Return the value of a scalar with a tag such as ``!degrees``.

    :raises ScalarError: for a tag that is not known, or that does not fit the text.
    """
    if tag in ('!', 'tag:yaml.org,2002:str'):
        return text
    if tag in ('!degrees', '!radians'):
        return _read_angle(tag[1:4], text)
    value = read_plain_scalar(text)
    kinds: dict[str, tuple[type, ...]] = {
        'tag:yaml.org,2002:int': (int,),
        'tag:yaml.org,2002:float': (int, float),
        'tag:yaml.org,2002:bool': (bool,),
        'tag:yaml.org,2002:null': (type(None),),
    }
    if tag not in kinds:
        raise ScalarError(f"the tag '{tag}' is not allowed in a settings file")
    if not isinstance(value, kinds[tag]):
        raise ScalarError(f"'{text}' does not fit its tag")
    return float(value) if tag.endswith('float') and isinstance(value, int) else value


def _read_number(text: str) -> int | float | None:
    if _INT.fullmatch(text):
        return int(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    if _HEX.fullmatch(text):
        return int(text, 16)
    infinite = _INF.fullmatch(text)
    if infinite:
        return -math.inf if infinite[1] == '-' else math.inf
    return math.nan if text in _NAN else None


def _read_angle(unit: str, text: str) -> float:
    """Return [rad]; ``text`` is a number, or a multiple of pi such as ``-3*pi/4``."""
    text = text.strip()
    number = _read_number(text)
    multiple = _PI.fullmatch(text)
    try:
        if number is None and multiple:
            sign = -1.0 if multiple[1] == '-' else 1.0
            number = sign * float(multiple[2] or 1) * math.pi / float(multiple[3] or 1)
    except (ValueError, ZeroDivisionError):
        number = None
    if number is None:
        raise ScalarError(f"'{text}' is not an angle; allowed: a number, or pi with a factor and "
                          'a divisor such as 3*pi/4')
    return math.radians(number) if unit == 'deg' else float(number)
