# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What devices of LeRobot share that give the last message of a topic."""

from collections.abc import Callable
from typing import Any

from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError

from armsim_ros.errors import ArmsimError


class TopicDevice:
    """Subscribes while it is connected; its other base class is LeRobot's."""

    #: With its ``topic``.
    config: Any
    _node: Any = None
    _latest: Any = None

    @property
    def is_connected(self) -> bool:
        """Whether there are messages."""
        return self._node is not None

    def disconnect(self) -> None:
        """Unsubscribe."""
        node, self._node = self._node, None
        if node is not None:
            node.close()

    def _subscribe(self, subscribed: Callable[[Any], Any], check: Callable[[Any], object]) -> None:
        """
        Wait for the first message.

        :param subscribed: gets a node and returns a ``LatestMessage``.
        :param check: gets the message; what it raises ends the connection.
        :raises DeviceNotConnectedError: none comes, or it is not usable.
        """
        if self.is_connected:
            raise DeviceAlreadyConnectedError(f'{self.config.topic} is connected already')
        from armsim_ros.clients.client_node import ClientNode

        self._node = ClientNode(name=f'lerobot_{type(self).__name__.lower()}')
        try:
            self._latest = subscribed(self._node)
            check(self._latest.get())
        except ArmsimError as error:
            self.disconnect()
            raise DeviceNotConnectedError(str(error)) from None
        except BaseException:
            self.disconnect()
            raise

    @property
    def _topic(self) -> Any:
        if self._node is None:
            raise DeviceNotConnectedError(
                f'{self.config.topic} is not connected; call connect() first')
        return self._latest
