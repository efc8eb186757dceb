# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Timers of ROS time, and transitions of lifecycle nodes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from armsim_ros.launch.api.actions.events import TimerAction
from armsim_ros.launch.api.context import LaunchContext
from armsim_ros.launch.api.entity import Action


class RosTimer(TimerAction):
    """Actions after a delay; simulated time is taken to run as fast as the wall clock."""


class LifecycleTransition(Action):
    """
    Requests transitions of lifecycle nodes.

    :param lifecycle_node_names: the nodes.
    :param transition_ids: the transitions in order.
    """

    def __init__(
        self, *, lifecycle_node_names: Iterable[Any], transition_ids: Iterable[Any],
        **kwargs: Any,
    ) -> None:
        super().__init__(condition=kwargs.get('condition'))
        self._names = list(lifecycle_node_names)
        self._transitions = list(transition_ids)

    def execute(self, context: LaunchContext) -> None:
        """Log that nothing is done: none of our programs is a lifecycle node."""
        if context.engine is not None:
            context.engine.tell_unknown('transitions of lifecycle nodes are not requested')
