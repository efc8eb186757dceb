# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An executor that waits for what is to be served, and looks for mere warnings now and then."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any, TypeGuard

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.event_handler import EventHandler, QoSPublisherEventType, QoSSubscriptionEventType
from rclpy.exceptions import InvalidHandle
from rclpy.executors import SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node

#: How often incompatible endpoints are reported [s].
_PERIOD = 1.0
#: What rclpy has each publisher and subscription listen for, to log a warning; values of both
#: types may be equal.
_WARNINGS = {
    QoSPublisherEventType: (
        QoSPublisherEventType.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS,
        QoSPublisherEventType.RCL_PUBLISHER_INCOMPATIBLE_TYPE),
    QoSSubscriptionEventType: (
        QoSSubscriptionEventType.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS,
        QoSSubscriptionEventType.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE),
}


def _is_warning(entity: Any) -> TypeGuard[EventHandler]:
    return isinstance(entity, EventHandler) and (
        entity.event_type in _WARNINGS[type(entity.event_type)])


class LeanExecutor(SingleThreadedExecutor):
    """
    A single-threaded executor whose wait set holds no events of incompatible endpoints.

    rclpy adds two of them for each publisher and subscription, and makes the wait set anew for
    every message: they take longer than all other entities together. This executor checks
    them once a second, in a timer of the first node that is added.

    :param options: those of ``SingleThreadedExecutor``.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._reports_incompatible = False

    def add_node(self, node: Node) -> bool:
        """Run a node; the first must stay as long as the executor."""
        if not self._reports_incompatible:
            self._reports_incompatible = True
            node.create_timer(
                _PERIOD, self._report_incompatible, clock=Clock(clock_type=ClockType.STEADY_TIME))
        return bool(super().add_node(node))

    def can_execute(self, entity: Any) -> bool:
        """Return whether to wait for an entity."""
        return not _is_warning(entity) and bool(super().can_execute(entity))

    def _report_incompatible(self) -> None:
        events = [each for node in self.get_nodes() for each in node.waitables
                  if _is_warning(each)]
        if not events:
            return  # an empty wait set is an error
        context = self._context.handle
        assert context is not None  # a node of it has called this
        with ExitStack() as alive:
            alive.enter_context(context)
            wait_set = _rclpy.WaitSet(0, 0, 0, 0, 0, len(events), context)
            wait_set.clear_entities()
            listed = []
            for event in events:
                try:
                    alive.enter_context(event)
                except InvalidHandle:  # destroyed by another thread
                    continue
                event.add_to_wait_set(wait_set)
                listed.append(event)
            wait_set.wait(0)
            for event in listed:
                if event.is_ready(wait_set):
                    event.callback(event.take_data())
