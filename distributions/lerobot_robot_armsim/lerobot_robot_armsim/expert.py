# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The scripted expert of a task as a teleoperator of LeRobot."""

from dataclasses import dataclass
from typing import Any

from lerobot.teleoperators import TeleoperatorConfig
from lerobot.utils.errors import DeviceNotConnectedError

from lerobot_robot_armsim.robot import Armsim, GRIPPER
from lerobot_robot_armsim.teleoperators import Undemanding


@TeleoperatorConfig.register_subclass('armsim_expert')
@dataclass(kw_only=True)
class ArmsimExpertConfig(TeleoperatorConfig):
    """The expert of the robot ``armsim`` in the same process."""


class ArmsimExpert(Undemanding):
    """Gives the actions of the expert of the robot that is connected."""

    config_class = ArmsimExpertConfig
    name = 'armsim_expert'

    def __init__(self, config: ArmsimExpertConfig) -> None:
        super().__init__(config)
        self.config = config
        self._connected = False

    @property
    def action_features(self) -> dict[str, type]:
        """Names of the numbers of an action: those of the robot."""
        return self._robot().action_features

    @property
    def is_connected(self) -> bool:
        """Whether it gives actions."""
        return self._connected

    def connect(self, calibrate: bool = True) -> None:
        """Begin to give actions."""
        self._connected = True

    def get_action(self) -> dict[str, Any]:
        """Return where the expert moves the joints next."""
        task = self._robot().task
        goals, level = task.command_in(task.expert())
        return {**{f'{joint}.pos': goal for joint, goal in goals.items()}, GRIPPER: 100.0 * level}

    def disconnect(self) -> None:
        """Give no more actions."""
        self._connected = False

    @staticmethod
    def _robot() -> Armsim:
        if Armsim.connected is None:
            raise DeviceNotConnectedError(
                'the teleoperator armsim_expert needs the robot armsim in the same process: '
                '--robot.type=armsim')
        return Armsim.connected
