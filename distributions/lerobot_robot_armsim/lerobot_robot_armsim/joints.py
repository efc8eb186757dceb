# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A topic of joint states, such as that of a leader arm, as a teleoperator of LeRobot."""

from dataclasses import dataclass
from typing import Any

from lerobot.teleoperators import TeleoperatorConfig

from armsim_ros.errors import ArmsimError
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.tasks.hand import HandModel
from lerobot_robot_armsim.robot import GRIPPER
from lerobot_robot_armsim.teleoperators import Undemanding
from lerobot_robot_armsim.topic_device import TopicDevice


@TeleoperatorConfig.register_subclass('armsim_joints')
@dataclass(kw_only=True)
class ArmsimJointsConfig(TeleoperatorConfig):
    """
    Joint states that an arm follows.

    :param robot: the following arm's name or folder: it has the joints that are read.
    :param topic: of the ``sensor_msgs/msg/JointState``.
    """

    robot: str = 'sunday'
    topic: str = '/leader/joint_states'


class ArmsimJoints(TopicDevice, Undemanding):
    """
    Gives the positions of a topic as actions of the robot ``armsim``, joint by joint.

    A suction cup is on while the topic's joint ``gripper`` is above 0.5, if it has one.
    """

    config_class = ArmsimJointsConfig
    name = 'armsim_joints'

    def __init__(self, config: ArmsimJointsConfig) -> None:
        super().__init__(config)
        self.config = config
        cell = load_cell(config.robot)
        self._hand = HandModel.of(cell)
        self._joints = self._hand.arm_joints(cell.model)

    @property
    def action_features(self) -> dict[str, type]:
        """Names of the numbers of an action."""
        return {**{f'{joint}.pos': float for joint in self._joints}, GRIPPER: float}

    def connect(self, calibrate: bool = True) -> None:
        """Wait for the first message."""
        from armsim_ros.clients.client_node import JointStates

        self._subscribe(lambda node: JointStates(
            node, self.config.topic, 'start what publishes it'), self._check)

    def get_action(self) -> dict[str, Any]:
        """Return the positions of the last message."""
        now, hand = self._topic.positions, self._hand
        level = now.get('gripper', 0.0)
        if hand.joint in now:
            level = hand.level_of(now[hand.joint])
        return {**{f'{joint}.pos': now[joint] for joint in self._joints}, GRIPPER: 100.0 * level}

    def _check(self, message: Any) -> None:
        missing = [joint for joint in self._joints if joint not in message.name]
        if missing:
            raise ArmsimError(f"'{self.config.topic}' has no joint '{missing[0]}'; it has "
                              f'{", ".join(message.name)}')
