# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Type stubs of interface packages, as rosidl_generator_py's classes are: for checkers and editors.

A package gets one stub per folder (``msg/__init__.pyi`` ...) and the marker ``py.typed``. Reading
a field of a message gives what rclpy stores: ``array.array`` for sequences of numbers,
``numpy.ndarray`` for those of a fixed length, ``list`` for all others. Writing accepts any
sequence or set.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
import re

from rosidl_adapter.parser import (
    Field,
    MessageSpecification,
    parse_action_file,
    parse_message_file,
    parse_service_file,
    Type,
)

HEADER = """\
from array import array as _array
from collections.abc import Sequence as _Sequence, Set as _Set
from typing import Any as _Any, ClassVar as _ClassVar, Final as _Final

import numpy as _numpy
from numpy.typing import NDArray as _NDArray
"""

PYTHON_TYPES = {
    'bool': 'bool', 'byte': 'bytes', 'char': 'int', 'float32': 'float', 'float64': 'float',
    'string': 'str', 'wstring': 'str',
    **{f'{sign}int{bits}': 'int' for sign in ('', 'u') for bits in (8, 16, 32, 64)},
}
#: Types that rclpy does not keep in arrays of numbers.
LISTED = {'bool', 'byte', 'string', 'wstring'}


def write_stubs(package: str, definitions: Path, target: Path) -> None:
    """
    Write the stubs of one package.

    :param package: its name.
    :param definitions: the folder that holds msg/, srv/ and action/.
    :param target: the folder of its Python modules.
    """
    renderers: dict[str, Callable[[str, Path], Iterator[str]]] = {
        'msg': message, 'srv': service, 'action': action}
    for kind, render in renderers.items():
        files = sorted((definitions / kind).glob(f'*.{kind}'))
        if not files:
            continue
        lines = [line for file in files for line in ('', *render(package, file))]
        text = '\n'.join(lines).replace(f'{package}.{kind}.', '') + '\n'
        imports = sorted(set(re.findall(r'\b[a-z]\w*\.(?:msg|srv)(?=\.)', text)))
        folder = target / kind
        folder.mkdir(parents=True, exist_ok=True)
        (folder / '__init__.pyi').write_text(
            HEADER + ''.join(f'import {name}\n' for name in imports) + text, 'utf-8')
    target.mkdir(parents=True, exist_ok=True)
    for name in ('__init__.pyi', 'py.typed'):
        (target / name).touch()


def message(package: str, file: Path) -> Iterator[str]:
    """Yield the lines of a message."""
    yield from structure(file.stem, parse_message_file(package, str(file)))


def service(package: str, file: Path) -> Iterator[str]:
    """Yield the lines of a service."""
    specification = parse_service_file(package, str(file))
    yield f'class {file.stem}:'
    yield from indented(structure('Request', specification.request))
    yield from indented(structure('Response', specification.response))
    yield from indented(plain_structure('Event', [
        'info: service_msgs.msg.ServiceEventInfo',
        f'request: list[{file.stem}.Request]', f'response: list[{file.stem}.Response]']))


def action(package: str, file: Path) -> Iterator[str]:
    """Yield the lines of an action, with the services that carry it."""
    name = file.stem
    specification = parse_action_file(package, str(file))
    goal_id = 'goal_id: unique_identifier_msgs.msg.UUID'
    yield f'class {name}:'
    for part in ('Goal', 'Result', 'Feedback'):
        yield from indented(structure(part, getattr(specification, part.lower())))
    yield '    class Impl:'
    for carrier, request, response in (
            ('SendGoal', [goal_id, f'goal: {name}.Goal'],
             ['accepted: bool', 'stamp: builtin_interfaces.msg.Time']),
            ('GetResult', [goal_id], ['status: int', f'result: {name}.Result'])):
        yield f'        class {carrier}Service:'
        yield from indented(plain_structure('Request', request), 3)
        yield from indented(plain_structure('Response', response), 3)
    yield from indented(plain_structure(
        'FeedbackMessage', [goal_id, f'feedback: {name}.Feedback']), 2)
    yield '        CancelGoalService = action_msgs.srv.CancelGoal'
    yield '        GoalStatusMessage = action_msgs.msg.GoalStatusArray'


def plain_structure(name: str, fields: list[str]) -> Iterator[str]:
    """Yield the lines of a class whose fields are read and written as the same type."""
    yield f'class {name}:'
    yield from indented(fields)
    yield from indented(common([f'{field} = ...' for field in fields]))


def structure(name: str, specification: MessageSpecification) -> Iterator[str]:
    """Yield the lines of the class of a message."""
    yield f'class {name}:'
    for constant in specification.constants:
        value = bytes([constant.value]) if constant.type == 'byte' else constant.value
        yield f'    {constant.name}: _Final = {value!r}'
    for field in specification.fields:
        if field.default_value is not None:
            yield f'    {field.name.upper()}__DEFAULT: _ClassVar[{read_type(field.type)}]'
    for field in specification.fields:
        yield from indented(accessors(field))
    yield from indented(common([
        f'{field.name}: {written_type(field.type)} = ...' for field in specification.fields]))


def common(arguments: list[str]) -> Iterator[str]:
    """Yield the lines that the classes of all messages have."""
    yield 'SLOT_TYPES: _ClassVar[tuple[_Any, ...]]'
    yield '@classmethod'
    yield 'def get_fields_and_field_types(cls) -> dict[str, str]: ...'
    words = ', '.join(['self', '*', *arguments, 'check_fields: bool = ...'])
    yield f'def __init__({words}) -> None: ...'


def accessors(field: Field) -> Iterator[str]:
    """Yield the lines of a field: a property where it accepts more than it returns."""
    read, written = read_type(field.type), written_type(field.type)
    if read == written:
        yield f'{field.name}: {read}'
        return
    yield '@property'
    yield f'def {field.name}(self) -> {read}: ...'
    yield f'@{field.name}.setter'
    yield f'def {field.name}(self, value: {written}) -> None: ...'


def read_type(kind: Type) -> str:
    """Return the type of what a field returns."""
    element = element_type(kind)
    if not kind.is_array:
        return element
    if kind.pkg_name is not None or kind.type in LISTED:
        return f'list[{element}]'
    if kind.is_fixed_size_array():
        return f'_NDArray[_numpy.{"uint8" if kind.type == "char" else kind.type}]'
    return f'_array[{element}]'


def written_type(kind: Type) -> str:
    """Return the type of what a field accepts."""
    element, read = element_type(kind), read_type(kind)
    if not kind.is_array:
        return read
    accepted = f'_Sequence[{element}] | _Set[{element}]'
    return f'{read} | {accepted}' if read.startswith('_NDArray') else accepted


def element_type(kind: Type) -> str:
    """Return the type of a field, or of its elements."""
    if kind.pkg_name is None:
        return PYTHON_TYPES[kind.type]
    return f'{kind.pkg_name}.msg.{kind.type}'


def indented(lines: Iterable[str], levels: int = 1) -> Iterator[str]:
    """Yield lines moved to the right."""
    for line in lines:
        yield '    ' * levels + line
