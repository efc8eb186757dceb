# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The diagnostics of the camera program on ``/diagnostics``."""

from __future__ import annotations

import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from armsim_ros.nodes import qos
from armsim_ros.nodes.polling_node import PollingNode

#: Wall time between two messages [s].
_PERIOD = 1.0


class RenderingDiagnostics:
    """
    Publishes whether pictures are drawn, and how quickly.

    :param node: the node that publishes; its clock is read.
    """

    def __init__(self, node: PollingNode) -> None:
        self._node = node
        self._publisher = node.create_publisher(
            DiagnosticArray, '/diagnostics', qos.DIAGNOSTICS)
        self._due = 0.0
        self._pictures, self._seconds = 0, 0.0
        self.backend = ''
        """What draws."""
        self.fault = ''
        """Why nothing can be drawn."""
        self.cameras = 0
        """How many cameras the simulation has; 0 as long as there is none."""

    def count(self, seconds: float) -> None:
        """Count a picture that took so long [s]."""
        self._pictures += 1
        self._seconds += seconds

    def publish(self) -> None:
        """Publish when it is due and there are subscribers."""
        now = time.monotonic()
        if now < self._due or not self._publisher.get_subscription_count():
            return
        self._due = now + _PERIOD
        level, text = DiagnosticStatus.OK, 'Pictures are drawn'
        if self.fault:
            level, text = DiagnosticStatus.ERROR, self.fault
        elif not self.cameras:
            level, text = DiagnosticStatus.WARN, 'No simulation with camera:=true is there'
        values = {
            'backend': self.backend,
            'cameras': str(self.cameras),
            'pictures': str(self._pictures),
            'drawing_ms': f'{self._seconds / max(self._pictures, 1) * 1e3:.1f}',
        }
        message = DiagnosticArray(status=[DiagnosticStatus(
            level=level, name='camera: Rendering', message=text,
            hardware_id=self._node.get_fully_qualified_name(),
            values=[KeyValue(key=key, value=value) for key, value in values.items()])])
        self._node.catch_up()
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
