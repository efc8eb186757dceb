# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Interface types: their Python classes and their definition files."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from armsim_ros2.errors import CliError, hint
from armsim_ros2.packages import prefix_of, resources

KINDS = ('msg', 'srv', 'action')
_PRIMITIVES = frozenset((
    'bool', 'byte', 'char', 'float32', 'float64', 'int8', 'uint8', 'int16', 'uint16', 'int32',
    'uint32', 'int64', 'uint64', 'string', 'wstring'))
#: Attributes by which the classes of each kind are distinguished.
_MARKS = {'msg': ('SLOT_TYPES',), 'srv': ('Request', 'Response'),
          'action': ('Goal', 'Result', 'Feedback')}


def load(name: str, kind: str, message: str = "The type '{}' is invalid") -> Any:
    """
    Return the class of an interface type.

    :param name: such as ``std_msgs/msg/String`` or ``std_msgs/String``.
    :param kind: msg, srv or action.
    :param message: of the failure; {} is the name.
    :raises CliError: there is no such type, or its package is not installed.
    """
    parts = name.split('/')
    if len(parts) == 2:
        parts.insert(1, kind)
    if len(parts) == 3 and all(parts):
        try:
            found = getattr(import_module('.'.join(parts[:2])), parts[2], None)
        except ImportError:
            found = None
        if found is not None and all(hasattr(found, mark) for mark in _MARKS[kind]):
            return found
    raise CliError(message.format(name) + _hint('/'.join(parts), kind))


def _hint(name: str, kind: str) -> str:
    """Return a hint at the most similar interface, of the same package if it is installed."""
    package, _, rest = name.partition(f'/{kind}/')
    own = [full.rpartition('/')[2] for full in all_names(package) if f'/{kind}/' in full]
    if own:
        return hint(rest, own)
    return hint(name, [full for full in all_names() if f'/{kind}/' in full])


def all_names(package: str | None = None) -> list[str]:
    """
    Return the names of all installed interfaces, sorted by package and name.

    :param package: only those of this package.
    """
    names = []
    for name, prefix in resources('rosidl_interfaces').items():
        if package not in (None, name):
            continue
        index = prefix / 'share/ament_index/resource_index/rosidl_interfaces' / name
        found = {line.rpartition('.')[0] for line in index.read_text().split()
                 if '_' not in line and line.startswith(('msg/', 'srv/', 'action/'))}
        names += [f'{name}/{relative}' for relative in sorted(found)]
    return names


def definition_file(name: str) -> Path:
    """
    Return the file that defines an interface.

    :param name: such as ``std_msgs/msg/String``.
    :raises CliError: the name is malformed, or there is no such interface.
    """
    parts = name.split('/')
    if len(parts) != 3 or not all(parts) or '..' in parts:
        raise CliError(f"Invalid name '{name}'. Expected three parts separated by '/'"
                       + hint(name, all_names()))
    package, kind, _ = parts
    folder = prefix_of(package, "Unknown package '{}'") / 'share'
    for suffix in (kind, 'idl'):
        file = folder / f'{name}.{suffix}'
        if file.is_file():
            return file
    raise CliError(f"Could not find the interface '{folder / name}'{hint(name, all_names())}")


def nested_type(code: str, package: str) -> str | None:
    """
    Return the message type of a field, None for other lines.

    :param code: a line of a definition without its comment.
    :param package: that the definition belongs to.
    """
    words = code.split()
    if len(words) < 2:
        return None
    kind = words[0].partition('[')[0].partition('<')[0]
    if kind in _PRIMITIVES:
        return None
    return kind.replace('/', '/msg/') if '/' in kind else f'{package}/msg/{kind}'


def definition_text(name: str) -> str:
    """
    Return the definition of a message with those of all messages in it, as ``ros2msg`` of MCAP.

    :raises CliError: it or a type in it is not installed.
    """
    texts: dict[str, str] = {}
    pending = [name]
    while pending:
        kind = pending.pop(0)
        if kind not in texts:
            texts[kind] = definition_file(kind).read_text(encoding='utf-8')
            codes = (line.partition('#')[0].strip() for line in texts[kind].splitlines())
            found = (nested_type(code, kind.partition('/')[0]) for code in codes)
            pending += [nested for nested in found if nested]
    first = texts.pop(name)
    return first + ''.join(f'{"=" * 80}\nMSG: {kind.replace("/msg/", "/")}\n{text}'
                           for kind, text in texts.items())
