# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The move_group program: planning, kinematics, the planning scene, execution."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
import sys

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from armsim_ros.cli.arguments import parse_arguments, ProgramArguments
from armsim_ros.config.loading import load_robot_settings
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.model.loading import load_robot_model
from armsim_ros.nodes.move_group.assembly import MoveGroup

SWITCH_INTERVAL = 0.001


def main(argv: Sequence[str] | None = None) -> int:
    """
    Serve until the process is told to end.

    :param argv: the words after the program's name; those of this process where None.
    :returns: the exit status.
    :raises ConfigError: the robot's files are wrong.
    """
    arguments = parse_arguments(sys.argv[1:] if argv is None else argv)
    settings = settings_of(arguments)
    robot = load_robot_model(settings)
    sys.setswitchinterval(SWITCH_INTERVAL)
    rclpy.init(args=['armsim_ros', *arguments.ros_args])
    executor = SingleThreadedExecutor()
    node = Node(
        'move_group',
        allow_undeclared_parameters=True,
        automatically_declare_parameters_from_overrides=True,
        parameter_overrides=[Parameter('use_sim_time', value=arguments.use_sim_time)],
    )
    executor.add_node(node)
    move_group: MoveGroup | None = None
    try:
        move_group = MoveGroup(node, executor, settings, robot)
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        return 0
    finally:
        if move_group is not None:
            move_group.close()
        executor.shutdown(0.5)
        rclpy.try_shutdown()
    return 0


def settings_of(arguments: ProgramArguments) -> RobotSettings:
    """Return the settings that a command line asks for."""

    def path(text: str) -> Path | None:
        return Path(text) if text else None

    return load_robot_settings(
        arguments.robot,
        config=path(arguments.config),
        urdf=path(arguments.urdf),
        srdf=path(arguments.srdf),
        world=arguments.world or None,
        namespace=arguments.namespace or None,
    )
