# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``trajectory_execution_event``."""

from __future__ import annotations

from std_msgs.msg import String

from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.execution.trajectory_execution import TrajectoryExecutionManager


class TrajectoryExecutionEvent:
    """
    Stops the robot when the message is "stop".

    :param context: the parts of move_group.
    :param execution: what is stopped.
    """

    def __init__(self, context: Context, execution: TrajectoryExecutionManager) -> None:
        self._context = context
        self._execution = execution
        context.subscribe(String, 'trajectory_execution_event', self._receive)

    def _receive(self, message: String) -> None:
        if message.data != 'stop':
            self._context.logger.warning(
                f"trajectory_execution_event: '{message.data[:60]}' is not known; allowed: stop"
            )
        elif self._execution.stop():
            self._context.logger.info("trajectory_execution_event: 'stop', the robot is stopped")
