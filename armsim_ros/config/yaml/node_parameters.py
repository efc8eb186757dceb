# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters that a ROS 2 parameter file gives to a node, by rcl's rules for node names."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from armsim_ros.config.yaml.node import merge_nodes, ROS2_KEY, split_keys, YamlNode


def parameters_of_node(root: YamlNode, name: str, namespace: str) -> YamlNode | None:
    """
    Return the parameters of a node, nested; None where no key of the file names it.

    A key ``/ns/name`` or nested keys name it; ``*`` matches one part of a name and ``**`` for
    any number of them. What names the node wins over wildcards.

    :param namespace: such as ``/sunday``; ``/`` is none.
    """
    own = [part for part in namespace.split('/') if part] + [name]
    found = [(sum(part in ('*', '**') for part in path), block)
             for path, block in _blocks(root, ()) if block.is_mapping and _fits(path, own)]
    merged: YamlNode | None = None
    for _, block in sorted(found, key=lambda each: -each[0]):
        block = split_keys(block, '.')
        merged = block if merged is None else merge_nodes(merged, block)[0]
    return merged


def is_ros2_file(root: YamlNode) -> bool:
    """Return whether a file has the parameters of nodes, and is not in the layout of ROS 1."""
    return next(_blocks(root, ()), None) is not None


def names_without_namespace(root: YamlNode, name: str) -> bool:
    """Return whether a file has a node under its bare name, which fits no namespace."""
    block = root.get(name)
    return block is not None and block.is_mapping and ROS2_KEY in block.entries


def _blocks(node: YamlNode, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], YamlNode]]:
    for key, inner in node.entries.items():
        if key == ROS2_KEY:
            yield path, inner
        elif inner.is_mapping:
            yield from _blocks(inner, (*path, *(part for part in key.split('/') if part)))


def _fits(path: Sequence[str], own: Sequence[str]) -> bool:
    if not path:
        return not own
    if path[0] == '**':
        return any(_fits(path[1:], own[start:]) for start in range(len(own) + 1))
    return bool(own) and path[0] in ('*', own[0]) and _fits(path[1:], own[1:])
