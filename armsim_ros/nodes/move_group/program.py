# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The move_group program from start to end."""

from __future__ import annotations

from collections.abc import Callable
import sys
import traceback

from rcl_interfaces.msg import ParameterDescriptor
import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from armsim_ros.cli.arguments import ProgramArguments
from armsim_ros.cli.environment import started_by_bringup
from armsim_ros.cli.settings import cell_of
from armsim_ros.nodes.move_group.assembly import MoveGroup

#: The planner's thread hands the interpreter over this often, so that answers do not wait [s].
_SWITCH_INTERVAL = 0.001


class MoveGroupProgram:
    """
    The robots' model, the node, and the executor that runs it in the calling thread.

    :param arguments: the command line.
    :param stop_wanted: whether a signal came; looked at between the steps of the start.
    :raises ConfigError: the user's files do not describe a robot that can be planned for.
    """

    def __init__(self, arguments: ProgramArguments, stop_wanted: Callable[[], bool]) -> None:
        """Read the files; no node exists yet."""
        self._arguments = arguments
        self._stop_wanted = stop_wanted
        self._executor: SingleThreadedExecutor | None = None
        self._cell, warnings = cell_of(arguments)
        # Beside a simulation, which tells the same of the same files, they would be there twice.
        self._warnings = [] if started_by_bringup() else warnings

    def stop(self) -> None:
        """End ``run``; from a signal handler too."""
        if self._executor is not None:
            self._executor.wake()

    def run(self) -> int:
        """
        Run until a stop is wanted.

        :returns: the exit status.
        :raises ConfigError: a parameter of the command line is wrong.
        """
        if self._stop_wanted():
            return 0
        sys.setswitchinterval(_SWITCH_INTERVAL)
        rclpy.init(
            args=['move_group', *self._arguments.ros_args],
            signal_handler_options=SignalHandlerOptions.NO,
        )
        move_group: MoveGroup | None = None
        executor = self._executor = SingleThreadedExecutor()
        node = Node(
            'move_group',
            allow_undeclared_parameters=True,
            automatically_declare_parameters_from_overrides=True,
            parameter_overrides=[
                Parameter('use_sim_time', value=self._arguments.use_sim_time)
            ],
        )
        executor.add_node(node)
        name_with_dots(node)
        for text in self._warnings:
            node.get_logger().warning(text)
        try:
            move_group = MoveGroup(node, executor, self._cell)
            self._spin(executor, node)
        finally:
            if move_group is not None:
                move_group.close()
            executor.shutdown(0.0)
            node.destroy_node()
            rclpy.try_shutdown()
        return 0

    def _spin(self, executor: SingleThreadedExecutor, node: Node) -> None:
        """Run callbacks until a stop is wanted; the timers end every wait within 20 ms."""
        while not self._stop_wanted():
            try:
                executor.spin_once()
            except ExternalShutdownException:
                return
            except Exception:  # noqa: BLE001 - no request may end the program
                node.get_logger().error(
                    'a request failed inside the program; please report this:\n'
                    + traceback.format_exc()
                )


def name_with_dots(node: Node) -> None:
    """Give parameters of ``--ros-args`` whose names have the slashes of ROS 1 their own names."""
    for name, parameter in node.get_parameters_by_prefix('').items():
        dotted = name.strip('/').replace('/', '.')
        if dotted != name and not node.has_parameter(dotted):
            node.declare_parameter(
                dotted, parameter.value, ParameterDescriptor(dynamic_typing=True)
            )
