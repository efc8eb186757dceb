# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""YAML values that remember where they were written."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from armsim_ros.errors import Location

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
