# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Stops all that moves, for any client."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
from typing import Any

from action_msgs.srv import CancelGoal
from std_msgs.msg import String

from armsim_ros.nodes.client.ros_client import RosClient

_EVENT = '/trajectory_execution_event'
_CANCEL = '/_action/cancel_goal'
_MOVING = ('control_msgs/action/', 'moveit_msgs/action/')


class Stopper:
    """
    Cancels every goal of every controller and of move_group.

    :param client: to the graph.
    """

    def __init__(self, client: RosClient) -> None:
        """Make the publisher, so that move_group has found it when it is needed."""
        self._client = client
        self._publisher = client.in_thread(
            lambda: client.node.create_publisher(String, _EVENT, 10)).result(5.0)

    def actions(self) -> list[str]:
        """Return the names of the actions whose goals move a robot and that have a server."""
        node = self._client.node
        return sorted(
            name.removesuffix('/_action/send_goal')
            for name, kinds in node.get_service_names_and_types()
            if name.endswith('/_action/send_goal') and kinds[0].startswith(_MOVING)
            and node.count_services(name))

    def prepare(self) -> list[str] | None:
        """Make the clients of all actions that can be stopped; return these, None without any."""
        actions = self.actions()
        for action in actions:
            self._client.prepare(CancelGoal, action + _CANCEL)
        return actions or None

    def hears(self, action: str) -> bool:
        """Return whether the server of a prepared action would receive a request."""
        return self._client.serves(CancelGoal, action + _CANCEL)

    def stop(self, actions: Sequence[str] | None = None) -> list[Future[Any]]:
        """
        Ask move_group and actions to stop; a goal id of zeros with the time zero is every goal.

        :param actions: None asks all.
        :returns: their responses to be, of CancelGoal.
        """
        self._client.in_thread(lambda: self._publisher.publish(String(data='stop')))
        return [self._client.call(CancelGoal, action + _CANCEL)
                for action in (self.actions() if actions is None else actions)]
