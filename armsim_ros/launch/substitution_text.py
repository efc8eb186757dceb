# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parses texts with ``$(name argument ...)``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from armsim_ros.errors import nearest
from armsim_ros.launch.api import paths, programs, substitutions
from armsim_ros.launch.api.context import Substitution
from armsim_ros.launch.api.utilities import TextSubstitution
from armsim_ros.launch.failures import LaunchError

Argument = list[Substitution]


def _env(words: Sequence[Argument]) -> Substitution:
    return substitutions.EnvironmentVariable(
        words[0], default_value=_joined(words[1:]) if len(words) > 1 else None)


def _optional_env(words: Sequence[Argument]) -> Substitution:
    return substitutions.EnvironmentVariable(words[0], default_value=_joined(words[1:]))


def _var(words: Sequence[Argument]) -> Substitution:
    return substitutions.LaunchConfiguration(
        words[0], default=_joined(words[1:]) if len(words) > 1 else None)


def _command(words: Sequence[Argument]) -> Substitution:
    handling = words[-1] if len(words) > 1 else None
    if handling is not None and _plain(handling) in ('warn', 'ignore', 'fail', 'capture'):
        return programs.Command(_joined(words[:-1]), on_stderr=_plain(handling))
    return programs.Command(_joined(words))


#: Name -> function that makes the substitution from its arguments.
KINDS: dict[str, Callable[[Sequence[Argument]], Substitution]] = {
    'var': _var,
    'arg': _var,
    'env': _env,
    'optenv': _optional_env,
    'find-pkg-share': lambda words: paths.FindPackageShare(words[0]),
    'find': lambda words: paths.FindPackageShare(words[0]),
    'find-pkg-prefix': lambda words: paths.FindPackagePrefix(words[0]),
    'find-pkg': lambda words: paths.FindPackagePrefix(words[0]),
    'find-exec': lambda words: programs.FindExecutable(name=words[0]),
    'exec-in-pkg': lambda words: paths.ExecutableInPackage(words[0], words[1]),
    'dirname': lambda words: paths.ThisLaunchFileDir(),
    'filename': lambda words: paths.ThisLaunchFile(),
    'log-dir': lambda words: paths.LaunchLogDir(),
    'launch_log_dir': lambda words: paths.LaunchLogDir(),
    'eval': lambda words: programs.PythonExpression(_joined(words)),
    'command': _command,
    'anon': lambda words: substitutions.AnonName(words[0]),
    'not': lambda words: substitutions.NotSubstitution(words[0]),
    'and': lambda words: substitutions.AndSubstitution(*words),
    'or': lambda words: substitutions.OrSubstitution(*words),
    'any': lambda words: substitutions.AnySubstitution(*words),
    'all': lambda words: substitutions.AllSubstitution(*words),
    'equals': lambda words: substitutions.EqualsSubstitution(words[0], words[1]),
    'not-equals': lambda words: substitutions.NotEqualsSubstitution(words[0], words[1]),
    'file-content': lambda words: paths.FileContent(words[0]),
    'if': lambda words: substitutions.IfElseSubstitution(
        words[0], words[1], words[2] if len(words) > 2 else ''),
    'for-var': lambda words: substitutions.ForEachVar(
        _plain(words[0]), words[1] if len(words) > 1 else None),
    'index': lambda words: substitutions.ForLoopIndex(_plain(words[0])),
    'param': lambda words: paths.Parameter(words[0]),
    'local': lambda words: substitutions.LocalSubstitution(_plain(words[0])),
}


def parse_substitution(text: str, more: dict[str, Any] | None = None) -> list[Substitution]:
    """
    Return a text with ``$(...)`` in it as substitutions.

    :param more: name -> substitution class of the user's.
    :raises LaunchError: for a name that is not known, or a bracket that is not closed.
    """
    found, rest = _sequence(text, 0, more or {}, '')
    assert rest == len(text)
    return found


def _sequence(text: str, start: int, more: dict[str, Any], ends: str
              ) -> tuple[list[Substitution], int]:
    """Read until an end sign; return the parts and the place of the end."""
    parts: list[Substitution] = []
    letters: list[str] = []
    depth = 0
    position = start
    while position < len(text):
        sign = text[position]
        if sign == '\\' and text[position + 1:position + 2] in {'$', '\\'}:
            letters.append(text[position + 1])
            position += 2
            continue
        if text.startswith('$(', position):
            if letters:
                parts.append(TextSubstitution(text=''.join(letters)))
                letters = []
            substitution, position = _substitution(text, position + 2, more)
            parts.append(substitution)
            continue
        if ends and depth == 0 and sign in ends:
            break
        if ends:
            depth += (sign == '(') - (sign == ')')
        letters.append(sign)
        position += 1
    if letters:
        parts.append(TextSubstitution(text=''.join(letters)))
    return parts, position


def _substitution(text: str, start: int, more: dict[str, Any]) -> tuple[Substitution, int]:
    """Read what follows ``$(``; return it and the place after its bracket."""
    position = start
    while position < len(text) and (text[position].isalnum() or text[position] in '-_'):
        position += 1
    name = text[start:position]
    words: list[Argument] = []
    while True:
        while position < len(text) and text[position].isspace():
            position += 1
        if position >= len(text):
            raise LaunchError(f"'$({name}' has no closing bracket")
        if text[position] == ')':
            position += 1
            break
        if name == 'eval' and text[position] not in '\'"':
            word, position = _sequence(text, position, more, ')')
        elif text[position] in '\'"':
            quote = text[position]
            word, position = _quoted(text, position + 1, quote, more)
        else:
            word, position = _sequence(text, position, more, ') \t\r\n')
        words.append(word)
    return _make(name, words, more), position


def _quoted(text: str, start: int, quote: str, more: dict[str, Any]
            ) -> tuple[list[Substitution], int]:
    parts: list[Substitution] = []
    letters: list[str] = []
    position = start
    while position < len(text) and text[position] != quote:
        if text[position] == '\\' and position + 1 < len(text):
            letters.append(text[position + 1])
            position += 2
        elif text.startswith('$(', position):
            if letters:
                parts.append(TextSubstitution(text=''.join(letters)))
                letters = []
            substitution, position = _substitution(text, position + 2, more)
            parts.append(substitution)
        else:
            letters.append(text[position])
            position += 1
    if position >= len(text):
        raise LaunchError(f"a quote is not closed in '{text}'")
    if letters or not parts:
        parts.append(TextSubstitution(text=''.join(letters)))
    return parts, position + 1


def _make(name: str, words: list[Argument], more: dict[str, Any]) -> Substitution:
    if name in more:
        kind, kwargs = more[name].parse(words)
        made: Substitution = kind(**kwargs)
        return made
    make = KINDS.get(name)
    if make is None:
        hint = nearest(name, tuple(KINDS)) or f"known: {', '.join(KINDS)}"
        raise LaunchError(f"substitution '$({name})' is not known; {hint}")
    try:
        return make(words)
    except IndexError:
        raise LaunchError(f"'$({name})' needs more words") from None


def _joined(words: Sequence[Argument]) -> Argument:
    joined: Argument = []
    for word in words:
        if joined:
            joined.append(TextSubstitution(text=' '))
        joined += word
    return joined or [TextSubstitution(text='')]


def _plain(word: Argument) -> str:
    return ''.join(part.text for part in word if isinstance(part, TextSubstitution))
