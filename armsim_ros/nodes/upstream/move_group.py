# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""move_group by the command line of MoveIt's: the robot is in its parameters."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
import sys
from tempfile import TemporaryDirectory

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.errors import ArmsimError, USAGE_STATUS
from armsim_ros.nodes.upstream.node_parameters import NodeArguments, read_node_arguments
from armsim_ros.nodes.upstream.robot_package import (
    described_package,
    PREFIX,
    SEMANTIC,
    URDF,
)


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run move_group for the robot that parameters or topics describe.

    :param argv: the words that the upstream program would get.
    :returns: the exit status of move_group.
    """
    from armsim_ros.nodes.move_group.main import main as plan

    with TemporaryDirectory(prefix=PREFIX) as folder:
        try:
            _, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
            arguments = read_node_arguments(ros_args, 'move_group')
            words = move_group_words(arguments, Path(folder))
        except ArmsimError as error:
            print(error, file=sys.stderr, flush=True)
            return USAGE_STATUS
        return plan(words)


def move_group_words(arguments: NodeArguments, folder: Path) -> list[str]:
    """
    Return the words that start move_group for a robot, whose files are written into a folder.

    :raises ConfigError: where a description is none.
    """
    values = arguments.values
    values.setdefault('moveit_manage_controllers', False)
    words = described_package(arguments, folder)
    arguments.rest += [word for name in (URDF, SEMANTIC) if values.get(f'publish_{name}') is True
                       for word in ('-p', f'publish_{name}:=true')]
    return [*words, *arguments.ros_args(with_name=arguments.namespace != '/')]
