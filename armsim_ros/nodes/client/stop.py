# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Stops all that moves, whoever began it."""

from __future__ import annotations

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
        """Return the names of the actions whose goals move a robot."""
        found = []
        for name, kinds in self._client.node.get_service_names_and_types():
            if name.endswith('/_action/send_goal') and kinds[0].startswith(_MOVING):
                found.append(name.removesuffix('/_action/send_goal'))
        return sorted(found)

    def prepare(self) -> None:
        """Make the clients of all that can be stopped now, so that none is waited for later."""
        for action in self.actions():
            self._client.prepare(CancelGoal, action + _CANCEL)

    def ready(self) -> bool:
        """Return whether every prepared action would hear."""
        return all(self._client.serves(CancelGoal, action + _CANCEL) for action in self.actions())

    def stop(self) -> list[Future[Any]]:
        """
        Ask all to stop; a goal id of zeros with the time zero means every goal.

        :returns: the answers to be, CancelGoal's responses.
        """
        self._client.in_thread(lambda: self._publisher.publish(String(data='stop')))
        return [self._client.call(CancelGoal, action + _CANCEL) for action in self.actions()]
