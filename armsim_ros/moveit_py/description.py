# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of a script's node, and the robot that they describe."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from armsim_ros.cli.arguments import parse_arguments
from armsim_ros.cli.node_arguments import flattened, NodeArguments, read_node_arguments
from armsim_ros.cli.settings import cell_of
from armsim_ros.model.cell import Cell
from armsim_ros.moveit_py.utils import warn_unused
from armsim_ros.nodes.upstream.robot_package import (
    described_package,
    PREFIX,
    SEMANTIC,
    URDF,
    wait_for_descriptions,
)

#: How long the topics with the descriptions are waited for [s], as in MoveIt.
DESCRIPTION_TIMEOUT = 10.0
OPTIONS = 'planning_scene_monitor_options'
_USED_OPTIONS = ('name', 'robot_description', 'wait_for_initial_state_timeout')


def node_arguments(
    name: str, namespace: str, files: Sequence[str], config: Mapping[str, Any] | None,
    remappings: Mapping[str, str] | None
) -> NodeArguments:
    """
    Return the parameters of a script's node.

    :param files: parameter files; a later one wins.
    :param config: parameters, nested or with dots in their names, which win over all files.
    :raises UsageError: a file is not there or no YAML.
    """
    words = ['-r', f'__ns:={namespace or "/"}']
    for file in files:
        words += ['--params-file', file]
    found = read_node_arguments(words, name)
    found.values.update(flattened(config or {}))
    found.remappings += [f'{source}:={target}' for source, target in (remappings or {}).items()]
    warn_unused(found.values, f'{OPTIONS}.', _USED_OPTIONS)
    own = str(found.values.get(f'{OPTIONS}.robot_description') or URDF)
    if own != URDF:
        for key in list(found.values):
            if key == own or key.startswith((f'{own}_', f'{own}.')):
                found.values[URDF + key.removeprefix(own)] = found.values.pop(key)
    return found


def described_cell(arguments: NodeArguments) -> tuple[Cell, list[str]]:
    """
    Return the robot that parameters describe, or topics where parameters do not.

    :returns: the robot, and what a user should know of its description.
    :raises RuntimeError: a description is neither here nor there.
    :raises ConfigError: a description is wrong.
    """
    missing = [name for name in (URDF, SEMANTIC) if not arguments.values.get(name)]
    if missing:
        arguments.values.update(wait_for_descriptions(
            arguments, missing, missing, timeout=DESCRIPTION_TIMEOUT))
    missing = [name for name in (URDF, SEMANTIC) if not arguments.values.get(name)]
    if missing:
        files = ', '.join(map(str, arguments.files)) or 'none given'
        raise RuntimeError(
            f"no {' and no '.join(missing)} for node '{arguments.name}': not among the parameters "
            f'(files: {files}; config_dict), and not on the topic of that name within '
            f'{DESCRIPTION_TIMEOUT:g} s; pass config_dict=MoveItConfigsBuilder(...)'
            '.to_moveit_configs().to_dict(), or start the script from a launch file')
    with TemporaryDirectory(prefix=PREFIX) as folder:
        return cell_of(parse_arguments(described_package(arguments, Path(folder)), xacro=True))
