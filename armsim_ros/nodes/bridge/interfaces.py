# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The interface types that are installed, by their names."""

from __future__ import annotations

from enum import IntEnum
from functools import cache
from importlib import import_module
from typing import Any

from ament_index_python.resources import get_resource, get_resources

from armsim_ros.errors import ArmsimError, nearest


class Level(IntEnum):
    """Which status messages a client gets: those of its level and graver ones."""

    NONE = 0
    ERROR = 1
    WARNING = 2
    INFO = 3


class RefusalError(ArmsimError):
    """
    A request is not carried out; the text is for the client.

    :param level: a warning where nothing was lost.
    """

    def __init__(self, text: str, level: Level = Level.ERROR) -> None:
        super().__init__(text)
        self.level = level


#: Group -> what it is called in messages.
GROUPS = {'msg': 'message', 'srv': 'service', 'action': 'action'}
#: Parts of an action that have endpoints of their own.
_ACTION_PARTS = {
    'msg': {'_FeedbackMessage': 'FeedbackMessage'},
    'srv': {'_SendGoal': 'SendGoalService', '_GetResult': 'GetResultService'}}


def full_name(name: str, group: str) -> str:
    """Return ``pkg/group/Type`` of a name in two or three parts; others unchanged."""
    parts = name.split('/')
    return f'{parts[0]}/{group}/{parts[1]}' if len(parts) == 2 else name


@cache
def installed() -> dict[str, tuple[str, ...]]:
    """Return package -> its types, such as ``msg/JointState``, of the ament index."""
    found = {}
    for package in get_resources('rosidl_interfaces'):
        content, _ = get_resource('rosidl_interfaces', package)
        names = {line.rpartition('.')[0] for line in content.split()}
        found[package] = tuple(sorted(name for name in names if name.count('/') == 1))
    return found


def load(name: str, group: str) -> type[Any]:
    """
    Return the class of a type; only modules of installed interface packages are imported.

    :param name: in two or three parts; also ``pkg/action/X_FeedbackMessage``.
    :param group: msg, srv or action.
    :raises RefusalError: there is no such type; names the nearest.
    """
    return _load(full_name(name, group), group)


@cache
def _load(name: str, group: str) -> type[Any]:
    package, _, rest = name.partition('/')
    types = installed().get(package, ())
    if rest in types and rest.startswith(f'{group}/'):
        found = getattr(import_module(f'{package}.{group}'), rest.rpartition('/')[2], None)
        if isinstance(found, type):
            return found
    for ending, attribute in _ACTION_PARTS.get(group, {}).items():
        action = rest.removesuffix(ending)
        if rest.endswith(ending) and action in types and action.startswith('action/'):
            cls = getattr(import_module(f'{package}.action'), action.rpartition('/')[2])
            return getattr(cls.Impl, attribute)  # type: ignore[no-any-return] # by its name
    raise RefusalError(_unknown(name, group))


def _unknown(name: str, group: str) -> str:
    package = name.partition('/')[0]
    types = installed().get(package)
    shown = name[:200]
    if types is None:
        known = tuple(sorted(installed()))
        hint = nearest(package, known)
        return (f'no {GROUPS[group]} type {shown}{"; " + hint if hint else ""}; '
                f'installed packages: {", ".join(known)}')
    of_group = tuple(f'{package}/{entry}' for entry in types if entry.startswith(f'{group}/'))
    hint = nearest(name, of_group) or f'{package} has {", ".join(of_group) or "none"}'
    return f'no {GROUPS[group]} type {shown}; {hint}'
