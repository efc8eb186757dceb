# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A topic of joint states, such as that of a leader arm, as a teleoperator of LeRobot."""

from dataclasses import dataclass
from typing import Any

from lerobot.teleoperators import Teleoperator, TeleoperatorConfig
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError

from armsim_ros.errors import ArmsimError
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.tasks.hand import HandModel
from lerobot_robot_armsim.robot import GRIPPER


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


class ArmsimJoints(Teleoperator):
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
        self._node: Any = None

    @property
    def action_features(self) -> dict[str, type]:
        """Names of the numbers of an action."""
        return {**{f'{joint}.pos': float for joint in self._joints}, GRIPPER: float}

    @property
    def feedback_features(self) -> dict[str, type]:
        """Names of what it can feel: nothing."""
        return {}

    @property
    def is_connected(self) -> bool:
        """Whether it gives actions."""
        return self._node is not None

    @property
    def is_calibrated(self) -> bool:
        """Whether it is calibrated: always."""
        return True

    def connect(self, calibrate: bool = True) -> None:
        """Wait for the first message."""
        if self._node is not None:
            raise DeviceAlreadyConnectedError(f'{self} is connected already')
        from sensor_msgs.msg import JointState

        from armsim_ros.clients.client_node import ClientNode
        from armsim_ros.clients.streamed_arm import LatestMessage

        self._node = ClientNode(name='lerobot_armsim_joints')
        self._states = LatestMessage(
            self._node, JointState, self.config.topic, 'start what publishes it')
        try:
            known = self._states.get().name
            missing = [joint for joint in self._joints if joint not in known]
            if missing:
                raise ArmsimError(f"'{self.config.topic}' has no joint '{missing[0]}'; it has "
                                  f'{", ".join(known)}')
        except ArmsimError as error:
            self.disconnect()
            raise DeviceNotConnectedError(str(error)) from None

    def calibrate(self) -> None:
        """Do nothing: positions are what they are."""

    def configure(self) -> None:
        """Do nothing: there are no settings on a device."""

    def get_action(self) -> dict[str, Any]:
        """Return the positions of the last message."""
        if self._node is None:
            raise DeviceNotConnectedError(f'{self} is not connected; call connect() first')
        message, hand = self._states.get(), self._hand
        now = dict(zip(message.name, message.position, strict=True))
        level = now.get('gripper', 0.0)
        if hand.joint in now:
            level = hand.level_of(now[hand.joint])
        return {**{f'{joint}.pos': now[joint] for joint in self._joints}, GRIPPER: 100.0 * level}

    def send_feedback(self, feedback: dict[str, Any]) -> None:
        """Do nothing: it feels nothing."""

    def disconnect(self) -> None:
        """Give no more actions."""
        node, self._node = self._node, None
        if node is not None:
            node.close()
