# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The last message of a topic, for those who need it now."""

from __future__ import annotations

from collections.abc import Callable
import math
import threading
import time
from typing import Any

from sensor_msgs.msg import JointState

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.errors import SimulationError

#: Time in which the topics of a running arm have a message [s].
PATIENCE = 9.0


class LatestMessage:
    """
    The last message of a topic.

    :param client: the node that subscribes.
    :param remedy: for an error where no message comes.
    """

    def __init__(self, client: ClientNode, kind: type[Any], topic: str, remedy: str) -> None:
        self._client, self._topic, self._remedy = client, topic, remedy
        self._message: Any = None
        self._is_new = False
        self._received = -math.inf
        self._dropped = ''
        self._condition = threading.Condition()
        self._subscription = client.node.create_subscription(kind, topic, self._receive, 1)

    def get(self, timeout: float = PATIENCE) -> Any:
        """
        Return the last message, waiting for the first.

        :param timeout: [s].
        :raises SimulationError: none came in time.
        """
        return self._awaited(lambda: self._message is not None, timeout)

    def take(self, timeout: float = PATIENCE) -> Any:
        """Return a message that was not taken before, waiting for it, as ``get`` does."""
        with self._condition:
            message = self._awaited(lambda: self._is_new, timeout)
            self._is_new = False
            return message

    @property
    def age(self) -> float:
        """How long ago the last message came [s]; infinite before the first."""
        return time.monotonic() - self._received

    def close(self) -> None:
        """Unsubscribe."""
        self._client.in_executor(
            lambda: self._client.node.destroy_subscription(self._subscription))

    def _receive(self, message: Any) -> None:
        with self._condition:
            self._message, self._is_new = message, True
            self._received = time.monotonic()
            self._condition.notify_all()

    def _awaited(self, condition: Callable[[], bool], timeout: float) -> Any:
        with self._condition:
            if not self._condition.wait_for(condition, timeout):
                raise SimulationError(
                    f"no message on '{self._topic}' within {timeout:g} s; "
                    + (self._dropped or self._remedy))
            return self._message


class JointStates(LatestMessage):
    """
    The last joint states of a topic.

    Messages with fewer positions than names, or more, are dropped with a warning, as
    robot_state_publisher does.

    :param client: the node that subscribes.
    :param remedy: for an error where no message comes.
    """

    def __init__(self, client: ClientNode, topic: str, remedy: str) -> None:
        super().__init__(client, JointState, topic, remedy)

    @property
    def positions(self) -> dict[str, float]:
        """Joint -> position [rad or m], of the last message."""
        message = self.get()
        return dict(zip(message.name, message.position, strict=True))

    def _receive(self, message: JointState) -> None:
        names, positions = len(message.name), len(message.position)
        if names == positions:
            super()._receive(message)
            return
        self._dropped = (f'a message with {names} names and {positions} positions was dropped; '
                         'its publisher must give each joint a position')
        self._client.node.get_logger().warning(f"'{self._topic}': {self._dropped}", once=True)
