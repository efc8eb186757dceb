# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Why a text is not YAML: from the parser's words and the line to what its author probably did."""

from __future__ import annotations

import re
from typing import Any

import yaml

from armsim_ros.errors import Location, Problem

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
