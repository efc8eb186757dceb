# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The install rules of a CMakeLists.txt, read by an interpreter of the commands around them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
import glob
import os
from pathlib import Path
import posixpath
import re

from armsim_ros.install_rules.cmake_text import (
    BLOCKS,
    branches,
    CMakeCommand,
    CMakeWord,
    end_of,
    read_commands,
)
from armsim_ros.install_rules.xacro_run import as_xacro, PROGRAMS, XacroCommand

#: Where a target comes from: a file or folder, or a run of xacro that makes it.
Source = Path | XacroCommand
#: Represents the build folder, which no source has.
BUILD = Path('/nonexistent/build')
#: A file with more is no longer read: a loop of functions that call each other.
MOST_COMMANDS = 20_000

_VARIABLE = re.compile(r'\$(ENV)?\{([^${}]*)\}')
_FALSE = frozenset({'', '0', 'OFF', 'NO', 'FALSE', 'N', 'IGNORE', 'NOTFOUND'})
_INSTALL_WORDS = frozenset({
    'DESTINATION', 'TYPE', 'RENAME', 'PERMISSIONS', 'FILE_PERMISSIONS', 'DIRECTORY_PERMISSIONS',
    'CONFIGURATIONS', 'COMPONENT', 'OPTIONAL', 'PATTERN', 'REGEX', 'FILES_MATCHING', 'EXCLUDE',
    'USE_SOURCE_PERMISSIONS', 'MESSAGE_NEVER', 'EXCLUDE_FROM_ALL'})
_COMMAND_WORDS = frozenset({
    'COMMAND', 'OUTPUT', 'DEPENDS', 'WORKING_DIRECTORY', 'COMMENT', 'VERBATIM', 'OUTPUT_FILE',
    'RESULT_VARIABLE', 'OUTPUT_VARIABLE', 'ERROR_VARIABLE', 'ALL', 'ARGS', 'MAIN_DEPENDENCY',
    'BYPRODUCTS', 'TARGET', 'PRE_BUILD', 'POST_BUILD', 'USES_TERMINAL', 'APPEND'})
#: Words of xacro's functions that a value follows, and those that none does.
_XACRO_ONE = frozenset({'OUTPUT', 'TARGET', 'DESTINATION'})
_XACRO_NONE = frozenset({'INSTALL', 'INORDER', 'LEGACY'})
_XACRO_WORDS = frozenset({'REMAP', 'DEPENDS', *_XACRO_ONE, *_XACRO_NONE})


@dataclass
class _Function:
    parameters: tuple[str, ...]
    body: Sequence[CMakeCommand] = field(default_factory=tuple)


def cmake_targets(folder: Path, name: str) -> Iterator[tuple[str, Source]]:
    """
    Yield what is installed, as path below the prefix and where it comes from.

    What cannot be read, such as the result of another program, is left out.

    :param folder: of the package.
    :param name: of the package.
    """
    file = folder / 'CMakeLists.txt'
    if not file.is_file():
        return
    run = _Run(folder, name)
    run.run(read_commands(file))
    yield from run.targets()


class _Run:
    """An evaluation of the CMakeLists.txt of a package: of its folder and its name."""

    def __init__(self, folder: Path, name: str) -> None:
        self._folder = folder
        self._variables = {
            **dict.fromkeys(('CMAKE_CURRENT_SOURCE_DIR', 'CMAKE_SOURCE_DIR', 'PROJECT_SOURCE_DIR',
                             'CMAKE_CURRENT_LIST_DIR'), str(folder)),
            **dict.fromkeys(('CMAKE_CURRENT_BINARY_DIR', 'CMAKE_BINARY_DIR',
                             'PROJECT_BINARY_DIR'), str(BUILD)),
            'PROJECT_NAME': name, 'CMAKE_PROJECT_NAME': name, 'CMAKE_INSTALL_PREFIX': '',
            'CMAKE_INSTALL_DATADIR': 'share', 'CMAKE_INSTALL_DATAROOTDIR': 'share',
            'CATKIN_PACKAGE_SHARE_DESTINATION': f'share/{name}',
            'CATKIN_PACKAGE_BIN_DESTINATION': f'lib/{name}'}
        self._functions: dict[str, _Function] = {}
        self._installed: list[tuple[str, Path]] = []
        self._made: dict[Path, XacroCommand] = {}
        self._budget = MOST_COMMANDS
        self._known: dict[str, Callable[[list[str]], None]] = {
            'project': self._project, 'set': self._set, 'list': self._list, 'file': self._file,
            'string': self._string, 'get_filename_component': self._filename,
            'install': self._install, 'include': self._include,
            'add_subdirectory': self._subdirectory,
            'add_custom_command': self._custom, 'add_custom_target': self._custom,
            'execute_process': self._custom, 'xacro_add_xacro_file': self._xacro_file,
            'xacro_add_files': self._xacro_files, 'xacro_install': self._xacro_install}

    def targets(self) -> Iterator[tuple[str, Source]]:
        """Yield target and source of all rules; a file that xacro makes by its command."""
        for target, source in self._installed:
            for file, command in self._made.items():
                if file.is_relative_to(source):
                    rest = file.relative_to(source).as_posix()
                    yield posixpath.normpath(posixpath.join(target, rest)), command
            yield target, source

    def run(self, commands: Sequence[CMakeCommand]) -> None:
        """Run commands in order."""
        position = 0
        while position < len(commands) and self._budget > 0:
            self._budget -= 1
            command = commands[position]
            if command.name in BLOCKS:
                end = end_of(commands, position)
                self._block(command, commands[position + 1:end])
                position = end + 1
                continue
            position += 1
            if command.name in self._functions:
                self._call(self._functions[command.name], self._values(command.words))
            elif command.name in self._known:
                self._known[command.name](self._values(command.words))

    def _block(self, command: CMakeCommand, body: Sequence[CMakeCommand]) -> None:
        words = self._values(command.words)
        if command.name in ('function', 'macro'):
            if words:
                self._functions[words[0].lower()] = _Function(tuple(words[1:]), body)
        elif command.name == 'foreach' and words:
            for value in self._items(words[1:]):
                self._variables[words[0]] = value
                self.run(body)
        elif command.name == 'if':
            for condition, branch in branches(command, body):
                if condition is None or self._holds(self._values(condition)):
                    self.run(branch)
                    return

    def _items(self, words: list[str]) -> list[str]:
        if words[:1] != ['IN']:
            return words
        found, is_list = [], False
        for word in words[1:]:
            if word in ('LISTS', 'ITEMS'):
                is_list = word == 'LISTS'
            else:
                found += _split(self._variables.get(word, '')) if is_list else [word]
        return found

    def _call(self, function: _Function, words: list[str]) -> None:
        before = dict(self._variables)
        self._variables.update(zip(function.parameters, words, strict=False))
        self._variables['ARGN'] = ';'.join(words[len(function.parameters):])
        self._variables['ARGV'] = ';'.join(words)
        self.run(function.body)
        for name in (*function.parameters, 'ARGN', 'ARGV'):
            self._variables[name] = before.get(name, '')

    # Values -------------------------------------------------------------------------------------

    def _values(self, words: Sequence[CMakeWord]) -> list[str]:
        found: list[str] = []
        for word in words:
            text = self._expand(word.text)
            found += [text] if word.is_quoted else _split(text)
        return found

    def _expand(self, text: str) -> str:
        for _ in range(10):  # ${a_${b}}
            new = _VARIABLE.sub(lambda match: os.environ.get(match[2], '') if match[1] else
                                self._variables.get(match[2], ''), text)
            if new == text:
                break
            text = new
        return text

    def _holds(self, words: list[str]) -> bool:
        """Return a condition's value, of what it knows; parentheses are taken from left."""
        words = [word for word in words if word not in '()']
        for operator, combined in (('OR', any), ('AND', all)):
            if operator in words:
                at = words.index(operator)
                return combined([self._holds(words[:at]), self._holds(words[at + 1:])])
        if words[:1] == ['NOT']:
            return not self._holds(words[1:])
        if len(words) == 1:
            literal = words[0] if words[0] in ('1', 'ON', 'TRUE') else ''
            value = self._variables.get(words[0], literal)
            return words[0].endswith('_FOUND') or value.upper() not in _FALSE
        if len(words) == 2 and words[0] in ('EXISTS', 'IS_DIRECTORY'):
            return self._path(words[1]).exists()
        if len(words) == 2 and words[0] == 'DEFINED':
            return words[1] in self._variables
        if len(words) == 3 and words[1] in ('STREQUAL', 'EQUAL'):
            return self._variables.get(words[0], words[0]) == words[2]
        if len(words) == 3 and words[1] == 'MATCHES':
            return self._matches(words[2], self._variables.get(words[0], words[0])) is not None
        return bool(words)

    def _matches(self, pattern: str, text: str) -> str | None:
        try:
            found = re.search(pattern, text)
        except re.error:
            return None
        if found is None:
            return None
        for number, group in enumerate((found[0], *found.groups())):
            self._variables[f'CMAKE_MATCH_{number}'] = group or ''
        return found[0]

    def _path(self, text: str, base: Path | None = None) -> Path:
        return Path(os.path.normpath((base or self._folder) / text))

    # Commands -----------------------------------------------------------------------------------

    def _project(self, words: list[str]) -> None:
        self._variables.update(PROJECT_NAME=words[0], CMAKE_PROJECT_NAME=words[0])

    def _set(self, words: list[str]) -> None:
        values = words[1:]
        for last in ('CACHE', 'PARENT_SCOPE'):
            if last in values:
                values = values[:values.index(last)]
        self._variables[words[0]] = ';'.join(values)

    def _list(self, words: list[str]) -> None:
        if words[:1] == ['APPEND']:
            old = _split(self._variables.get(words[1], ''))
            self._variables[words[1]] = ';'.join([*old, *words[2:]])

    def _file(self, words: list[str]) -> None:
        if not words or words[0] not in ('GLOB', 'GLOB_RECURSE'):
            return
        rest = [word for word in words[2:] if word != 'CONFIGURE_DEPENDS']
        base = None
        if rest[:1] == ['RELATIVE']:
            base, rest = rest[1], rest[2:]
        found: list[str] = []
        for pattern in rest:
            path = self._path(pattern)
            if words[0] == 'GLOB_RECURSE':
                path = path.parent / '**' / path.name
            found += sorted(glob.glob(str(path), recursive=True))
        self._variables[words[1]] = ';'.join(
            os.path.relpath(file, base) if base else file for file in found)

    def _string(self, words: list[str]) -> None:
        if words[:1] == ['REPLACE'] and len(words) > 4:
            self._variables[words[3]] = ''.join(words[4:]).replace(words[1], words[2])
        elif words[:2] == ['REGEX', 'MATCH'] and len(words) > 4:
            self._variables[words[3]] = self._matches(words[2], ''.join(words[4:])) or ''
        elif words[:2] == ['REGEX', 'REPLACE'] and len(words) > 5:
            try:
                text = re.sub(words[2], words[3].replace('\\\\', '\\'), ''.join(words[5:]))
            except re.error:
                return
            self._variables[words[4]] = text
        elif words[:1] in (['TOLOWER'], ['TOUPPER']) and len(words) == 3:
            self._variables[words[2]] = (words[1].lower() if words[0] == 'TOLOWER'
                                         else words[1].upper())

    def _filename(self, words: list[str]) -> None:
        if len(words) < 3:
            return
        path = Path(words[1])
        whole = {'DIRECTORY': path.parent, 'PATH': path.parent, 'NAME': path.name,
                 'NAME_WE': path.name.split('.')[0], 'NAME_WLE': path.stem, 'EXT': ''.join(
                     path.name.partition('.')[1:]), 'LAST_EXT': path.suffix}
        self._variables[words[0]] = str(whole.get(words[2], self._path(words[1])))

    def _subdirectory(self, words: list[str]) -> None:
        """Run the file of a folder; its paths are relative to that, its variables end with it."""
        folder = self._path(words[0]) if words else self._folder
        file = folder / 'CMakeLists.txt'
        if folder == self._folder or not file.is_file():
            return
        before = self._folder, self._variables
        self._folder = folder
        self._variables = {**self._variables, **dict.fromkeys(
            ('CMAKE_CURRENT_SOURCE_DIR', 'CMAKE_CURRENT_LIST_DIR'), str(folder))}
        self.run(read_commands(file))
        self._folder, self._variables = before

    def _include(self, words: list[str]) -> None:
        file = self._path(words[0]) if words else self._folder
        if file.is_file() and file.is_relative_to(self._folder):
            self.run(read_commands(file))

    def _install(self, words: list[str]) -> None:
        kind = words[0] if words else ''
        options = _keywords(words[1:], _INSTALL_WORDS)
        if kind not in ('DIRECTORY', 'FILES', 'PROGRAMS') or not options.get('DESTINATION'):
            return
        destination, rename = options['DESTINATION'][0], options.get('RENAME', [''])[0]
        for source in options['']:
            name = rename or Path(source).name
            target = destination if kind == 'DIRECTORY' and source.endswith('/') \
                else posixpath.join(destination, name)
            self._installed.append((posixpath.normpath(target).lstrip('/'), self._path(source)))

    def _custom(self, words: list[str]) -> None:
        """Keep what ``COMMAND ... xacro ...`` makes."""
        options = _keywords([word for word in words if word != 'COMMAND'], _COMMAND_WORDS)
        place = self._path(options.get('WORKING_DIRECTORY', [str(BUILD)])[0])
        for line in _command_lines(words):
            starts = [at for at, word in enumerate(line) if os.path.basename(word) in PROGRAMS]
            found = as_xacro(line[starts[-1]:]) if starts else None
            if found is None:
                continue
            output = found.output or next(iter(
                options.get('OUTPUT_FILE') or options.get('OUTPUT', [])), '')
            if output:
                base = place if found.output or options.get('OUTPUT_FILE') else BUILD
                self._make(found.file, found.mappings, self._path(output, base), place)

    def _xacro_file(self, words: list[str]) -> None:
        options = _xacro_options(words)
        if options['']:
            made = self._xacro(options[''][0], next(iter(options[''][1:]), ''), options)
            self._variables[options.get('OUTPUT', ['XACRO_OUTPUT_FILE'])[0]] = str(made)

    def _xacro_files(self, words: list[str]) -> None:
        options = _xacro_options(words)
        output = options.get('OUTPUT', [''])[0]
        made = [str(self._xacro(file, output, options)) for file in options['']]
        if 'INSTALL' in options:
            self._xacro_install(['-', *made, 'DESTINATION', *options.get('DESTINATION', [''])])

    def _xacro_install(self, words: list[str]) -> None:
        options = _xacro_options(words[1:])
        place = posixpath.join('share', self._variables['PROJECT_NAME'],
                               options.get('DESTINATION', [''])[0])
        self._install(['FILES', *options[''], 'DESTINATION', place])

    def _xacro(self, file: str, output: str, options: dict[str, list[str]]) -> Path:
        made = self._path(output or file.removesuffix('.xacro'), BUILD)
        mappings = dict(word.split(':=', 1) for word in options.get('REMAP', ()) if ':=' in word)
        self._make(file, mappings, made, self._folder)
        return made

    def _make(self, file: str, mappings: Mapping[str, str], made: Path, place: Path) -> None:
        given = self._path(file, place)
        self._made[made] = XacroCommand(
            str(given if given.is_file() else self._path(file)), mappings, made.name)


def _xacro_options(words: Sequence[str]) -> dict[str, list[str]]:
    return _keywords(words, _XACRO_WORDS, single=_XACRO_ONE, none=_XACRO_NONE)


def _keywords(words: Sequence[str], known: frozenset[str], *, single: frozenset[str] = frozenset(),
              none: frozenset[str] = frozenset()) -> dict[str, list[str]]:
    """
    Return keyword -> its words; '' -> those of no keyword.

    :param single: keywords that one word follows.
    :param none: keywords that no word follows.
    """
    found: dict[str, list[str]] = {'': []}
    current = ''
    for word in words:
        if word in known:
            found.setdefault(word, [])
            current = '' if word in none else word
        else:
            found[current].append(word)
            current = '' if current in single else current
    return found


def _command_lines(words: Sequence[str]) -> Iterator[list[str]]:
    """Yield the words of each ``COMMAND``."""
    line: list[str] | None = None
    for word in (*words, 'COMMAND'):
        if word in _COMMAND_WORDS and word != 'ARGS':
            if line:
                yield line
            line = [] if word == 'COMMAND' else None
        elif line is not None:
            line.append(word)


def _split(text: str) -> list[str]:
    return [part for part in text.split(';') if part]
