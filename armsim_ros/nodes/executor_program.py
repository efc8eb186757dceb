# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Programs of a node, from their start to their end."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager, ExitStack
import traceback
from typing import Any, ClassVar

import rclpy
from rclpy.executors import ConditionReachedException, ExternalShutdownException, TimeoutException
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from armsim_ros.cli.arguments import ProgramArguments
from armsim_ros.cli.environment import started_by_bringup
from armsim_ros.cli.settings import cell_of
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.nodes.shutdown import shut_down
from armsim_ros.nodes.wait_set_executor import WaitSetExecutor


class ExecutorProgram(ABC):
    """
    The robot's model, the node, and the executor that serves it in the calling thread.

    :param stop_wanted: whether a signal came; read between the steps of the start.
    :raises ConfigError: the user's files do not describe a robot.
    """

    #: The node's name, and what else its constructor is given.
    NODE: ClassVar[str]
    NODE_OPTIONS: ClassVar[dict[str, Any]] = {}

    def __init__(self, arguments: ProgramArguments, stop_wanted: Callable[[], bool]) -> None:
        self._arguments, self._stop_wanted = arguments, stop_wanted
        self._executor: WaitSetExecutor | None = None
        self._cell, warnings = cell_of(arguments)
        # A simulation beside it reports the same about the same files.
        self._warnings = [] if started_by_bringup() else warnings

    def stop(self) -> None:
        """End ``run``; from a signal handler too."""
        if self._executor is not None:
            self._executor.wake()

    def run(self) -> int:
        """
        Run until a stop is requested.

        :returns: the exit status.
        :raises ArmsimError: a parameter of the command line is wrong.
        """
        if self._stop_wanted():
            return 0
        rclpy.init(
            args=[self.NODE, *self._arguments.ros_args],
            signal_handler_options=SignalHandlerOptions.NO)
        executor = self._executor = WaitSetExecutor()
        use_sim_time = Parameter('use_sim_time', value=self._arguments.use_sim_time)
        node = PollingNode(self.NODE, parameter_overrides=[use_sim_time], **self.NODE_OPTIONS)
        executor.add_node(node)
        for text in self._warnings:
            node.get_logger().warning(text)
        with ExitStack() as afterwards:
            try:
                return self._serve(executor, node, afterwards)
            finally:
                # First the endpoints, so that clients see them gone; threads may take a while.
                executor.shutdown(0.0)
                shut_down(node)

    @abstractmethod
    def _serve(
        self, executor: WaitSetExecutor, node: PollingNode, afterwards: ExitStack
    ) -> int:
        """
        Make the endpoints and run callbacks until a stop is requested.

        :param afterwards: closed once the endpoints are gone.
        :returns: the exit status.
        """


@contextmanager
def failures_logged(node: Node) -> Iterator[None]:
    """Wait for a callback and run it: nothing that fails there ends the program."""
    try:
        yield
    except (ConditionReachedException, ExternalShutdownException, TimeoutException):
        pass
    except rclpy_implementation.RCLError as error:
        node.get_logger().warning(f'an answer was not delivered: {error}')
    except Exception:  # noqa: BLE001 - no request may end the program
        node.get_logger().error(
            'a request failed inside the program; please report this:\n' + traceback.format_exc())
