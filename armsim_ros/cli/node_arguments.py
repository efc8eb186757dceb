# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A node's ``--ros-args``, read before ROS is started."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
import re
from typing import Any

import yaml

from armsim_ros.cli.arguments import UsageError

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
    # rcl merges the blocks of each key, and rclcpp takes the keys in the order of their first use.
    blocks: dict[str, dict[str, Any]] = {}
    for file in found.files:
        for key, block in _blocks(_load(file), ''):
            if _fits(key, found):
                blocks.setdefault(key, {}).update(flattened(block))
    for values in blocks.values():
        found.values.update(values)
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
    except (yaml.YAMLError, ValueError) as error:
        raise UsageError(f"parameter file '{file}' is not YAML: {error}") from None


def _blocks(content: Any, path: str) -> Iterator[tuple[str, Any]]:
    if not isinstance(content, Mapping):
        return
    for key, value in content.items():
        if key == 'ros__parameters':
            yield path, value
        else:
            yield from _blocks(value, f'{path}/{key}' if path else str(key))


def _fits(key: str, node: NodeArguments) -> bool:
    """Return whether a block is of this node: by its name, alone or full, or by a wildcard."""
    bare = key.strip('/')
    pattern = re.escape(f'/{bare}').replace(r'/\*', r'(/\w+)').replace(r'(/\w+)\*', r'(/\w+)*')
    full_name = f'{node.namespace.rstrip("/")}/{node.name}'
    return bare == node.name or re.fullmatch(pattern, full_name) is not None


def flattened(block: Any, prefix: str = '') -> dict[str, Any]:
    """Return the values of nested blocks by their names with dots."""
    found: dict[str, Any] = {}
    for key, value in (block or {}).items():
        if isinstance(value, Mapping):
            found.update(flattened(value, f'{prefix}{key}.'))
        else:
            found[f'{prefix}{key}'] = value
    return found
