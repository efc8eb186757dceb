# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Values of messages: from YAML, to YAML and CSV, truncated, and single fields."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
import re
import sys
from typing import Any

import yaml

from armsim_ros2.errors import CliError, hint
from armsim_ros2.interfaces import load

#: Sets a field to the time of publication.
StampSetter = Callable[[Any], None]
_STEP = re.compile(r'\.?([A-Za-z_]\w*)|\[(-?\d+)\]')


def parse(text: str, message: str = 'The passed value needs to be a dictionary in YAML format'
          ) -> dict[str, Any]:
    """
    Return the values in a YAML text.

    :param message: of the failure if it is not a dictionary.
    :raises CliError: the text is not YAML, or not a dictionary.
    """
    try:
        values = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise CliError(f'{message}: {" ".join(str(error).split())}') from None
    if values is None:
        return {}
    if not isinstance(values, dict):
        raise CliError(f"{message}; got '{text}'")
    return values


def fill(message: Any, values: dict[str, Any], stamps: bool = False,
         prefix: str = 'Failed to populate field') -> list[StampSetter]:
    """
    Set fields of a message.

    :param values: field -> value, nested like the message.
    :param stamps: whether the value ``auto`` of a Header and ``now`` of a Time are replaced by
        the time of publication.
    :param prefix: of the message of a failure.
    :returns: functions that set these times.
    :raises CliError: there is no such field, or a value does not fit; names the field.
    """
    setters: list[StampSetter] = []
    try:
        _fill(message, values, '', setters if stamps else None)
    except _MismatchError as mismatch:
        raise CliError(f'{prefix}: {mismatch}') from None
    return setters


class _MismatchError(Exception):
    """A value does not fit its field."""


def _fill(message: Any, values: Any, path: str, setters: list[StampSetter] | None) -> None:
    if not isinstance(values, dict):
        raise _MismatchError(f"Value '{values}'{path and ' of ' + path} is expected to be a "
                             f'dictionary but is a {type(values).__name__}')
    # Types and ranges are checked here; otherwise serialization fails, or cuts the value.
    message._check_fields = True
    types = _slot_types(message)
    for name, value in values.items():
        where = f'{path}.{name}' if path else str(name)
        if name not in types:
            raise _MismatchError(f"'{type(message).__name__}' object has no attribute '{where}'"
                                 f'{hint(str(name), types)} (fields: {", ".join(types)})')
        kind = _class_name(getattr(message, name))
        if setters is not None and (value, kind) == ('auto', 'std_msgs/Header'):
            setters.append(_setter(getattr(message, name), 'stamp'))
            continue
        if setters is not None and (value, kind) == ('now', 'builtin_interfaces/Time'):
            setters.append(_setter(message, name))
            continue
        try:
            setattr(message, name, _converted(getattr(message, name), value, types[name],
                                              where, setters))
        except (AssertionError, OverflowError, TypeError, ValueError) as error:
            raise _MismatchError(f"'{where}' cannot be {value!r}: "
                                 f'{" ".join(str(error).split())}') from None


def _converted(old: Any, value: Any, slot: Any, path: str,
               setters: list[StampSetter] | None) -> Any:
    """Return a value of the type of a field's present value."""
    if hasattr(old, 'SLOT_TYPES'):
        _fill(old, value, path, setters)
        return old
    if hasattr(old, 'typecode'):
        return type(old)(old.typecode, value)
    if hasattr(old, 'dtype'):
        import numpy

        return numpy.array(value, dtype=old.dtype)
    if isinstance(old, list):
        element: Any = getattr(slot, 'value_type', None)
        if not isinstance(value, (list, tuple)):
            raise TypeError(f'a list is expected, not a {type(value).__name__}')
        if not hasattr(element, 'namespaces'):
            return list(value)
        items = []
        for i, entry in enumerate(value):
            items.append(load('/'.join(element.namespaced_name()), 'msg')())
            _fill(items[-1], entry, f'{path}[{i}]', setters)
        return items
    if isinstance(old, bool) and isinstance(value, str):
        raise TypeError('true or false is expected, not a text')
    if isinstance(old, bytes) and isinstance(value, int):
        return bytes([value])
    return value if type(value) is type(old) else type(old)(value)


def _setter(target: Any, field: str) -> StampSetter:
    return lambda stamp: setattr(target, field, stamp)


def _slot_types(message: Any) -> dict[str, Any]:
    return dict(zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True))


def _class_name(value: Any) -> str:
    return f'{type(value).__module__.split(".")[0]}/{type(value).__name__}'


@dataclass(frozen=True)
class Style:
    """
    How much of a message is shown.

    :param most: longer texts and arrays are cut to this length and marked by ``...``.
    :param no_arr: replace arrays by their type and length.
    :param no_str: replace texts by their length.
    """

    most: int | None = None
    no_arr: bool = False
    no_str: bool = False


ALL = Style()


def to_plain(message: Any, style: Style = ALL, scalar: Callable[[Any], Any] | None = None
             ) -> dict[str, Any]:
    """
    Return a message as dictionaries, lists and scalars.

    :param scalar: converts numbers and bytes; by default to Python's numbers and to texts.
    """
    return {name: _plain(getattr(message, name), slot, style, scalar or _python_value)
            for name, slot in _slot_types(message).items()}


def _plain(value: Any, slot: Any, style: Style, scalar: Callable[[Any], Any]) -> Any:
    if hasattr(value, 'SLOT_TYPES'):
        return to_plain(value, style, scalar)
    if isinstance(value, str) and style.no_str:
        return f'<string length: <{len(value)}>>'
    if not hasattr(value, '__len__'):
        return scalar(value)
    cut = value[:style.most]
    if isinstance(value, (bytes, str)):
        text = cut if isinstance(cut, str) else scalar(cut)
        return text if len(cut) == len(value) else f'{text}...'
    if style.no_arr:
        return array_text(value, slot)
    items = [_plain(item, None, style, scalar) for item in cut]
    return items if len(cut) == len(value) else [*items, '...']


def _python_value(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.decode('latin-1')
    return value.item() if hasattr(value, 'item') else value


def array_text(value: Any, slot: Any) -> str:
    """Return the type and length of an array field."""
    element = slot.value_type
    if hasattr(element, 'namespaced_name'):
        name = '/'.join(element.namespaced_name())
    else:
        name = getattr(element, 'typename', None) or (
            'wstring' if 'WString' in type(element).__name__ else 'string')
    if hasattr(slot, 'size'):
        return f'<array type: {name}[{slot.size}]>'
    bound = f'[{slot.maximum_size}]' if hasattr(slot, 'maximum_size') else ''
    return f'<sequence type: {name}{bound}, length: {len(value)}>'


class _Dumper(yaml.Dumper):
    """Keeps the order of mappings; the flow style is that of lists only, as upstream."""


_Dumper.add_representer(dict, lambda dumper, mapping: yaml.MappingNode(
    'tag:yaml.org,2002:map',
    [(dumper.represent_data(key), dumper.represent_data(value))
     for key, value in mapping.items()]))


def to_yaml(message: Any, style: Style = ALL, flow: bool = False) -> str:
    """Return a message as YAML."""
    return dump(to_plain(message, style), flow)


def dump(value: Any, flow: bool = False) -> str:
    """Return plain values as YAML, in the order of their fields."""
    return str(yaml.dump(value, Dumper=_Dumper, allow_unicode=True, width=sys.maxsize,
                         default_flow_style=flow))


def to_csv(message: Any, style: Style = ALL) -> str:
    """Return a message as comma-separated values."""
    return ','.join(_leaves(to_plain(message, style, scalar=str)))


def _leaves(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif not value:  # an empty array is an empty field
        yield ''
    else:
        for part in value.values() if isinstance(value, dict) else value:
            yield from _leaves(part)


def field_of(expression: str) -> Callable[[Any], Any]:
    """
    Return a function that reads a part of a message.

    :param expression: such as ``pose.position`` or ``points[0].positions``.
    :raises CliError: the expression is malformed; the function raises it where the message has no
        such part.
    """
    steps: list[str | int] = []
    at = 0
    while at < len(expression):
        match = _STEP.match(expression, at)
        if match is None:
            break
        steps.append(match[1] if match[1] else int(match[2]))
        at = match.end()
    if at < len(expression) or not steps:
        raise CliError(f"Invalid field value '{expression}'")

    def read(message: Any) -> Any:
        value = message
        for step in steps:
            try:
                value = value[step] if isinstance(step, int) else getattr(value, step)
            except (AttributeError, IndexError, TypeError) as error:
                known: Any = getattr(value, 'get_fields_and_field_types', dict)()
                raise CliError(f"Invalid field '{expression}': {error}"
                               f'{hint(str(step), known)}') from None
        return value

    return read


def predicate(expression: str) -> Callable[[Any], bool]:
    """
    Return a function that evaluates a Python expression of the message ``m``.

    :raises CliError: it is not an expression; the function raises it where it fails.
    """
    try:
        code = compile(expression, '--filter', 'eval')
    except SyntaxError as error:
        raise CliError(f"Invalid filter '{expression}': {error.msg}") from None

    def check(message: Any) -> bool:
        try:
            return bool(eval(code, {'m': message}))
        except Exception as error:  # noqa: BLE001 - anything the user's expression raises
            raise CliError(f"Invalid filter '{expression}': {error}") from None

    return check
