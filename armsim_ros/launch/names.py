# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The names under which launch files import the classes of ``armsim_ros.launch.api``.

They can be imported only inside :func:`importable`, and all but three of them only where no real
module has the name. Afterwards they are gone from ``sys.modules``, and what was there is back.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, spec_from_file_location
from pathlib import Path
import sys
from types import ModuleType
from typing import Any

from armsim_ros.launch.api.modules import module_of, Table, TABLES
from armsim_ros.launch.lookup import Lookup

#: Ours while a file is evaluated here, also where real ones are installed: the real index finds no
#: sources, and the real classes need the real event loop, which `ros2 launch` runs.
_ALWAYS_OURS = ('ament_index_python', 'launch', 'launch_ros')


class _Finder(MetaPathFinder, Loader):
    """Finds the modules of the table, and Python packages in the sources of ROS packages."""

    def __init__(self, lookup: Lookup, names: Sequence[str]) -> None:
        self._lookup, self._names = lookup, names
        self.made: list[str] = []

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> Any:
        top = fullname.partition('.')[0]
        if top in self._names:
            known = _content(fullname) is not None
            return ModuleSpec(fullname, self, is_package=True) if known else None
        return self._source_package(fullname) if top == fullname else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = ModuleType(spec.name)
        module.__path__ = []
        return module

    def exec_module(self, module: ModuleType) -> None:
        self.made.append(module.__name__)
        vars(module).update(_content(module.__name__) or {})
        for child in _children(module.__name__):
            # launch_ros.actions is there after 'import launch_ros' alone.
            setattr(module, child.rpartition('.')[2], import_module(child))

    def _source_package(self, name: str) -> Any:
        place = self._lookup.module(name)
        if place is None:
            return None
        self.made.append(name)
        if place.is_file():
            return spec_from_file_location(name, place)
        return spec_from_file_location(
            name, place / '__init__.py', submodule_search_locations=[str(place)])


@contextmanager
def importable(lookup: Lookup) -> Iterator[None]:
    """
    Make the modules of launch files importable.

    :param lookup: finds the packages that they name.
    """
    ours = [name for name in TABLES if name in _ALWAYS_OURS or not _is_real(name)]
    finder = _Finder(lookup, ours)
    hidden = {name: module for name, module in sys.modules.items()
              if name.partition('.')[0] in _ALWAYS_OURS}
    for name in hidden:
        del sys.modules[name]
    first = _First(finder, ours)
    before_path = list(sys.path)
    no_bytecode = sys.dont_write_bytecode
    # Nothing of the user's code is cached.
    sys.dont_write_bytecode = True
    sys.meta_path.insert(0, first)
    sys.meta_path.append(finder)
    try:
        yield
    finally:
        sys.meta_path.remove(first)
        sys.meta_path.remove(finder)
        for name in list(sys.modules):
            if name.partition('.')[0] in {made.partition('.')[0] for made in finder.made}:
                del sys.modules[name]
        sys.modules.update(hidden)
        sys.path[:] = before_path
        sys.dont_write_bytecode = no_bytecode


class _First(MetaPathFinder):
    """Finds ours before folders of their names, such as launch/ under the working folder."""

    def __init__(self, finder: _Finder, names: Sequence[str]) -> None:
        self._finder, self._names = finder, names

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> Any:
        if fullname.partition('.')[0] in self._names:
            return self._finder.find_spec(fullname, path, target)
        return None


def _is_real(name: str) -> bool:
    """Return whether a real module of this name can be imported."""
    try:
        spec = find_spec(name)
    except (ImportError, ValueError):
        return False
    if spec is None:
        return False
    # A folder without __init__.py beside the working folder is no package: launch/ of a package.
    return spec.origin is not None and not _is_alias(spec.origin)


def _is_alias(file: str) -> bool:
    """Return whether a module only names what is in the table: that of distributions/moveit."""
    try:
        text = Path(file).read_text(encoding='utf-8', errors='replace')
    except OSError:
        return False
    return 'from armsim_ros.launch.api.' in text


@cache
def _modules_of(top: str) -> Table:
    """Return the modules of a package of upstream, by name."""
    return TABLES[top]()


def _children(name: str) -> list[str]:
    depth = name.count('.') + 1
    found = {'.'.join(module.split('.')[:depth + 1])
             for module in _modules_of(name.partition('.')[0]) if module.startswith(f'{name}.')}
    return sorted(found)


def _content(name: str) -> dict[str, Any] | None:
    """
    Return the names in a module of upstream, None if there is no such module.

    A class has a module of its own too, such as actions.execute_process.
    """
    modules = _modules_of(name.partition('.')[0])
    if name in modules:
        return modules[name]
    parent, _, last = name.rpartition('.')
    for title, found in modules.get(parent, {}).items():
        if module_of(title) == last:
            return {title: found}
    return {} if _children(name) else None
