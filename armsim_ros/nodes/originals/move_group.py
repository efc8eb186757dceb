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
from armsim_ros.nodes.originals.node_parameters import NodeArguments, read_node_arguments
from armsim_ros.nodes.originals.robot_package import PREFIX, RobotPackage

_URDF, _SRDF = 'robot_description', 'robot_description_semantic'


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run move_group for the robot that parameters or topics describe.

    :param argv: the words that the original would get.
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
    missing = [name for name in (_URDF, _SRDF) if not values.get(name)]
    if missing:
        from armsim_ros.nodes.originals.description_topic import wait_for_descriptions

        values.update(wait_for_descriptions(arguments, missing, missing))
    values.setdefault('moveit_manage_controllers', False)
    package = RobotPackage(folder, str(values[_URDF]), str(values[_SRDF]))
    package.add_move_group(values)
    words = [f'robot:={package.folder}', f'urdf:={package.urdf}']
    arguments.rest += [word for name in (_URDF, _SRDF) if values.get(f'publish_{name}') is True
                       for word in ('-p', f'publish_{name}:=true')]
    if values.get('armsim.packages_path'):
        words.append(f"packages_path:={values['armsim.packages_path']}")
    return [*words, *arguments.ros_args(with_name=arguments.namespace != '/')]
