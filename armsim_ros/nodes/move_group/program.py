# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The move_group program from start to end."""

from __future__ import annotations

from collections.abc import Callable
import sys
import time
import traceback

from rcl_interfaces.msg import ParameterDescriptor
import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.executors import (
    ConditionReachedException,
    ExternalShutdownException,
    SingleThreadedExecutor,
)
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from armsim_ros.cli.arguments import ProgramArguments
from armsim_ros.cli.environment import started_by_bringup
from armsim_ros.cli.settings import cell_of
from armsim_ros.nodes.move_group.assembly import MoveGroup
from armsim_ros.nodes.polling_node import PollingNode

#: Goals get this long to be told that the program ends, and answers to leave it [s].
_END_TIME, _ANSWER_TIME = 1.0, 0.02
#: Who has just sent a goal asks for its result this late [s].
_LATE_TIME = 0.2
#: A goal that has ended sends its result in a step of its own.
_LAST_STEPS = 5
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
        node = PollingNode(
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
            self._spin(executor, node, move_group)
        finally:
            # First the endpoints, so that clients see them gone; workers may take a while.
            executor.shutdown(0.0)
            node.destroy_node()
            rclpy.try_shutdown()
            if move_group is not None:
                move_group.close()
        return 0

    def _spin(
        self, executor: SingleThreadedExecutor, node: Node, move_group: MoveGroup
    ) -> None:
        """Run callbacks until a stop is wanted, and a little longer where somebody waits."""
        pending: set[Future] = set()
        ending = False

        def to_end() -> bool:
            return self._stop_wanted() and not ending

        def step() -> None:
            """Run one callback, with the newest state and time."""
            try:
                # The same words every time: with others, what was ready already would be lost.
                callback, *_ = executor.wait_for_ready_callbacks(None, None, to_end)
                move_group.catch_up()
                callback()
                (pending.discard if callback.done() else pending.add)(callback)
                callback.result()  # raises what the callback raised
            except (ConditionReachedException, ExternalShutdownException):
                return
            except rclpy_implementation.RCLError as error:
                node.get_logger().warning(f'an answer was not delivered: {error}')
            except Exception:  # noqa: BLE001 - no request may end the program
                node.get_logger().error(
                    'a request failed inside the program; please report this:\n'
                    + traceback.format_exc()
                )

        while not self._stop_wanted() and rclpy.ok():
            step()
        if pending:
            ending = True
            move_group.end('move_group is shutting down')
            node.create_timer(  # ends each wait
                _ANSWER_TIME, lambda: None, clock=Clock(clock_type=ClockType.STEADY_TIME)
            )
            begin, at_rest = time.monotonic(), 0
            while rclpy.ok() and (elapsed := time.monotonic() - begin) < _END_TIME:
                if at_rest >= _LAST_STEPS and elapsed > _LATE_TIME:
                    break
                step()
                at_rest = 0 if pending else at_rest + 1
            time.sleep(_ANSWER_TIME)


def name_with_dots(node: Node) -> None:
    """Give parameters of ``--ros-args`` whose names have the slashes of ROS 1 their own names."""
    for name, parameter in node.get_parameters_by_prefix('').items():
        dotted = name.strip('/').replace('/', '.')
        if dotted != name and not node.has_parameter(dotted):
            node.declare_parameter(
                dotted, parameter.value, ParameterDescriptor(dynamic_typing=True)
            )
