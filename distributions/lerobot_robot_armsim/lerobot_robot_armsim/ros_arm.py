# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A running arm, observed and moved over ROS."""

from collections.abc import Mapping, Sequence
from typing import Any

from lerobot.utils.errors import DeviceNotConnectedError

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.streamed_arm import StreamedArm
from armsim_ros.errors import ArmsimError
from armsim_ros.model.cell_loading import load_cell


class RosArm:
    """
    Follows a stream of positions, and gives the arm back when it is closed.

    :param config: an ``ArmsimConfig``.
    :raises DeviceNotConnectedError: there is no arm; with what is missing and how to start it.
    """

    def __init__(self, config: Any) -> None:
        self._period = 1.0 / config.fps
        self._node = ClientNode(name='lerobot_robot_armsim')
        try:
            self._arm = StreamedArm(
                self._node, load_cell(config.robot), controller=config.controller,
                cameras={name: config.image_topic.format(camera=name)
                         for name in config.camera_names})
            shapes = {name: picture.shape for name, picture in self._arm.pictures().items()}
        except (ArmsimError, AssertionError) as error:
            self._node.close()
            raise DeviceNotConnectedError(str(error)) from None
        wrong = {name: shape for name, shape in shapes.items()
                 if shape != (config.image_height, config.image_width, 3)}
        if wrong:
            name, (height, width, _) = next(iter(wrong.items()))
            self.close()
            raise ValueError(f"the pictures of '{name}' have {height} x {width} pixels: "
                             f'--robot.image_height={height} --robot.image_width={width}')

    @property
    def positions(self) -> dict[str, float]:
        """Joint -> position [rad or m]."""
        return self._arm.positions

    @property
    def level(self) -> float:
        """1 for an open gripper or a cup that is on."""
        return self._arm.level

    def pictures(self) -> dict[str, Any]:
        """Return camera -> its last picture (h, w, 3)."""
        return self._arm.pictures()

    def send(self, goals: Mapping[str, float], level: float) -> dict[str, float]:
        """Command the joints; return what they were commanded within the limits."""
        return self._arm.send(goals, level)

    def move_tip(self, way: Sequence[float], level: float | None) -> None:
        """Command the tip to another place (3,) [m]; without a level the hand stays as it is."""
        self._arm.send(self._arm.moved_by(way, self._period), level)

    def close(self) -> None:
        """Hold the arm, and activate what was active before."""
        try:
            self._arm.close()
        finally:
            self._node.close()
