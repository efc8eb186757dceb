# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parts of a YAML file as its author wrote them, moved and changed word by word."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
import re
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints, Union

from pydantic import BaseModel

from armsim_ros.config.yaml_node import YamlNode
from armsim_ros.errors import Location

_NO_CONTENT = re.compile(r'\s*(#.*)?$')
_QUOTED = re.compile(r'"[^"]*"|\'[^\']*\'')
_SCALAR = re.compile(r'"[^"]*"|\'[^\']*\'|[^\s,\]}]+')
_COMMENT = re.compile(r'(?:^|\s)(#.*)$')

#: Place of a value (line, column) -> the text that replaces it.
Edits = Mapping[tuple[int, int], str]


class SourceText:
    """
    A file's lines, and which of them belong to which key.

    :param file: the file, UTF-8.
    :param root: its content.
    """

    def __init__(self, file: Path, root: YamlNode) -> None:
        self.name = file.name
        self.lines = file.read_text(encoding='utf-8-sig').splitlines()
        self._ends: dict[tuple[int, int], int] = {}
        self._taken: set[int] = set()
        self._has_aliases = False
        self._measure(root, 1, len(self.lines) + 1)

    def block(self, node: YamlNode, column: int, edits: Edits | None = None,
              dropped: tuple[str, ...] = ()) -> list[str] | None:
        """
        Return the lines inside a mapping with their comments, at another indentation.

        :param node: a mapping.
        :param column: of its keys in the new text, from 0.
        :param edits: values to replace.
        :param dropped: keys whose lines are left out; their comments stay.
        :returns: None where its keys are not on separate lines.
        """
        if self._has_aliases or not self.has_own_lines(node):
            return None
        entries = list(node.entries.items())
        old = self._column(entries[0][1])
        result: list[str] = []
        for key, inner in entries:
            start, end = self._range(inner)
            if key in dropped:
                result += [f"{' ' * column}{text}" for text in self._comments(start, end)]
            else:
                result += [self._moved(number, old, column, edits or {})
                           for number in range(start, end)]
            self._taken.update(range(start, end))
        return _without_blank_ends(result)

    def remarks_above(self, node: YamlNode) -> list[str]:
        """Return the comments above a block's key and on its line."""
        start, line = self._with_leading_comments(_line(node)), _line(node)
        if self._has_aliases or not self.has_own_lines(node):
            return []
        self._taken.update(range(start, line + 1))
        return list(self._comments(start, line + 1))

    def has_own_lines(self, node: YamlNode) -> bool:
        """Return whether each key of a mapping begins a line."""
        places = [inner.key_where for inner in node.entries.values()]
        if not places or any(place is None or place.line is None for place in places):
            return False
        return all(self._begins_line(place) for place in places if place is not None)

    def edited(self, edits: Edits) -> list[str]:
        """Return the whole file with values replaced."""
        return [self._replaced(number, edits) for number in range(1, len(self.lines) + 1)]

    def other_comments(self) -> list[str]:
        """Return the comments of all lines that no block has taken."""
        left = sorted(set(range(1, len(self.lines) + 1)) - self._taken)
        return [text for number in left for text in self._comments(number, number + 1)]

    def _measure(self, node: YamlNode, first: int, end: int) -> None:
        """Record where each block ends; an alias refers to lines elsewhere."""
        inner = [*node.entries.values(), *node.items]
        if not inner:
            return
        starts = [_line(child) for child in inner]
        self._has_aliases |= starts != sorted(starts) or starts[0] < first or starts[-1] >= end
        for child, following in zip(inner, [*starts[1:], end], strict=True):
            line = _line(child)
            stop = following
            if line < following <= len(self.lines):
                stop = self._with_leading_comments(following)
            self._ends[line, _column(child)] = max(stop, line + 1)
            self._measure(child, line, max(stop, line + 1))

    def _range(self, node: YamlNode) -> tuple[int, int]:
        line = _line(node)
        return self._with_leading_comments(line), self._ends[line, _column(node)]

    def _with_leading_comments(self, line: int) -> int:
        while 1 < line <= len(self.lines) and _NO_CONTENT.fullmatch(self.lines[line - 2]):
            line -= 1
        return line

    def _begins_line(self, place: Location) -> bool:
        before = self.lines[(place.line or 1) - 1][:(place.column or 1) - 1]
        return not before.strip(' -')

    def _column(self, node: YamlNode) -> int:
        return _column(node) - 1

    def _moved(self, number: int, old: int, new: int, edits: Edits) -> str:
        line = self._replaced(number, edits)
        if not line.strip():
            return ''
        head, rest = line[:old], line[old:]
        if head.strip(' -'):  # a comment further left
            return ' ' * new + line.lstrip()
        return ' ' * new + rest if rest else ' ' * new + line.lstrip()

    def _replaced(self, number: int, edits: Edits) -> str:
        line = self.lines[number - 1]
        found = sorted(((column, text) for (where, column), text in edits.items()
                        if where == number), reverse=True)
        for column, text in found:
            old = _SCALAR.match(line, column - 1)
            if old is not None:
                line = line[:old.start()] + text + line[old.end():]
        return line.rstrip()

    def _comments(self, start: int, end: int) -> Iterator[str]:
        for number in range(start, end):
            bare = _QUOTED.sub(lambda match: '_' * len(match[0]), self.lines[number - 1])
            match = _COMMENT.search(bare)
            if match:
                yield self.lines[number - 1][match.start(1):]


def _line(node: YamlNode) -> int:
    return node.place.line or 1


def _column(node: YamlNode) -> int:
    return node.place.column or 1


def _without_blank_ends(lines: list[str]) -> list[str]:
    while lines and not lines[-1].strip():
        lines.pop()
    while lines and not lines[0].strip():
        lines.pop(0)
    return lines


def real_number_edits(kind: Any, node: YamlNode) -> dict[tuple[int, int], str]:
    """
    Return place -> text with a decimal point, of every whole number that is to be a double.

    :param kind: what the node is checked as: a settings class, or ``dict[str, X]``.
    """
    return {(inner.where.line, inner.where.column): _with_point(inner)
            for inner in _whole_numbers(kind, node)
            if inner.where.line is not None and inner.where.column is not None}


def _whole_numbers(kind: Any, node: YamlNode) -> Iterator[YamlNode]:
    if get_origin(kind) in (Union, UnionType):
        kind = next((member for member in get_args(kind) if member is not type(None)), kind)
    if kind is float:
        if isinstance(node.value, int) and not isinstance(node.value, bool):
            yield node
        return
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        extra = get_type_hints(kind).get('__pydantic_extra__')
        for key, inner in node.entries.items():
            field = kind.model_fields.get(key)
            yield from _whole_numbers(field.annotation if field else _values_of(extra), inner)
        return
    for inner in (*node.entries.values(), *node.items):
        yield from _whole_numbers(_values_of(kind), inner)


def _values_of(annotation: Any) -> Any:
    """Return X of ``dict[str, X]`` or ``tuple[X, ...]``; of a text the class is not known."""
    arguments = [argument for argument in get_args(annotation) if argument is not Ellipsis]
    return arguments[-1] if arguments else None


def _with_point(node: YamlNode) -> str:
    return f'{node.text}.0' if node.text.lstrip('+-').isdigit() else repr(float(str(node.value)))
