# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The servo_node program from start to end."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any, ClassVar

import rclpy
from rclpy.executors import SingleThreadedExecutor

from armsim_ros.nodes.executor_program import ExecutorProgram, failures_logged
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.nodes.servo.assembly import ServoNode


class ServoProgram(ExecutorProgram):
    """Streams in a thread of its own; services are answered in the main thread."""

    NODE = 'servo_node'
    NODE_OPTIONS: ClassVar[dict[str, Any]] = {'clock_when_asked': True}

    def _serve(
        self, executor: SingleThreadedExecutor, node: PollingNode, afterwards: ExitStack
    ) -> int:
        servo = ServoNode(node, self._cell)
        try:
            servo.start()
            while not self._stop_wanted() and rclpy.ok():
                if servo.failure:
                    node.get_logger().error(f'the stream has ended; please report this:\n'
                                            f'{servo.failure}')
                    return 1
                with failures_logged(node):
                    callback, *_ = executor.wait_for_ready_callbacks(1.0, None, self._stop_wanted)
                    callback()
                    callback.result()  # raises what the callback raised
        finally:
            servo.stop()
        return 0
