# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A topic of pictures as a camera of LeRobot."""

from dataclasses import dataclass
from typing import Any

from lerobot.cameras import Camera, CameraConfig
import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import ArmsimError
from lerobot_robot_armsim.topic_device import TopicDevice


@CameraConfig.register_subclass('armsim')
@dataclass(kw_only=True)
class ArmsimCameraConfig(CameraConfig):
    """
    Pictures of a topic.

    :param topic: of the ``sensor_msgs/msg/Image``.
    """

    topic: str = '/camera/color/image_raw'


class ArmsimCamera(TopicDevice, Camera):
    """Gives the pictures of a topic, red first."""

    def __init__(self, config: ArmsimCameraConfig) -> None:
        super().__init__(config)
        self.config = config

    @staticmethod
    def find_cameras() -> list[dict[str, Any]]:
        """Return nothing: topics are found with ``ros2 topic list``."""
        return []

    def connect(self, warmup: bool = True) -> None:
        """Wait for the first picture."""
        from sensor_msgs.msg import Image

        from armsim_ros.clients.client_node import LatestMessage

        self._subscribe(lambda node: LatestMessage(
            node, Image, self.config.topic, 'start the camera: armsim bringup camera:=true'),
            self._fit)

    def read(self) -> NDArray[np.uint8]:
        """Return the last picture (h, w, 3)."""
        return self._picture(self._topic.get())

    def async_read(self, timeout_ms: float = 200) -> NDArray[np.uint8]:
        """Return a picture that was not returned before."""
        try:
            return self._picture(self._topic.take(timeout_ms / 1000.0))
        except ArmsimError as error:
            raise TimeoutError(str(error)) from None

    def read_latest(self, max_age_ms: int = 500) -> NDArray[np.uint8]:
        """Return the last picture; TimeoutError where none came for so long."""
        age = self._topic.age
        if age * 1000.0 > max_age_ms:
            raise TimeoutError(f"the last picture on '{self.config.topic}' is {age:.1f} s old, "
                               f'not {max_age_ms} ms at most; does its camera still run?')
        return self.read()

    def _fit(self, message: Any) -> None:
        """Take the size of the pictures over, or refuse another one than was given."""
        given = (self.height or message.height, self.width or message.width)
        if given != (message.height, message.width):
            raise ValueError(f"the pictures of '{self.config.topic}' have {message.height} x "
                             f'{message.width} pixels, not {given[0]} x {given[1]}')
        self.height, self.width = given

    def _picture(self, message: Any) -> NDArray[np.uint8]:
        from armsim_ros.data.topic_map import picture_of

        return picture_of(message, 'sensor_msgs/msg/Image', self.config.topic)
