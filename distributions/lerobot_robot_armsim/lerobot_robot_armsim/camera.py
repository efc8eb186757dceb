# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A topic of pictures as a camera of LeRobot."""

from dataclasses import dataclass
from typing import Any

from lerobot.cameras import Camera, CameraConfig
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError
import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import ArmsimError


@CameraConfig.register_subclass('armsim')
@dataclass(kw_only=True)
class ArmsimCameraConfig(CameraConfig):
    """
    Pictures of a topic.

    :param topic: of the ``sensor_msgs/msg/Image``.
    """

    topic: str = '/camera/color/image_raw'


class ArmsimCamera(Camera):
    """Gives the pictures of a topic, red first."""

    def __init__(self, config: ArmsimCameraConfig) -> None:
        super().__init__(config)
        self.config = config
        self._node: Any = None

    @property
    def is_connected(self) -> bool:
        """Whether there are pictures."""
        return self._node is not None

    @staticmethod
    def find_cameras() -> list[dict[str, Any]]:
        """Return nothing: topics are found with ``ros2 topic list``."""
        return []

    def connect(self, warmup: bool = True) -> None:
        """Wait for the first picture."""
        if self._node is not None:
            raise DeviceAlreadyConnectedError(f'{self.config.topic} is connected already')
        from sensor_msgs.msg import Image

        from armsim_ros.clients.client_node import ClientNode
        from armsim_ros.clients.streamed_arm import LatestMessage

        self._node = ClientNode(name='lerobot_armsim_camera')
        self._pictures = LatestMessage(
            self._node, Image, self.config.topic, 'start the camera: armsim bringup camera:=true')
        try:
            message = self._pictures.get()
        except ArmsimError as error:
            self.disconnect()
            raise DeviceNotConnectedError(str(error)) from None
        given = (self.height or message.height, self.width or message.width)
        if given != (message.height, message.width):
            self.disconnect()
            raise ValueError(f"the pictures of '{self.config.topic}' have {message.height} x "
                             f'{message.width} pixels, not {given[0]} x {given[1]}')
        self.height, self.width = given

    def read(self) -> NDArray[np.uint8]:
        """Return the last picture (h, w, 3)."""
        return self._picture(self._connected.get())

    def async_read(self, timeout_ms: float = 200) -> NDArray[np.uint8]:
        """Return a picture that was not returned before."""
        try:
            return self._picture(self._connected.take(timeout_ms / 1000.0))
        except ArmsimError as error:
            raise TimeoutError(str(error)) from None

    def read_latest(self, max_age_ms: int = 500) -> NDArray[np.uint8]:
        """Return the last picture; TimeoutError where none came for so long."""
        age = self._connected.age
        if age * 1000.0 > max_age_ms:
            raise TimeoutError(f"the last picture on '{self.config.topic}' is {age:.1f} s old, "
                               f'not {max_age_ms} ms at most; does its camera still run?')
        return self.read()

    def disconnect(self) -> None:
        """Unsubscribe."""
        node, self._node = self._node, None
        if node is not None:
            node.close()

    @property
    def _connected(self) -> Any:
        if self._node is None:
            raise DeviceNotConnectedError(f'{self.config.topic} is not connected')
        return self._pictures

    def _picture(self, message: Any) -> NDArray[np.uint8]:
        from armsim_ros.data.recordings.messages import picture_of

        return picture_of(message, 'sensor_msgs/msg/Image', self.config.topic)
