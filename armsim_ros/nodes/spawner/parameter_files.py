# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The entries of parameter files that the spawner reads for a controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from armsim_ros.config.yaml.node import YamlNode
from armsim_ros.config.yaml.node_parameters import (
    is_ros2_file,
    names_without_namespace,
    parameters_of_node,
)
from armsim_ros.config.yaml.source import read_yaml_file


@dataclass(frozen=True)
class FileEntries:
    """
    The entries of parameter files for a controller.

    :param files: those that have a block for it.
    :param type: '' where they give none.
    :param remarks: why a file does not count, in sentences.
    """

    files: tuple[str, ...] = ()
    type: str = ''
    fallback_controllers: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()


def entries_of(name: str, namespace: str, files: Sequence[str]) -> FileEntries:
    """
    Read the entries of parameter files for a controller; the first file that has a value wins.

    :param namespace: of the controller, such as ``/sunday``; ``/`` is none.
    :raises ConfigError: a file cannot be read.
    """
    used: list[str] = []
    remarks: list[str] = []
    kind: str = ''
    fallbacks: tuple[str, ...] = ()
    for file in dict.fromkeys(files):
        root = read_yaml_file(Path(file))
        block = parameters_of_node(root, name, namespace) if is_ros2_file(root) \
            else _ros1_block(root, name)
        if block is None:
            if names_without_namespace(root, name):
                remarks.append(
                    f"{file}: '{name}' is only a controller without a namespace; this one is "
                    f'{namespace}/{name}; allowed: {namespace}/{name}, /**/{name}')
            continue
        used.append(file)
        given = block.get('type')
        kind = kind or (given.text if given is not None and not given.is_mapping else '')
        listed = block.get('fallback_controllers')
        fallbacks = fallbacks or (tuple(item.text for item in listed.items)
                                  if listed is not None else ())
    return FileEntries(tuple(used), kind, fallbacks, tuple(remarks))


def _ros1_block(node: YamlNode, name: str) -> YamlNode | None:
    """Return the block of a controller in a file of ROS 1, at any depth."""
    for key, inner in node.entries.items():
        if not inner.is_mapping:
            continue
        if key.rpartition('/')[2] == name:
            return inner
        if (found := _ros1_block(inner, name)) is not None:
            return found
    return None
