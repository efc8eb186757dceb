# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What MoveIt's setup assistant left in ``.setup_assistant``: where URDF and SRDF lie."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from armsim_ros.config.yaml.node import YamlNode
from armsim_ros.config.yaml.source import read_yaml_file
from armsim_ros.errors import ConfigError, Location

FILE = '.setup_assistant'


@dataclass(frozen=True)
class SetupAssistant:
    """
    The entries of the file that are still used; empty where it has none.

    :param urdf_package: the package that holds the URDF.
    :param urdf_path: the URDF's path in it.
    :param xacro_args: arguments of the URDF.
    :param srdf_path: the SRDF's path in the package of the file.
    :param where: the place of the URDF's and the SRDF's entry.
    """

    urdf_package: str = ''
    urdf_path: str = ''
    xacro_args: Mapping[str, str] = field(default_factory=dict)
    srdf_path: str = ''
    where: Mapping[str, Location] = field(default_factory=dict)


def read_setup_assistant(package: Path) -> SetupAssistant:
    """Return what a package's ``.setup_assistant`` contains; empty where it cannot be read."""
    file = package / FILE
    if not file.is_file():
        return SetupAssistant()
    try:
        root = read_yaml_file(file, []).get('moveit_setup_assistant_config')
    except ConfigError:
        return SetupAssistant()
    urdf, srdf = _block(root, 'urdf'), _block(root, 'srdf')
    places = {kind: node.place for kind, node in (('urdf', urdf), ('srdf', srdf)) if node}
    return SetupAssistant(
        _text(urdf, 'package'), _text(urdf, 'relative_path'),
        split_arguments(_text(urdf, 'xacro_args')), _text(srdf, 'relative_path'), places)


def split_arguments(text: str) -> dict[str, str]:
    """Return the arguments of a ``name:=value name:=value`` text."""
    pairs = (word.partition(':=') for word in text.split())
    return {name: value for name, sign, value in pairs if sign and name}


def _block(root: YamlNode | None, key: str) -> YamlNode | None:
    if root is None:
        return None
    return root.get(key) or root.get(key.upper())


def _text(node: YamlNode | None, key: str) -> str:
    inner = node.get(key) if node is not None else None
    return '' if inner is None or inner.value is None else inner.text
