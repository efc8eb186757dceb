# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""YAML text to values with places; errors in the text are reported with their likely cause."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
import re
from typing import Any, NoReturn

import yaml

from armsim_ros.config.yaml_node import (
    merge_nodes,
    read_plain_scalar,
    read_tagged_scalar,
    Scalar,
    ScalarError,
    YamlNode,
)
from armsim_ros.errors import ConfigError, ignored, Location, nearest, Problem

_SECOND_KEY = re.compile(r'(?<!:)[\w\]\'"]\s*:(?=\s+\S|\S+:\s)')
_COMMENT_AT_COLON = re.compile(r':#')
_NO_SPACE_AFTER_DASH = re.compile(r'^\s*-[A-Za-z_]')
_WIDE_SIGNS = {'\uff1a': ':', '\uff0c': ',', '\u201c': '"', '\u201d': '"', '\u2018': "'",
               '\u2019': "'", '\u00a0': 'a plain space', '\u3000': 'a plain space'}


def explain_syntax(error: yaml.YAMLError, text: str, file: str) -> Problem:
    """
    Return the problem that represents a parser's error.

    :param text: the whole text that was parsed.
    """
    lines = text.splitlines()
    mark: Any = getattr(error, 'problem_mark', None) or getattr(error, 'context_mark', None)
    if mark is None:
        return _unreadable_character(error, text, file)
    number = min(mark.line, max(len(lines) - 1, 0))
    what = str(getattr(error, 'problem', '') or 'this is not YAML')
    tab = _line_indented_with_tab(lines, number)
    if tab is not None:
        return Problem('the line is indented with a tab', Location(file, tab + 1, 1),
                       'spaces only', 'replace each tab by spaces')
    context = str(getattr(error, 'context', '') or '')
    opened: Any = getattr(error, 'context_mark', None)
    if opened is not None and ('flow' in context or 'quoted' in context):
        sign = 'quote' if 'quoted' in context else 'bracket'
        return Problem(f'the {sign} that opens here is not closed',
                       Location(file, opened.line + 1, opened.column + 1),
                       remedy=f'the reader noticed in line {number + 1}')
    line = lines[number] if lines else ''
    cause, culprit = _likely_cause(lines, number)
    shown = f": '{line.strip()[:60]}'" if line.strip() else ''
    column = mark.column + 1 if culprit == number else None
    return Problem(f'{what}{shown}' if culprit == number else what,
                   Location(file, culprit + 1, column), remedy=cause)


def _line_indented_with_tab(lines: list[str], last: int) -> int | None:
    """Return the nearest line at or above the error that is indented with a tab."""
    for number in range(min(last, len(lines) - 1), -1, -1):
        line = lines[number]
        if '\t' in line[:len(line) - len(line.lstrip())] and line.strip():
            return number
    return None


def _likely_cause(lines: list[str], number: int) -> tuple[str, int]:
    """Return what probably went wrong, and in which line (from 0)."""
    for candidate in (number, number - 1):
        if not 0 <= candidate < len(lines):
            continue
        line = lines[candidate]
        for sign, plain in _WIDE_SIGNS.items():
            if sign in line.split('#')[0]:
                return f"the sign '{sign}' is not YAML's: write {plain}", candidate
        if _COMMENT_AT_COLON.search(line):
            return "a comment needs a space before '#', and a value or a new line after ':'", \
                candidate
        if len(_SECOND_KEY.findall(line.split(' #')[0])) > 1 and '{' not in line:
            return 'several keys are on the same line: give each a line of its own', candidate
        if _NO_SPACE_AFTER_DASH.match(line):
            return "a list's '-' needs a space after it", candidate
    line = lines[number] if 0 <= number < len(lines) else ''
    if line.strip() and ':' not in line and not line.lstrip().startswith('-'):
        return "the line has neither ':' nor '- ' and is not a comment", number
    return 'check the indentation: all keys of a block begin in the same column, deeper than ' \
        'the key above them', number


def _unreadable_character(error: yaml.YAMLError, text: str, file: str) -> Problem:
    for position, sign in enumerate(text):
        if (ord(sign) < 32 and sign not in '\t\n\r') or sign == '\x7f':
            line = text.count('\n', 0, position) + 1
            column = position - text.rfind('\n', 0, position)
            return Problem(f'the sign 0x{ord(sign):02x} is not allowed in YAML',
                           Location(file, line, column),
                           remedy='is this a text file? remove the sign')
    return Problem(str(error).splitlines()[0], Location(file))


LARGEST_FILE = 1 << 20
DEEPEST_NESTING = 50
MOST_VALUES = 100_000

_LOADER: Any = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
_MERGE_KEY = '<<'


def read_yaml_file(path: Path, problems: list[Problem] | None = None, *,
                   substitute: Callable[[str], str] | None = None) -> YamlNode:
    """
    Read a settings file.

    :param problems: takes a warning for each key that is defined twice; None refuses them.
    :param substitute: changes the text before it is parsed, line by line.
    :returns: a mapping; empty for a file without values.
    :raises ConfigError: where the file cannot be read or is not a YAML mapping.
    """
    name = str(path)
    if path.exists() and not (path.is_file() or path.is_dir()):  # reading a pipe may never end
        raise ConfigError(Problem('cannot be read: it is not a regular file', Location(name)))
    try:
        with path.open('rb') as stream:
            data = stream.read(LARGEST_FILE + 1)
    except OSError as error:
        raise ConfigError(Problem(f'cannot be read: {error.strerror}', Location(name))) from None
    if substitute is None or len(data) > LARGEST_FILE:
        return parse_yaml(data, name, problems)
    return parse_yaml(substitute(_decode(data, name)), name, problems)


def parse_yaml(data: bytes | str, file: str,
               problems: list[Problem] | None = None) -> YamlNode:
    """
    Parse the text of a settings file.

    :param data: the text; bytes must be UTF-8.
    :param file: the name that messages give.
    :param problems: takes a warning for each key that is defined twice; None refuses them. Of two
        blocks of a file of ROS 2 parameters both count, as rcl reads them, else the second.
    :raises ConfigError: with a problem that names file, line and likely cause.
    """
    if len(data) > LARGEST_FILE:
        raise ConfigError(Problem(
            f'the file is larger than {LARGEST_FILE >> 20} MiB', Location(file),
            remedy='settings files are small: is this the right file?'))
    text = data if isinstance(data, str) else _decode(data, file)
    merges = 'ros__parameters' in text
    try:
        return _Composer(file, problems, merges).compose(text)
    except yaml.YAMLError as error:
        mark: Any = getattr(error, 'problem_mark', None)
        if mark is not None and 'nesting' in str(getattr(error, 'problem', '')):
            # PyYAML 6.0.4 gives up at its own depth before it passes on the levels above.
            with suppress(yaml.YAMLError):
                _Composer(file, problems, merges).compose(text[:mark.index])
        raise ConfigError(explain_syntax(error, text, file)) from None


def _decode(data: bytes, file: str) -> str:
    if data[:2] in (b'\xff\xfe', b'\xfe\xff'):
        raise ConfigError(Problem(
            'the text is UTF-16', Location(file, 1), 'UTF-8',
            f"save it as UTF-8, e.g. with 'iconv -f UTF-16 -t UTF-8 {file}'"))
    try:
        return data.decode('utf-8-sig')
    except UnicodeDecodeError as error:
        line = data.count(b'\n', 0, error.start) + 1
        column = error.start - data.rfind(b'\n', 0, error.start)
        raise ConfigError(Problem(
            f'byte 0x{data[error.start]:02x} is not UTF-8', Location(file, line, column), 'UTF-8',
            'the file was probably saved in the encoding of an editor or system, such as GBK or '
            f"Latin-1: save it as UTF-8, e.g. with 'iconv -f GBK -t UTF-8 {file}'")) from None


class _Collection:
    """A mapping or sequence whose end was not yet read."""

    def __init__(self, is_mapping: bool, anchor: str | None, where: Location) -> None:
        self.is_mapping, self.anchor, self.where = is_mapping, anchor, where
        self.items: list[YamlNode] = []
        self.entries: dict[str, YamlNode] = {}
        self.merged: dict[str, YamlNode] = {}
        self.key: YamlNode | None = None


class _Composer:
    """Builds nodes from the parser's events; no recursion, so depth costs nothing."""

    def __init__(self, file: str, problems: list[Problem] | None, merges: bool) -> None:
        self._file, self._problems, self._merges = file, problems, merges
        self._anchors: dict[str, YamlNode | None] = {}
        self._open: list[_Collection] = []
        self._root: YamlNode | None = None
        self._documents = 0

    def compose(self, text: str) -> YamlNode:
        for event in yaml.parse(text, Loader=_LOADER):
            self._take(event)
        where = Location(self._file, 1, 1)
        root = self._root or YamlNode({}, where)
        if root.value is None:
            return YamlNode({}, where)
        if not root.is_mapping:
            self._refuse(f'the file holds {root.kind}', root.where, 'keys with values at the '
                         'left margin, such as joint_limits:')
        return root

    def _take(self, event: Any) -> None:
        where = Location(self._file, event.start_mark.line + 1, event.start_mark.column + 1)
        if isinstance(event, yaml.DocumentStartEvent):
            self._documents += 1
            if self._documents > 1:
                self._refuse('a second document begins here', where,
                             remedy="remove the line '---', or give this part a file of its own")
        elif isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
            self._begin(event, where)
        elif isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
            self._end()
        elif isinstance(event, yaml.ScalarEvent):
            node = YamlNode(self._scalar(event, where), where, text=event.value)
            self._add(node, event.anchor)
        elif isinstance(event, yaml.AliasEvent):
            self._add(self._alias(event.anchor, where), None)

    def _begin(self, event: Any, where: Location) -> None:
        is_mapping = isinstance(event, yaml.MappingStartEvent)
        standard = 'tag:yaml.org,2002:' + ('map' if is_mapping else 'seq')
        if event.tag not in (None, '!', standard):
            self._refuse(f"the tag '{event.tag}' is not allowed in a settings file", where)
        if len(self._open) >= DEEPEST_NESTING:
            self._refuse(f'nested more than {DEEPEST_NESTING} deep', where)
        if event.anchor:
            self._anchors[event.anchor] = None
        self._open.append(_Collection(is_mapping, event.anchor, where))

    def _end(self) -> None:
        done = self._open.pop()
        if done.is_mapping:
            node = YamlNode({}, done.where).with_value({**done.merged, **done.entries})
        else:
            node = YamlNode(tuple(done.items), done.where,
                            size=1 + sum(item.size for item in done.items))
        self._add(node, done.anchor)

    def _scalar(self, event: Any, where: Location) -> Scalar:
        try:
            if event.tag is not None:
                return read_tagged_scalar(event.tag, event.value)
            return read_plain_scalar(event.value) if event.implicit[0] else str(event.value)
        except ScalarError as error:
            self._refuse(str(error), where)

    def _alias(self, name: str | None, where: Location) -> YamlNode:
        if name is None or name not in self._anchors:
            self._refuse(f"'*{name}' has no anchor '&{name}' above it", where,
                         remedy=nearest(name or '', tuple(self._anchors)))
        node = self._anchors[name]
        if node is None:
            self._refuse(f"'*{name}' is inside its own value", where)
        return node

    def _add(self, node: YamlNode, anchor: str | None) -> None:
        if node.size > MOST_VALUES:
            self._refuse(f'more than {MOST_VALUES} values, with all aliases expanded', node.where,
                         remedy='such a file is meant to exhaust the memory of its reader')
        if anchor:
            self._anchors[anchor] = node
        if not self._open:
            self._root = node
        elif not self._open[-1].is_mapping:
            self._open[-1].items.append(node)
        else:
            self._add_to_mapping(self._open[-1], node)

    def _add_to_mapping(self, mapping: _Collection, node: YamlNode) -> None:
        if mapping.key is None:
            if isinstance(node.value, (tuple, dict)):
                self._refuse(f'a key is {node.kind}', node.where, 'a word')
            mapping.key = node
            return
        key, mapping.key = mapping.key, None
        if key.text == _MERGE_KEY:
            self._merge(mapping, node)
            return
        entry = YamlNode(node.value, node.where, key.where, node.text, node.size)
        known = mapping.entries.get(key.text)
        if known is not None:
            entry = self._twice(key, known, entry)
        mapping.entries[key.text] = entry

    def _twice(self, key: YamlNode, first: YamlNode, second: YamlNode) -> YamlNode:
        """Return what counts where a key is defined twice."""
        what = f"key '{key.text}' is defined twice, first in line {first.place.line}"
        both = self._merges and first.is_mapping and second.is_mapping
        remedy = ('make one of them; both count, as in ROS 2' if both else
                  'remove one of them; a reader would silently drop the first')
        if self._problems is None:
            self._refuse(what, key.where, remedy=remedy)
        self._problems.append(ignored(Problem(what, key.where, remedy=remedy)))
        return merge_nodes(first, second)[0] if both else second

    def _merge(self, mapping: _Collection, node: YamlNode) -> None:
        for source in (node.items or (node,)):
            if not source.is_mapping:
                self._refuse(f"'<<' merges blocks of keys, this is {source.kind}", source.where)
            mapping.merged = {**source.entries, **mapping.merged}

    def _refuse(self, what: str, where: Location, allowed: str = '', remedy: str = '') -> NoReturn:
        raise ConfigError(Problem(what, where, allowed, remedy))
