# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A node's ``--ros-args``, read before ROS is started."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from armsim_ros.cli.arguments import UsageError
from armsim_ros.config.yaml_node import ROS2_KEY

_FAST_LOADER = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
_NAMES = ('__node', '__name', '__ns')


@dataclass
class NodeArguments:
    """
    The arguments of a node.

    :param values: parameters by their names with dots; those in files too.
    :param files: parameter files, in order.
    :param remappings: the rules but those of name and namespace.
    """

    name: str
    namespace: str = '/'
    values: dict[str, Any] = field(default_factory=dict)
    files: list[Path] = field(default_factory=list)
    remappings: list[str] = field(default_factory=list)
    rest: list[str] = field(default_factory=list)

    def ros_args(self, *, with_name: bool = False) -> list[str]:
        """Return ``--ros-args`` with the remappings alone."""
        rules = list(self.remappings)
        if with_name:
            rules += [f'__node:={self.name}', f'__ns:={self.namespace}']
        words = [word for rule in rules for word in ('-r', rule)]
        return ['--ros-args', *words, *self.rest, '--']


def read_node_arguments(ros_args: Sequence[str], name: str) -> NodeArguments:
    """
    Read ``--ros-args``.

    :param name: of the node where nothing renames it.
    :raises UsageError: for a file that is not there or no YAML.
    """
    found = NodeArguments(name)
    single: dict[str, Any] = {}
    words = iter(word for word in ros_args if word not in ('--ros-args', '--'))
    for word in words:
        if word in ('-r', '--remap'):
            _remap(next(words, ''), found)
        elif word in ('-p', '--param'):
            key, _, value = next(words, '').partition(':=')
            single[key.rpartition(':')[2]] = yaml.safe_load(value)
        elif word == '--params-file':
            found.files.append(Path(next(words, '')))
        elif word.startswith(('--log-level', '--enable', '--disable', '--log-config-file', '-e',
                              '--enclave')):
            found.rest.append(word)
            if word in ('--log-level', '--log-config-file', '-e', '--enclave'):
                found.rest.append(next(words, ''))
        elif ':=' in word:
            _remap(word, found)
    exact: dict[str, Any] = {}
    for file in found.files:
        for path, block in _blocks(_load(file), ()):
            rank = _rank(path, found)
            if rank:
                (exact if rank > 1 else found.values).update(flattened(block))
    found.values.update(exact)
    found.values.update(single)
    return found


def _remap(rule: str, found: NodeArguments) -> None:
    source, _, target = rule.partition(':=')
    kind = source.rpartition(':')[2]
    if kind in ('__node', '__name'):
        found.name = target
    elif kind == '__ns':
        found.namespace = '/' + target.strip('/')
    elif rule:
        found.remappings.append(rule)


def _load(file: Path) -> Any:
    try:
        return yaml.load(file.read_text(encoding='utf-8'), _FAST_LOADER)
    except OSError as error:
        raise UsageError(f"parameter file '{file}' cannot be read: {error.strerror}") from None
    except yaml.YAMLError as error:
        raise UsageError(f"parameter file '{file}' is not YAML: {error}") from None


def _blocks(content: Any, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    if not isinstance(content, Mapping):
        return
    for key, value in content.items():
        if key == ROS2_KEY:
            yield path, value
        else:
            parts = tuple(part for part in str(key).split('/') if part)
            yield from _blocks(value, (*path, *parts))


def _rank(path: tuple[str, ...], node: NodeArguments) -> int:
    """Return 2 where a block is of this very node, 1 where a wildcard fits it, else 0."""
    own = (*(part for part in node.namespace.split('/') if part), node.name)
    if path == own or path == (node.name,):
        return 2
    if path in (('**',), ('*',)) or (path[-1:] in ((node.name,), ('**',)) and '**' in path):
        return 1
    return 0


def flattened(block: Any, prefix: str = '') -> dict[str, Any]:
    """Return the values of nested blocks by their names with dots."""
    found: dict[str, Any] = {}
    for key, value in (block or {}).items():
        if isinstance(value, Mapping):
            found.update(flattened(value, f'{prefix}{key}.'))
        else:
            found[f'{prefix}{key}'] = value
    return found
