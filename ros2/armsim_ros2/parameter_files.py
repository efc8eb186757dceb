# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameter files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from armsim_ros2.errors import CliError


def parameters_in(file: Path, node: str, wildcards: bool = True) -> dict[str, Any]:
    """
    Return a node's entries of a parameter file, by their dotted names.

    :param node: full name of the node.
    :param wildcards: whether entries of ``/**`` count.
    :raises CliError: the file does not exist or is not YAML.
    """
    if not file.is_file():
        raise CliError(f"Parameter file '{file}' does not exist")
    try:
        tree = yaml.safe_load(file.read_text(encoding='utf-8'))
    except yaml.YAMLError as error:
        raise CliError(f"Parameter file '{file}': {' '.join(str(error).split())}") from None
    names = [node, '/**', f'/**/{node.rpartition("/")[2]}'] if wildcards else [node]
    found: dict[str, Any] = {}

    def flatten(branch: dict[str, Any], prefix: str) -> None:
        for key, value in branch.items():
            if isinstance(value, dict):
                flatten(value, f'{prefix}{key}.')
            else:
                found[f'{prefix}{key}'] = value

    def collect(branch: Any, path: str) -> None:
        for key, value in branch.items() if isinstance(branch, dict) else ():
            if key != 'ros__parameters':
                collect(value, f'{path}/{str(key).strip("/")}')
            elif path in names and isinstance(value, dict):
                flatten(value, '')

    collect(tree, '')
    return found
