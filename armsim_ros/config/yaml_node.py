# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""YAML values that remember where they were written: YAML 1.1 as ROS reads it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
import math
import re
from typing import Any

from armsim_ros.errors import Location

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


#: The key below which a parameter file of ROS 2 has the parameters of a node.
ROS2_KEY = 'ros__parameters'
Scalar = str | int | float | bool | None
Path = Sequence[str | int]


@dataclass(frozen=True, slots=True, eq=False)
class YamlNode:
    """
    A value, its place, and the same for everything inside it.

    :param value: a scalar, a tuple of nodes, or a mapping from the key's text to a node.
    :param where: the place of the value.
    :param key_where: the place of the key that it belongs to.
    :param text: the text as written, of a scalar.
    :param size: count of all nodes inside, aliases expanded.
    """

    value: Scalar | tuple[YamlNode, ...] | Mapping[str, YamlNode]
    where: Location
    key_where: Location | None = None
    text: str = ''
    size: int = 1

    @property
    def place(self) -> Location:
        """Where a message about this value points: its key, if any."""
        return self.key_where or self.where

    @property
    def entries(self) -> Mapping[str, YamlNode]:
        """The entries of a mapping; empty for every other value."""
        return self.value if isinstance(self.value, Mapping) else {}

    @property
    def items(self) -> tuple[YamlNode, ...]:
        """The items of a sequence; empty for every other value."""
        return self.value if isinstance(self.value, tuple) else ()

    @property
    def is_mapping(self) -> bool:
        """Whether this is a mapping."""
        return isinstance(self.value, Mapping)

    @property
    def kind(self) -> str:
        """What the value is, as a phrase for a message."""
        if isinstance(self.value, Mapping):
            return 'a block of keys'
        if isinstance(self.value, tuple):
            return 'a list'
        if self.value is None:
            return 'empty'
        if isinstance(self.value, bool):
            return f"the truth value '{self.text}'"
        if isinstance(self.value, str):
            return f"the text '{self.text}'"
        return f'the number {self.text}'

    def plain(self) -> Any:
        """Return the value as plain dicts, lists and scalars."""
        if isinstance(self.value, Mapping):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, tuple):
            return [node.plain() for node in self.value]
        return self.value

    def get(self, key: str) -> YamlNode | None:
        """Return an entry of a mapping, None where there is none."""
        return self.entries.get(key)

    def find(self, path: Path) -> tuple[YamlNode, int]:
        """
        Return the node at a path, or the nearest node above it that exists.

        :returns: the node, and how many steps of the path were found.
        """
        node = self
        for steps, step in enumerate(path):
            inner = node.entries.get(str(step))
            if isinstance(step, int) and step < len(node.items):
                inner = node.items[step]
            if inner is None:
                return node, steps
            node = inner
        return node, len(path)

    def locate(self, path: Path) -> Location | None:
        """Return the place of the value at a path, None where nothing is written there."""
        node, steps = self.find(path)
        return node.place if steps == len(path) else None

    def walk(self) -> Iterator[YamlNode]:
        """Yield this node and all inside it, depth first, each shared node once."""
        seen: set[int] = set()
        pending = [self]
        while pending:
            node = pending.pop()
            if id(node) in seen:
                continue
            seen.add(id(node))
            yield node
            pending.extend(reversed((*node.entries.values(), *node.items)))

    def with_value(self, value: Mapping[str, YamlNode]) -> YamlNode:
        """Return this node with other entries."""
        return replace(self, value=value, size=1 + sum(node.size for node in value.values()))

    def without(self, *keys: str) -> YamlNode:
        """Return this mapping without some keys."""
        return self.with_value(
            {key: node for key, node in self.entries.items() if key not in keys})


def node_of(value: Any, where: Location) -> YamlNode:
    """Return plain data as a node whose parts are all at the same place."""
    if isinstance(value, Mapping):
        inner = {str(key): node_of(item, where) for key, item in value.items()}
        return YamlNode({}, where).with_value(inner)
    if isinstance(value, (list, tuple)):
        items = tuple(node_of(item, where) for item in value)
        return YamlNode(items, where, size=1 + sum(item.size for item in items))
    return YamlNode(value, where, text=str(value))


def split_keys(node: YamlNode, separator: str, *, keep: frozenset[str] = frozenset()) -> YamlNode:
    """
    Return a mapping in which ``a.b: v`` became ``a: {b: v}``, at every depth.

    :param separator: ``.`` for ROS 2 parameters, ``/`` for ROS 1.
    :param keep: keys whose blocks stay as they are.
    """
    if not node.is_mapping:
        return node
    result: dict[str, YamlNode] = {}
    for key, inner in node.entries.items():
        split = inner if key in keep else split_keys(inner, separator, keep=keep)
        head, *rest = [part for part in key.split(separator) if part] or [key]
        for part in reversed(rest):
            split = YamlNode({}, inner.where, inner.key_where).with_value({part: split})
        existing = result.get(head)
        if existing is not None and existing.is_mapping and split.is_mapping:
            split = merge_nodes(existing, split)[0]
        result[head] = split
    return node.with_value(result)


def merge_nodes(
    first: YamlNode, second: YamlNode
) -> tuple[YamlNode, list[tuple[str, YamlNode, YamlNode]]]:
    """
    Lay the entries of two mappings over each other.

    :returns: the mapping, and every (dotted key, first, second) whose two values differ; the
        second is in the mapping.
    """
    entries = dict(first.entries)
    conflicts: list[tuple[str, YamlNode, YamlNode]] = []
    for key, node in second.entries.items():
        known = entries.get(key)
        if known is not None and known.is_mapping and node.is_mapping:
            entries[key], inner = merge_nodes(known, node)
            conflicts += [(f'{key}.{path}', a, b) for path, a, b in inner]
            continue
        if known is not None and known.plain() != node.plain():
            conflicts.append((key, known, node))
        entries[key] = node
    return first.with_value(entries), conflicts


def parameters_of_node(root: YamlNode, name: str, namespace: str) -> YamlNode | None:
    """
    Return the parameters of a node, nested; None where no key of the file names it.

    A key ``/ns/name`` or nested keys name it; ``*`` matches one part of a name and ``**`` for
    any number of them. What names the node wins over wildcards.

    :param namespace: such as ``/sunday``; ``/`` is none.
    """
    own = [part for part in namespace.split('/') if part] + [name]
    found = [(sum(part in ('*', '**') for part in path), block)
             for path, block in _blocks(root, ()) if block.is_mapping and _fits(path, own)]
    merged: YamlNode | None = None
    for _, block in sorted(found, key=lambda each: -each[0]):
        block = split_keys(block, '.')
        merged = block if merged is None else merge_nodes(merged, block)[0]
    return merged


def is_ros2_file(root: YamlNode) -> bool:
    """Return whether a file has the parameters of nodes, and is not in the layout of ROS 1."""
    return next(_blocks(root, ()), None) is not None


def names_without_namespace(root: YamlNode, name: str) -> bool:
    """Return whether a file has a node under its bare name, which fits no namespace."""
    block = root.get(name)
    return block is not None and block.is_mapping and ROS2_KEY in block.entries


def _blocks(node: YamlNode, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], YamlNode]]:
    for key, inner in node.entries.items():
        if key == ROS2_KEY:
            yield path, inner
        elif inner.is_mapping:
            yield from _blocks(inner, (*path, *(part for part in key.split('/') if part)))


def _fits(path: Sequence[str], own: Sequence[str]) -> bool:
    if not path:
        return not own
    if path[0] == '**':
        return any(_fits(path[1:], own[start:]) for start in range(len(own) + 1))
    return bool(own) and path[0] in ('*', own[0]) and _fits(path[1:], own[1:])
