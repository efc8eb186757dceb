# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Actions and substitutions that users' packages add to XML and YAML files."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from armsim_ros.launch.frontend.element import Element as Entity
from armsim_ros.launch.frontend.parser import Parser

__all__ = ['Entity', 'Parser', 'expose_action', 'expose_substitution']

_T = TypeVar('_T')


def expose_action(name: str) -> Callable[[_T], _T]:
    """Return a decorator that lets files use an action under a name."""
    return _into(Parser.actions, name)


def expose_substitution(name: str) -> Callable[[_T], _T]:
    """Return a decorator that lets files use a substitution under a name."""
    return _into(Parser.substitutions, name)


def _into(table: dict[str, Any], name: str) -> Callable[[_T], _T]:
    def keep(exposed: _T) -> _T:
        table[name] = exposed
        return exposed

    return keep
