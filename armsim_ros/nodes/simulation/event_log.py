# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controllers' events: log lines and refusals."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

from rclpy.node import Node

from armsim_ros.control.events import CAPACITY, ControllerEvent
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.nodes.simulation.controllers.controller_nodes import ControllerNode

_REFUSALS = ('goal_rejected', 'trajectory_rejected')


class EventLog:
    """
    Logs the events of controllers under their nodes' names, and passes on refusals.

    :param node: the manager's node, for what belongs to no controller.
    :param sides: controller -> its ROS side; looked up at every event.
    """

    def __init__(
        self,
        node: Node,
        manager: ControllerManager,
        sides: Mapping[str, ControllerNode],
    ) -> None:
        self._node = node
        self._manager = manager
        self._sides = sides
        #: The last events, for recordings.
        self.recent: deque[ControllerEvent] = deque(maxlen=CAPACITY)

    def drain(self) -> None:
        """Log all events since the last call."""
        for event in self._manager.poll_events():
            self.recent.append(event)
            side = self._sides.get(event.source)
            logger = (side.node if side is not None else self._node).get_logger()
            if event.level == 'error':
                logger.error(event.text)
            elif event.level == 'warning':
                logger.warning(event.text)
            else:
                logger.info(event.text)
            if side is not None and event.kind in _REFUSALS:
                side.refused(event.text)
