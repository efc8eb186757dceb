# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The ``data_files`` of a setup.py, read without running it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
import glob
import os
from pathlib import Path
import posixpath
from typing import Any


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
    """
    The values of a setup.py.

    :param folder: in which it lies and runs.
    """

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
