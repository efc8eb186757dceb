# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The move_group program from start to end."""

from __future__ import annotations

from contextlib import ExitStack
import sys
import time
from typing import Any, ClassVar

from rcl_interfaces.msg import ParameterDescriptor
import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from armsim_ros.nodes.executor_program import ExecutorProgram, failures_logged
from armsim_ros.nodes.move_group.assembly import MoveGroup
from armsim_ros.nodes.parameters import parameters_by_prefix
from armsim_ros.nodes.polling_node import PollingNode

#: Time for goals to be aborted at shutdown, and for answers to leave the process [s].
_END_TIME, _ANSWER_TIME = 1.0, 0.02
#: A client that has just sent a goal asks for its result this late [s].
_LATE_TIME = 0.2
#: A goal that has ended sends its result in a step of its own.
_LAST_STEPS = 5
#: How often the planner's thread yields the interpreter, so that answers do not wait [s].
_SWITCH_INTERVAL = 0.001


class MoveGroupProgram(ExecutorProgram):
    """Plans and executes: endpoints run in this thread, planning in worker threads."""

    NODE = 'move_group'
    NODE_OPTIONS: ClassVar[dict[str, Any]] = {
        'allow_undeclared_parameters': True,
        'automatically_declare_parameters_from_overrides': True,
    }

    def _serve(
        self, executor: SingleThreadedExecutor, node: PollingNode, afterwards: ExitStack
    ) -> int:
        sys.setswitchinterval(_SWITCH_INTERVAL)
        name_with_dots(node)
        move_group = MoveGroup(node, executor, self._cell)
        afterwards.callback(move_group.close)
        self._spin(executor, node, move_group)
        return 0

    def _spin(
        self, executor: SingleThreadedExecutor, node: Node, move_group: MoveGroup
    ) -> None:
        """Run callbacks until a stop is requested, and a little longer if clients wait."""
        pending: set[Future] = set()
        ending = False

        def to_end() -> bool:
            return self._stop_wanted() and not ending

        def step() -> None:
            """Run a callback, with the newest state and time."""
            with failures_logged(node):
                # Always the same arguments: with others, callbacks that are ready would be lost.
                callback, *_ = executor.wait_for_ready_callbacks(None, None, to_end)
                move_group.catch_up()
                callback()
                (pending.discard if callback.done() else pending.add)(callback)
                callback.result()  # raises what the callback raised

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
    for name, parameter in parameters_by_prefix(node, '').items():
        dotted = name.strip('/').replace('/', '.')
        if dotted != name and not node.has_parameter(dotted):
            node.declare_parameter(
                dotted, parameter.value, ParameterDescriptor(dynamic_typing=True)
            )
