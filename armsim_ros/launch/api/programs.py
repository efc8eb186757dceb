# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Substitutions that run programs or Python; the xacro command runs inside this process."""

from __future__ import annotations

from collections.abc import Iterable
import importlib
import math
import os
from pathlib import Path
import shlex
import shutil
import subprocess
import sys
from typing import Any

from armsim_ros.errors import ConfigError, Location
from armsim_ros.install_rules.xacro_run import as_xacro, XacroCommand
from armsim_ros.launch.api.context import (
    describe_text,
    LaunchContext,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    perform_text,
    SomeText,
    Substitution,
)
from armsim_ros.launch.failures import MissingPackageError, SubstitutionFailure
from armsim_ros.launch.lookup import check_not_missing, current_lookup
from armsim_ros.model.description.xacro_text import read_description


def run_xacro(command: XacroCommand, where: Location | None) -> str:
    """
    Return the robot description of a xacro file.

    :param where: the line of the launch file.
    :raises SubstitutionFailure: where it makes none; the text names the xacro file.
    :raises MissingPackageError: where it names a package that is nowhere.
    """
    lookup = current_lookup()
    file = Path(command.file)
    if not file.is_file():
        check_not_missing(file)
        raise SubstitutionFailure(f"xacro file '{command.file}' does not exist", where)
    try:
        return read_description(file, mappings=command.mappings,
                                packages=lookup.packages.beside(file))
    except ConfigError as error:
        text = str(error)
        package = missing_in(text)
        if package:
            raise MissingPackageError(package, text) from None
        raise SubstitutionFailure(text, where) from None


def missing_in(text: str) -> str:
    """Return the package that an error message of the lookup names, '' if there is none."""
    _, found, rest = text.partition("package '")
    name, end, _ = rest.partition("' is not found")
    return name if found and end and "'" not in name else ''


class FindExecutable(Substitution):
    """
    The path of a program.

    :param name: the program.
    """

    def __init__(self, *, name: SomeText) -> None:
        self._name = normalize_to_list_of_substitutions(name)

    def perform(self, context: LaunchContext) -> str:
        """Return its path; for xacro, which runs inside this process, its bare name."""
        name = perform_substitutions(context, self._name)
        found = find_program(name, context)
        if found is not None:
            return found
        if name in ('xacro', 'ros2', 'gz', 'ign') or name.startswith('python'):
            return sys.executable if name.startswith('python') else name
        if context.engine is not None and context.engine.is_dry:
            context.engine.tell_unknown(f'program {name} is not installed')
            return name
        raise SubstitutionFailure(f"program '{name}' is not installed (looked in PATH)")

    def describe(self) -> str:
        """Return a description for messages."""
        return f'FindExec({describe_text(self._name)})'


def find_program(name: str, context: LaunchContext) -> str | None:
    """Return the path of a program: in the launch's PATH, then in this Python's environment."""
    path = context.environment.get('PATH', os.defpath)
    return shutil.which(name, path=path) or shutil.which(name, path=str(Path(sys.prefix, 'bin')))


class Command(Substitution):
    """
    The output of a command; xacro runs inside this process.

    :param command: the command line.
    :param on_stderr: what to do where it prints an error: fail, ignore, warn, capture.
    """

    def __init__(self, command: SomeText, *, on_stderr: SomeText = 'fail') -> None:
        self._command = normalize_to_list_of_substitutions(command)
        self._on_stderr = on_stderr

    def perform(self, context: LaunchContext) -> str:
        """Return the command's output."""
        line = perform_substitutions(context, self._command)
        try:
            words = shlex.split(line)
        except ValueError as error:
            raise SubstitutionFailure(f"command '{_short(line)}': {error}") from None
        if not words:
            raise SubstitutionFailure('an empty command')
        requested = as_xacro(words)
        if requested is not None:
            return run_xacro(requested, self.where)
        try:
            done = subprocess.run(words, capture_output=True, text=True, check=False,
                                  env=context.environment)
        except OSError as error:
            raise SubstitutionFailure(
                f"command '{_short(line)}' cannot be started: {error.strerror}") from None
        if done.returncode != 0:
            raise SubstitutionFailure(f"command '{_short(line)}' failed with exit status "
                                      f'{done.returncode}: {_short(done.stderr.strip())}')
        handling = perform_text(context, self._on_stderr)
        if done.stderr and handling == 'fail':
            raise SubstitutionFailure(f"command '{_short(line)}' printed to standard error: "
                                      f'{_short(done.stderr.strip())}')
        if done.stderr and handling == 'warn' and context.engine is not None:
            context.engine.log('WARNING', f"'{_short(line)}' printed: {done.stderr.strip()}")
        return done.stdout + (done.stderr if handling == 'capture' else '')

    def describe(self) -> str:
        """Return a description for messages."""
        return f'Command({describe_text(self._command)})'


class PythonExpression(Substitution):
    """
    The value of a Python expression.

    :param expression: the expression.
    :param python_modules: whose names it may use; math always.
    """

    def __init__(self, expression: SomeText, python_modules: Iterable[SomeText] = ('math',)
                 ) -> None:
        self._expression = normalize_to_list_of_substitutions(expression)
        self._modules = list(python_modules)

    def perform(self, context: LaunchContext) -> str:
        """Evaluate it, with the user's rights, as launch does."""
        text = perform_substitutions(context, self._expression)
        names: dict[str, Any] = {}
        for module in self._modules:
            name = perform_text(context, module)
            loaded = math if name == 'math' else importlib.import_module(name)
            names[name] = loaded
            if name == 'math':
                names.update(vars(math))
        try:
            return str(eval(text, {}, names))
        except Exception as error:  # noqa: BLE001 - anything the user's expression raises
            raise SubstitutionFailure(
                f"expression '{_short(text)}': {type(error).__name__}: {error}") from None

    def describe(self) -> str:
        """Return a description for messages."""
        return f'PythonExpr({describe_text(self._expression)})'


def _short(text: str, most: int = 200) -> str:
    line = ' '.join(text.split())
    return line if len(line) <= most else line[:most] + '...'
