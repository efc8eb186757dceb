# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""servo_node by the command line of MoveIt's: robot and parameters come from a launch file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
import sys
from tempfile import TemporaryDirectory
from typing import Any

import yaml

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.errors import ArmsimError, USAGE_STATUS
from armsim_ros.nodes.upstream.node_parameters import NodeArguments, read_node_arguments
from armsim_ros.nodes.upstream.robot_package import described_package, PREFIX

_BLOCK = 'moveit_servo.'
#: Parameters beside the block.
_BESIDE = ('butterworth_filter_coeff', 'update_period', 'planning_group_name')
#: Upstream's defaults of what is the robot's own where servo is started with a robot of ours.
_DEFAULTS = {
    f'{_BLOCK}command_out_topic': '/panda_arm_controller/joint_trajectory',
    f'{_BLOCK}joint_topic': '/joint_states',
    f'{_BLOCK}monitored_planning_scene_topic': '/planning_scene',
}


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run servo_node for the robot that parameters or topics describe.

    :param argv: the words that the upstream program would get.
    :returns: the exit status of servo_node.
    """
    from armsim_ros.nodes.servo.main import main as stream

    with TemporaryDirectory(prefix=PREFIX) as folder:
        try:
            _, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
            arguments = read_node_arguments(ros_args, 'servo_node')
            words = servo_words(arguments, Path(folder))
        except ArmsimError as error:
            print(error, file=sys.stderr, flush=True)
            return USAGE_STATUS
        return stream(words)


def servo_words(arguments: NodeArguments, folder: Path) -> list[str]:
    """
    Return the words that start servo_node for a robot, whose files are written into a folder.

    :raises ConfigError: where a description is none.
    """
    words = described_package(arguments, folder)
    file = folder / 'servo_parameters.yaml'
    content = {'/**': {'ros__parameters': servo_parameters(arguments.values)}}
    file.write_text(yaml.safe_dump(content), encoding='utf-8')
    arguments.rest += ['--params-file', str(file)]
    return [*words, *arguments.ros_args(with_name=True)]


def servo_parameters(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return servo's own parameters of those that a launch file gives."""
    own = {name: value for name, value in values.items()
           if name.startswith(_BLOCK) or name in _BESIDE}
    return {**_DEFAULTS, **own}
