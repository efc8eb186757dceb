# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The move_group program: planning, kinematics, the planning scene, execution."""

from __future__ import annotations

from collections.abc import Sequence
import signal
import sys

import rclpy
from rclpy.exceptions import NotInitializedException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from armsim_ros.cli.arguments import parse_arguments
from armsim_ros.cli.settings import settings_of
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
    # rclpy's own handler ends spin; Python's would interrupt whatever runs, destructors too.
    signal.signal(signal.SIGINT, lambda *_: None)
    rclpy.init(args=['armsim_ros', *arguments.ros_args])
    executor = SingleThreadedExecutor()
    move_group: MoveGroup | None = None
    try:
        node = Node(
            'move_group',
            allow_undeclared_parameters=True,
            automatically_declare_parameters_from_overrides=True,
            parameter_overrides=[Parameter('use_sim_time', value=arguments.use_sim_time)],
        )
        executor.add_node(node)
        move_group = MoveGroup(node, executor, settings, robot)
        executor.spin()
    except ExternalShutdownException:
        return 0
    except (NotInitializedException, RuntimeError):
        # What rclpy raises from anything that is made after a signal has shut it down.
        if rclpy.ok():
            raise
        return 0
    finally:
        if move_group is not None:
            move_group.close()
        executor.shutdown(0.5)
        rclpy.try_shutdown()
    return 0

