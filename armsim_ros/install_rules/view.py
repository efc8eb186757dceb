# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The folder of a package's sources as its build would install it."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
import glob
import hashlib
import logging
import os
from pathlib import Path
import posixpath
import shutil
import tempfile
from typing import Any

from armsim_ros.errors import ResourceError
from armsim_ros.install_rules.cmake import cmake_targets, Source
from armsim_ros.install_rules.xacro_run import xacro_finding, XacroCommand

#: Path below the package's share folder -> the file or folder to link, or the text of the file.
Missing = dict[str, Path | str]


def cache_folder(name: str) -> Path:
    """Return a folder for what this package keeps: below ``XDG_CACHE_HOME`` or ``~/.cache``."""
    base = os.environ.get('XDG_CACHE_HOME') or os.path.expanduser('~/.cache')
    return Path(base, 'armsim_ros', name)


@lru_cache(None)
def install_targets(folder: Path, name: str) -> tuple[tuple[str, Source], ...]:
    """
    Return what the build of a package installs, as path below the prefix and its source.

    :param folder: the package's sources.
    :param name: the package's name.
    """
    return (*cmake_targets(folder, name), *data_file_targets(folder))


def installed_programs(folder: Path, name: str) -> dict[str, Path]:
    """Return name -> file of the programs that the install rules put into ``lib/NAME``."""
    place = f'lib/{name}'
    found: dict[str, Path] = {}
    for target, source in install_targets(folder, name):
        if isinstance(source, Path) and target == place and source.is_dir():
            found.update((file.name, file) for file in source.iterdir() if file.is_file())
        elif isinstance(source, Path) and os.path.dirname(target) == place and source.is_file():
            found[os.path.basename(target)] = source
    return found


def installed_view(folder: Path, name: str, *, around: Path, find: Callable[[str], Path]) -> Path:
    """
    Return the folder of a package as its build would install it.

    That is the folder itself, unless its install rules put something at a path where the sources
    have nothing, or make a file with xacro. Then it is a folder of links in the user's cache,
    named by its content.

    :param folder: the package's sources.
    :param name: the package's name.
    :param around: where the other packages of the workspace are.
    :param find: returns the folder of a package, for xacro.
    :raises ResourceError: the cache cannot be written.
    """
    missing = _missing(folder, name, find)
    if not missing:
        return folder
    cache = cache_folder('packages')
    try:
        cache.mkdir(parents=True, exist_ok=True)
        (cache / 'COLCON_IGNORE').touch()
        made = Path(tempfile.mkdtemp(prefix='new-', dir=cache))
        try:
            # Packages in this view find those of the workspace from there, too.
            (made / 'src').symlink_to(around)
            view = made / folder.name
            _open(view, folder)
            for path, source in sorted(missing.items()):
                _put(view, path, source)
            final = cache / _digest(made)
            if not final.exists():
                os.replace(made, final)
        finally:
            shutil.rmtree(made, ignore_errors=True)
    except OSError as error:
        raise ResourceError(
            f"package '{name}' has files that only its build makes; they cannot be kept in "
            f"'{cache}': {error.strerror}; set XDG_CACHE_HOME to a folder of yours, or build the "
            'package with colcon and source it') from None
    return final / folder.name


def _missing(folder: Path, name: str, find: Callable[[str], Path]) -> Missing:
    """Return what an installation has and the sources have not."""
    share = f'share/{name}'
    found: Missing = {}

    def add(path: str, source: Source) -> None:
        place = folder / path
        if isinstance(source, XacroCommand):
            if not place.exists():
                text = _xacro_text(source, find)
                if text is not None:
                    found[path] = text
        elif source.exists() and not place.exists() and path not in found:
            found[path] = source
        elif source.is_dir() and not (place.exists() and source.samefile(place)):
            for entry in source.iterdir():
                add(os.path.join(path, entry.name), entry)

    for target, source in install_targets(folder, name):
        if target == share or target.startswith(f'{share}/'):
            add(target[len(share):].lstrip('/'), source)
    return found


def _xacro_text(command: XacroCommand, find: Callable[[str], Path]) -> str | None:
    """Return what xacro makes; None, with a warning, where it fails."""
    try:
        with xacro_finding(find) as xacro:
            document = xacro.process_file(command.file, mappings=dict(command.mappings),
                                          verbosity=0)
    except Exception as error:  # noqa: BLE001 - any error of the expressions in the file
        logging.getLogger('armsim_ros').warning(
            "%s: the build makes '%s' of this file, but xacro fails: %s", command.file,
            command.output, ' '.join(str(error).split()))
        return None
    return str(document.toprettyxml(indent='  '))


def _put(view: Path, path: str, source: Path | str) -> None:
    """Put a link to a file or folder, or a text, into the view."""
    parts = Path(path).parts
    place = view
    for part in parts[:-1]:
        place = place / part
        if place.is_symlink():
            _open(place, place.resolve())
        else:
            place.mkdir(exist_ok=True)
    place = view / path
    if isinstance(source, str):
        place.write_text(source, encoding='utf-8')
    elif not place.exists():
        place.symlink_to(source)


def _open(place: Path, source: Path) -> None:
    """Make a folder of links to what another folder has, in place of a link to that."""
    place.unlink(missing_ok=True)
    place.mkdir()
    for entry in source.iterdir():
        (place / entry.name).symlink_to(entry)


def _digest(folder: Path) -> str:
    digest = hashlib.sha256()
    for path in sorted(_entries(folder)):
        content = os.readlink(path) if path.is_symlink() else path.read_text(encoding='utf-8')
        digest.update(f'{path.relative_to(folder)}\0{content}\0'.encode())
    return digest.hexdigest()[:16]


def _entries(folder: Path) -> Iterable[Path]:
    for entry in folder.iterdir():
        if entry.is_dir() and not entry.is_symlink():
            yield from _entries(entry)
        else:
            yield entry


class _UnknownError(Exception):
    """An expression that only running the file would answer."""


def data_file_targets(folder: Path) -> Iterator[tuple[str, Path]]:
    """
    Yield what setup.py installs, as path below the prefix and the file that it comes from.

    Understood are texts, lists, ``os.path.join``, ``glob``, f-strings, sums, and lists that are
    built with ``append``, ``extend`` and ``+=``; an entry with anything else is left out.
    """
    try:
        tree = ast.parse((folder / 'setup.py').read_text(encoding='utf-8', errors='replace'))
    except (OSError, SyntaxError, ValueError):
        return
    for entry in _Module(folder).data_files(tree):
        if not (isinstance(entry, tuple) and len(entry) == 2 and isinstance(entry[0], str)):
            continue
        for file in entry[1] if isinstance(entry[1], list) else ():
            if isinstance(file, str):
                target = posixpath.join(entry[0], posixpath.basename(file))
                yield posixpath.normpath(target).lstrip('/'), folder / file


class _Module:
    """The values of a setup.py, which runs in its folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._names: dict[str, Any] = {}

    def data_files(self, tree: ast.Module) -> list[Any]:
        """Return the entries of the call of ``setup``."""
        found: list[Any] = []
        for statement in tree.body:
            if isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name):
                self._keep(statement.targets[0].id, statement.value)
            elif isinstance(statement, ast.AugAssign) and isinstance(statement.target, ast.Name):
                self._grow(statement.target.id, statement.value, is_list=True)
            elif isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Call):
                call = statement.value
                target = call.func
                if isinstance(target, ast.Attribute) and isinstance(target.value, ast.Name) \
                        and target.attr in ('append', 'extend') and call.args:
                    self._grow(target.value.id, call.args[0], is_list=target.attr == 'extend')
                for keyword in call.keywords:
                    if keyword.arg == 'data_files':
                        found += self._list(keyword.value)
        return found

    def _keep(self, name: str, node: ast.expr) -> None:
        try:
            self._names[name] = self._value(node)
        except _UnknownError:
            self._names.pop(name, None)

    def _grow(self, name: str, node: ast.expr, *, is_list: bool) -> None:
        if isinstance(self._names.get(name), list):
            self._names[name] += self._list(node if is_list else ast.List([node], ast.Load()))

    def _list(self, node: ast.expr) -> list[Any]:
        """Return a list without the elements that are not understood."""
        try:
            found = self._value(node)
        except _UnknownError:
            return []
        return found if isinstance(found, list) else []

    def _value(self, node: ast.expr) -> Any:
        if isinstance(node, ast.Constant):
            return node.value
        if isinstance(node, ast.Name) and node.id in self._names:
            return self._names[node.id]
        if isinstance(node, ast.List):
            return list(self._elements(node.elts))
        if isinstance(node, ast.Tuple):
            return tuple(self._value(element) for element in node.elts)
        if isinstance(node, ast.JoinedStr):
            return ''.join(str(self._value(part.value if isinstance(part, ast.FormattedValue)
                                           else part)) for part in node.values)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            return self._sum(self._value(node.left), self._value(node.right))
        if isinstance(node, ast.Call):
            return self._call(node)
        raise _UnknownError

    def _elements(self, nodes: list[ast.expr]) -> Iterator[Any]:
        for node in nodes:
            try:
                if isinstance(node, ast.Starred):
                    yield from self._list(node.value)
                else:
                    yield self._value(node)
            except _UnknownError:
                continue

    @staticmethod
    def _sum(left: Any, right: Any) -> Any:
        if type(left) is not type(right) or not isinstance(left, (str, list)):
            raise _UnknownError
        return left + right

    def _call(self, node: ast.Call) -> Any:
        name = ast.unparse(node.func)
        words = [self._value(argument) for argument in node.args]
        if not words or not all(isinstance(word, str) for word in words):
            raise _UnknownError
        if name in ('os.path.join', 'path.join', 'join'):
            return posixpath.join(*words)
        if name in ('glob', 'glob.glob'):
            found = glob.glob(str(self._folder / words[0]), recursive=True)
            return [os.path.relpath(file, self._folder) for file in sorted(found)
                    if os.path.isfile(file)]
        raise _UnknownError
