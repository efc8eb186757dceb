# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The commands of a CMakeLists.txt, and which of them belong to a block."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
import re
from typing import NamedTuple

_TOKEN = re.compile(
    r'#\[\[.*?\]\]|#[^\n]*|"(?P<quoted>(?:\\.|[^"\\])*)"|(?P<paren>[()])|(?P<word>[^\s()#"]+)',
    re.DOTALL)
#: Command that begins a block -> the command that ends it.
BLOCKS = {'if': 'endif', 'foreach': 'endforeach', 'while': 'endwhile',
           'function': 'endfunction', 'macro': 'endmacro'}


class CMakeWord(NamedTuple):
    """A word of a command; a quoted word is not split at semicolons."""

    text: str
    is_quoted: bool = False


class CMakeCommand(NamedTuple):
    """A command, its name in lower case."""

    name: str
    words: tuple[CMakeWord, ...]


def read_commands(file: Path) -> list[CMakeCommand]:
    """Return the commands of a file, none where it cannot be read."""
    try:
        return _parse(file.read_text(encoding='utf-8', errors='replace'))
    except OSError:
        return []


def _parse(text: str) -> list[CMakeCommand]:
    commands: list[CMakeCommand] = []
    name, words, depth = '', list[CMakeWord](), 0
    for match in _TOKEN.finditer(text):
        token = match['paren'] or match['word']
        if match['quoted'] is not None:
            if depth:
                words.append(CMakeWord(re.sub(r'\\(["$;@])', r'\1', match['quoted']), True))
        elif token is None:
            continue
        elif not depth and token != '(':
            name = token
        elif token == '(':
            depth += 1
            words = [*words, CMakeWord(token, True)] if depth > 1 else []
        elif token == ')':
            depth -= 1
            if depth:
                words.append(CMakeWord(token, True))
            else:
                commands.append(CMakeCommand(name.lower(), tuple(words)))
        else:
            words.append(CMakeWord(token))
    return commands


def end_of(commands: Sequence[CMakeCommand], start: int) -> int:
    """Return the position of the command that ends a block."""
    depth = 0
    for position in range(start, len(commands)):
        name = commands[position].name
        depth += (name in BLOCKS) - (name in BLOCKS.values())
        if depth == 0:
            return position
    return len(commands)


def branches(first: CMakeCommand, body: Sequence[CMakeCommand]
              ) -> Iterator[tuple[tuple[CMakeWord, ...] | None, Sequence[CMakeCommand]]]:
    """Yield condition, None of an else, and commands of the branches of an if."""
    condition: tuple[CMakeWord, ...] | None = first.words
    start = depth = 0
    for position, command in enumerate(body):
        depth += (command.name in BLOCKS) - (command.name in BLOCKS.values())
        if depth == 0 and command.name in ('else', 'elseif'):
            yield condition, body[start:position]
            start = position + 1
            condition = command.words if command.name == 'elseif' else None
    yield condition, body[start:]
