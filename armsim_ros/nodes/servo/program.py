# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The servo_node program from start to end."""

from __future__ import annotations

from collections.abc import Callable
import traceback

import rclpy
from rclpy.executors import (
    ConditionReachedException,
    ExternalShutdownException,
    SingleThreadedExecutor,
)
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from armsim_ros.cli.arguments import ProgramArguments
from armsim_ros.cli.environment import started_by_bringup
from armsim_ros.cli.settings import cell_of
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.nodes.servo.assembly import ServoNode


class ServoProgram:
    """
    The node, the executor that serves it in the calling thread, and the streaming thread.

    :param arguments: the command line.
    :param stop_wanted: whether a signal came; looked at between the steps of the start.
    :raises ConfigError: the user's files do not describe a robot.
    """

    def __init__(self, arguments: ProgramArguments, stop_wanted: Callable[[], bool]) -> None:
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
        :raises ServoSettingsError: the parameters do not fit each other or the robot.
        """
        if self._stop_wanted():
            return 0
        rclpy.init(
            args=['servo_node', *self._arguments.ros_args],
            signal_handler_options=SignalHandlerOptions.NO,
        )
        executor = self._executor = SingleThreadedExecutor()
        node = PollingNode(
            'servo_node',
            parameter_overrides=[
                Parameter('use_sim_time', value=self._arguments.use_sim_time)
            ],
        )
        executor.add_node(node)
        for text in self._warnings:
            node.get_logger().warning(text)
        servo: ServoNode | None = None
        failed = False
        try:
            servo = ServoNode(node, self._cell)
            servo.start()
            failed = not self._spin(executor, node, servo)
        finally:
            if servo is not None:
                servo.stop()
            executor.shutdown(0.0)
            node.destroy_node()
            rclpy.try_shutdown()
        return 1 if failed else 0

    def _spin(self, executor: SingleThreadedExecutor, node: Node, servo: ServoNode) -> bool:
        """Answer services until a stop is wanted; False where the stream has ended by itself."""
        while not self._stop_wanted():
            if servo.failure:
                node.get_logger().error(f'the stream has ended; please report this:\n'
                                        f'{servo.failure}')  # fmt: skip
                return False
            try:
                callback, *_ = executor.wait_for_ready_callbacks(1.0, None, self._stop_wanted)
                callback()
                callback.result()  # raises what the callback raised
            except (ConditionReachedException, ExternalShutdownException):
                return True
            except rclpy.executors.TimeoutException:
                continue
            except Exception:  # noqa: BLE001 - no request may end the program
                node.get_logger().error(
                    'a request failed inside the program; please report this:\n'
                    + traceback.format_exc()
                )
        return True
