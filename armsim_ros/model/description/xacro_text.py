# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The text of a URDF or SRDF file, after xacro where it is a xacro file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
import re
from typing import Any
from xml.parsers import expat

from armsim_ros.errors import Location, ModelError, Problem, ResourceError
from armsim_ros.install_rules.xacro_run import xacro_finding
from armsim_ros.model.description.xml_tree import LARGEST_TEXT, parse_xml
from armsim_ros.packages import Packages
from armsim_ros.resources import as_packages, share_folder

_XACRO_MARK = re.compile(r'xmlns:xacro\s*=|<xacro:')


@dataclass(frozen=True)
class Description:
    """
    A robot description after xacro.

    :param arguments: name -> value of the arguments that it declares, those given with theirs.
    """

    text: str
    arguments: Mapping[str, str] = field(default_factory=dict)


class _Arguments(dict[str, str]):
    """The arguments of a run of xacro; remembers which of them the files declare or use."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.declared: dict[str, str] = {}

    def __contains__(self, name: object) -> bool:
        """Answer xacro, which asks so at each ``<xacro:arg>`` before it takes its default."""
        known = super().__contains__(name)
        if known:
            self.declared[str(name)] = super().__getitem__(str(name))
        return known

    def __getitem__(self, name: str) -> str:
        value = super().__getitem__(name)
        self.declared.setdefault(name, value)
        return value

    def __setitem__(self, name: str, value: str) -> None:
        super().__setitem__(name, value)
        self.declared[name] = value


def read_description(file: Path, *, mappings: Mapping[str, str] | None = None,
                     packages: Packages | Iterable[Path] = ()) -> str:
    """
    Return the text of a robot description.

    :param file: URDF or SRDF; xacro is run where the file has its ending or its namespace.
    :param mappings: xacro arguments.
    :param packages: where ``$(find pkg)`` looks.
    :raises ModelError: where the file cannot be read, or xacro cannot process it.
    """
    return describe(file, mappings=mappings, packages=packages).text


def describe(file: Path, *, mappings: Mapping[str, str] | None = None,
             packages: Packages | Iterable[Path] = ()) -> Description:
    """
    Return the text of a robot description, and the arguments that its xacro declares.

    The parameters are those of :func:`read_description`.

    :raises ModelError: as there.
    """
    text = read_text(file)
    if file.suffix != '.xacro' and not _XACRO_MARK.search(text):
        return Description(text)
    arguments = _Arguments(mappings or {})
    return Description(_run_xacro(file, arguments, as_packages(packages)), arguments.declared)


def declared_arguments(file: Path, *, mappings: Mapping[str, str] | None = None,
                       packages: Packages | Iterable[Path] = ()) -> dict[str, str]:
    """
    Return the arguments that a description's xacro declares, with their defaults.

    A xacro that lacks a required argument still reports those that it declares
    before it stops.
    """
    arguments = _Arguments(mappings or {})
    try:
        text = read_text(file)
        if file.suffix == '.xacro' or _XACRO_MARK.search(text):
            _run_xacro(file, arguments, as_packages(packages))
    except ModelError:
        pass
    return arguments.declared


def read_text(file: Path) -> str:
    """
    Return the text of an XML file.

    :raises ModelError: where the file cannot be read, is not UTF-8, or is larger than any such
        file is.
    """
    try:
        with file.open('rb') as stream:
            data = stream.read(LARGEST_TEXT + 1)
    except OSError as error:
        raise ModelError(Problem(f'cannot be read: {error.strerror}',
                                 Location(str(file)))) from None
    if len(data) > LARGEST_TEXT:
        raise ModelError(Problem(f'the file is larger than {LARGEST_TEXT >> 20} MiB',
                                 Location(str(file)), remedy='is this the right file?'))
    try:
        return data.decode('utf-8-sig')
    except UnicodeDecodeError as error:
        line = data.count(b'\n', 0, error.start) + 1
        raise ModelError(Problem('the text is not UTF-8', Location(str(file), line),
                                 remedy='save it as UTF-8')) from None


def source_line(source: str, name: str) -> int | None:
    """
    Return the line of a source text that introduces a name, None where several may.

    A text after xacro has other lines than its source; a name that occurs there once still
    leads to the right file.
    """
    hits = [number for number, line in enumerate(source.splitlines(), 1)
            if f'name="{name}"' in line or f"name='{name}'" in line]
    return hits[0] if len(hits) == 1 else None


def _run_xacro(file: Path, mappings: _Arguments, packages: Packages) -> str:
    with xacro_finding(lambda package: share_folder(package, packages)) as xacro:
        try:
            document = xacro.process_file(str(file), mappings=mappings, verbosity=0)
        except expat.ExpatError as error:
            culprit = _current_file(xacro, file)
            parse_xml(read_text(Path(culprit)), culprit)  # describes the same error in more detail
            raise ModelError(Problem(
                f'this is not XML: {expat.ErrorString(error.code)}',
                Location(culprit, error.lineno, error.offset + 1))) from None
        except Exception as error:  # noqa: BLE001 - any error of the expressions in the file
            raise ModelError(_complaint(xacro, error, file)) from None
        return str(document.toprettyxml(indent='  '))


def _complaint(module: Any, error: Exception, file: Path) -> Problem:
    cause = getattr(error, 'exc', None) or error
    if isinstance(cause, ResourceError):
        return Problem(str(cause), Location(_current_file(module, file)))
    text = ' '.join(str(error).split()) or type(error).__name__
    macros = [macro.body.getAttribute('name') for macro in reversed(module.macrostack or [])]
    if macros:
        text += f" (in macro '{macros[0]}')"
    missing = re.search(r"[Uu]ndefined substitution argument (\S+)|'([^']+)' is not defined"
                        r'|unknown macro name: (\S+)', text)
    culprit = _current_file(module, file)
    if missing is None:
        return Problem(f'xacro: {text}', Location(culprit))
    name = missing[1] or missing[2] or missing[3]
    remedy = f"define '{name}' with <xacro:arg> or <xacro:property>"
    if missing[1]:
        remedy = f"give {name}:=VALUE, or define '{name}' with <xacro:arg>"
    elif missing[3]:
        remedy = 'correct the name, or <xacro:include> the file that defines the macro'
    return Problem(f'xacro: {text}', Location(culprit, _only_line(Path(culprit), name)),
                   remedy=remedy)


def _only_line(file: Path, name: str) -> int | None:
    """Return the line of a file that has a name, None where several have it."""
    whole = re.compile(rf'(?<!\w){re.escape(name)}(?!\w)')
    hits = [number for number, line in enumerate(read_text(file).splitlines(), 1)
            if whole.search(line)]
    return hits[0] if len(hits) == 1 else None


def _current_file(module: Any, file: Path) -> str:
    """Return the file that xacro was reading; an included file rather than the first."""
    stack = [entry for entry in (module.filestack or []) if entry]
    return str(stack[-1]) if stack else str(file)
