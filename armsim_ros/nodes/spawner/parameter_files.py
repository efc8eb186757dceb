# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the spawner has to know of parameter files: whether they name a controller, its type."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from armsim_ros.config.yaml.node import ROS2_KEY, YamlNode
from armsim_ros.config.yaml.source import read_yaml_file
from armsim_ros.errors import ConfigError, Problem


def controller_type(name: str, namespace: str, files: Sequence[str]) -> str:
    """
    Return the type that parameter files give to a controller, '' where they give none.

    :param namespace: of the manager, such as ``/sunday``; ``/`` is none.
    :raises ConfigError: a file cannot be read; or it has the controller under its bare name,
        which ROS 2 matches only for a manager without a namespace.
    """
    found = ''
    for file in files:
        root = read_yaml_file(Path(file))
        for keys, node in _blocks(root, ()):
            kind = _type_in(keys, node, name, namespace)
            found = kind or found
    return found


def _blocks(node: YamlNode, keys: tuple[str, ...]) -> list[tuple[tuple[str, ...], YamlNode]]:
    """Return (node name's parts, parameters) of every block, ROS 1 blocks as they stand."""
    if ROS2_KEY in node.entries:
        return [(keys, node.entries[ROS2_KEY])]
    found = []
    for key, inner in node.entries.items():
        parts = (*keys, *(part for part in key.split('/') if part))
        if inner.is_mapping:
            found += [(parts, inner), *_blocks(inner, parts)]
    return found


def _type_in(keys: tuple[str, ...], node: YamlNode, name: str, namespace: str) -> str:
    if keys and keys[-1] == name and ROS2_KEY in node.entries:
        home = tuple(part for part in namespace.split('/') if part)
        if home and keys == (name,):
            raise ConfigError(
                Problem(
                    f"'{name}' would match only a controller without a namespace; this one is "
                    f'{namespace}/{name}',
                    node.where,
                    f'{namespace}/{name}, /**/{name}, or the block below /**',
                )
            )
        return ''
    if keys and keys[-1] in ('controller_manager', '**'):
        nested = node.get(name)
        kind = nested.get('type') if nested is not None else node.get(f'{name}.type')
        return kind.text if kind is not None else ''
    if keys and keys[-1] == name:
        kind = node.get('type')
        return kind.text if kind is not None and not kind.is_mapping else ''
    return ''
