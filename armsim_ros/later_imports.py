# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Libraries imported without the parts that are not needed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
import sys
from types import ModuleType
from typing import Any


class _LaterName:
    """A name of a module that is imported when the name is called or something of it used."""

    def __init__(self, module: str, name: str) -> None:
        self._where = module, name

    def __getattr__(self, name: str) -> Any:
        if name.startswith('__'):
            raise AttributeError(name)
        return getattr(self._real(), name)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self._real()(*args, **kwargs)

    def _real(self) -> Any:
        module, name = self._where
        return getattr(import_module(module), name)


class _LaterModule(ModuleType):
    """A module whose names are looked up when they are used."""

    #: Whether it represents the real module only, and no import reads its attributes.
    imported = False

    def __getattr__(self, name: str) -> Any:
        if name.startswith('__'):
            raise AttributeError(name)
        if self.imported:
            return getattr(import_module(self.__name__), name)
        return _LaterName(self.__name__, name)


@contextmanager
def imported_later(*modules: str) -> Iterator[None]:
    """
    Let what is imported meanwhile have names of modules without the time that they take.

    The modules' names are free again afterwards: later imports get the real ones, and
    holders of a name reach the real module through it. What is imported already stays.

    :param modules: full names, packages before what is in them.
    """
    later = {name: _LaterModule(name) for name in modules if name not in sys.modules}
    for name, module in later.items():
        package, _, child = name.rpartition('.')
        if package in later:
            setattr(later[package], child, module)
    sys.modules.update(later)
    try:
        yield
    finally:
        for name, module in later.items():
            module.imported = True
            if sys.modules.get(name) is module:
                del sys.modules[name]
