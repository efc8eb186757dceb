# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A transform between two frames that a program waits for."""

from __future__ import annotations

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.time import Time
from tf2_ros import Buffer, TransformListener

#: How often what is missing is logged at most [s].
_REPORT_PERIOD = 1.0
#: The latest time that all frames have.
LATEST = Time()


class AwaitedTransform:
    """
    The newest transform between two frames.

    :param node: gets the subscriptions and logs what is missing.
    :param target: the frame in which the pose is expressed.
    :param source: the frame whose pose it is.
    """

    def __init__(self, node: Node, target: str, source: str) -> None:
        self.target, self.source = target, source
        self.buffer = Buffer(node=node)
        self._logger = node.get_logger()
        self._listener = TransformListener(self.buffer, node)

    def available(self) -> bool:
        """Return whether the transform can be looked up; log why not, at most once a second."""
        possible, reason = self.buffer.can_transform_core(self.target, self.source, LATEST)
        if not possible:
            self._logger.info(f'Waiting for transform {self.target} ->  {self.source}: {reason}',
                              throttle_duration_sec=_REPORT_PERIOD)
        return possible

    def look_up(self) -> TransformStamped:
        """
        Return the newest transform.

        :raises tf2_ros.TransformException: it is not available any more.
        """
        return self.buffer.lookup_transform(self.target, self.source, LATEST)
