# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Each key of the YAML files: used, used with another meaning, or not used here."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from armsim_ros.config.yaml.node import YamlNode
from armsim_ros.config.yaml.source import read_yaml_file
from armsim_ros.errors import ConfigError, Location, Problem, Severity

USED, CHANGED, UNUSED, WRONG = 'used', 'changed meaning', 'not used here', 'wrong'
STATES = (USED, CHANGED, UNUSED, WRONG)

_STATE_OF = {Severity.ERROR: WRONG, Severity.CHANGED: CHANGED, Severity.INFO: UNUSED}


@dataclass(frozen=True)
class KeyState:
    """
    A key with a value.

    :param path: the keys that lead to it, joined by dots.
    :param state: one of ``STATES``.
    """

    path: str
    value: str
    where: Location
    state: str


def key_table(files: Iterable[Path], problems: Iterable[Problem]) -> list[KeyState]:
    """
    Return every key of the files that can be read.

    :param problems: all that was found; their places determine the keys' states.
    """
    states = {problem.where: _STATE_OF[problem.severity] for problem in problems
              if problem.where is not None and problem.severity in _STATE_OF}
    table: list[KeyState] = []
    for file in files:
        try:
            root = read_yaml_file(file)
        except ConfigError:
            continue
        table += _leaves(root, (), USED, states)
    return table


def _leaves(node: YamlNode, path: tuple[str, ...], state: str,
            states: dict[Location, str]) -> Iterator[KeyState]:
    if node.key_where is not None:
        state = states.get(node.key_where, state)
    if node.entries:
        for key, inner in node.entries.items():
            yield from _leaves(inner, (*path, key), state, states)
        return
    if any(item.is_mapping for item in node.items):
        for number, item in enumerate(node.items):
            yield from _leaves(item, (*path[:-1], f'{path[-1]}[{number}]'), state, states)
        return
    inside = [states[item.where] for item in (node, *node.items) if item.where in states]
    text = f"[{', '.join(item.text for item in node.items)}]" if node.items else node.text
    yield KeyState('.'.join(path), text, node.place, inside[0] if inside else state)
