# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated arm as a robot of LeRobot, over ROS or in this process."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from lerobot.robots import Robot, RobotConfig
from lerobot.robots.utils import ensure_safe_goal_position
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError

from armsim_ros.model.cell_loading import load_cell
from armsim_ros.tasks import TaskEnv, TASKS
from armsim_ros.tasks.hand import HandModel
from lerobot_robot_armsim.local_arm import LocalArm

GRIPPER = 'gripper.pos'
#: What the teleoperators ``gamepad`` and ``keyboard_ee`` send; a gripper of 1 stays.
DELTA = ('delta_x', 'delta_y', 'delta_z', 'gripper')
_CLOSE, _OPEN = 0, 2


@RobotConfig.register_subclass('armsim')
@dataclass(kw_only=True)
class ArmsimConfig(RobotConfig):
    """
    A simulated arm.

    :param transport: ``ros``: a running arm; ``local``: the arm of a task in this process, stepped
        by ``send_action``.
    :param robot: the arm's name or folder.
    :param fps: steps per second.
    :param camera_names: whose pictures are observed.
    :param image_height: of these [pixels].
    :param image_width: of these [pixels].
    :param action: ``joints``, or ``ee_delta``: ways of the tip along the world's axes, -1..1.
    :param ee_step: way of the tip in a step for a delta of 1 [m].
    :param max_relative_target: farthest way of a joint in a step [rad], None for the joint's
        velocity limit.
    :param controller: of ``ros``: the forward controller of the joints; '' finds it.
    :param image_topic: of ``ros``: topic of a camera's pictures.
    :param task: of ``local``: part of the id after ``armsim/``; its world is the robot's.
    :param seed: of ``local``: of the first episode; the next has the next seed.
    """

    transport: str = 'ros'
    robot: str = 'sunday'
    fps: int = 20
    camera_names: list[str] = field(default_factory=list)
    image_height: int = 96
    image_width: int = 96
    action: str = 'joints'
    ee_step: float = 0.01
    max_relative_target: float | None = None
    controller: str = ''
    image_topic: str = '/{camera}/color/image_raw'
    task: str = 'PickCube-v1'
    seed: int = 0


class Armsim(Robot):
    """
    A simulated arm.

    Observations are ``<joint>.pos`` [rad], ``gripper.pos`` 0..100 (100 is an open gripper or a cup
    that is on) and a picture per camera; actions are the same without pictures.
    """

    config_class = ArmsimConfig
    name = 'armsim'
    #: The robot with a task of its own that connected last, for the expert.
    connected: 'Armsim | None' = None

    def __init__(self, config: ArmsimConfig) -> None:
        super().__init__(config)
        for what, value, allowed in (
                ('transport', config.transport, ('ros', 'local')),
                ('action', config.action, ('joints', 'ee_delta')), ('task', config.task, TASKS)):
            if value not in allowed:
                raise ValueError(f"{what} '{value}'; allowed: {', '.join(allowed)}")
        self.config = config
        self._arm: Any = None

    @cached_property
    def _joints(self) -> tuple[str, ...]:
        cell = load_cell(self.config.robot)
        return HandModel.of(cell).arm_joints(cell.model)

    @property
    def action_features(self) -> dict[str, type]:
        """Names of what ``send_action`` takes."""
        if self.config.action == 'ee_delta':
            return dict.fromkeys(DELTA, float)
        return self._state_features

    @property
    def _state_features(self) -> dict[str, type]:
        return {**{f'{joint}.pos': float for joint in self._joints}, GRIPPER: float}

    @property
    def observation_features(self) -> dict[str, Any]:
        """Names of what is observed, and shapes of pictures."""
        shape = (self.config.image_height, self.config.image_width, 3)
        return {**self._state_features, **dict.fromkeys(self.config.camera_names, shape)}

    @property
    def cameras(self) -> dict[str, Any]:
        """The cameras by name; they are read with the observation."""
        return dict.fromkeys(self.config.camera_names)

    @property
    def is_connected(self) -> bool:
        """Whether the arm is there."""
        return self._arm is not None

    @property
    def is_calibrated(self) -> bool:
        """Whether it is calibrated: always."""
        return True

    @property
    def task(self) -> TaskEnv:
        """The running task; only of the transport ``local``."""
        if not isinstance(self._connected, LocalArm):
            raise DeviceNotConnectedError(
                f'{self} has no task in this process: --robot.transport=local')
        return self._connected.env

    @property
    def _connected(self) -> Any:
        if self._arm is None:
            raise DeviceNotConnectedError(f'{self} is not connected; call connect() first')
        return self._arm

    def connect(self, calibrate: bool = True) -> None:
        """Take the running arm over, or start the simulation with its first episode."""
        if self._arm is not None:
            raise DeviceAlreadyConnectedError(f'{self} is connected already')
        if self.config.transport == 'local':
            self._arm = LocalArm(self.config)
            Armsim.connected = self
        else:
            from lerobot_robot_armsim.ros_arm import RosArm

            self._arm = RosArm(self.config)

    def calibrate(self) -> None:
        """Do nothing: the joints are where they are."""

    def configure(self) -> None:
        """Do nothing: there are no settings on a device."""

    def get_observation(self) -> dict[str, Any]:
        """Return where the joints are, and what the cameras see."""
        arm = self._connected
        now = arm.positions
        observed: dict[str, Any] = {f'{joint}.pos': now[joint] for joint in self._joints}
        observed[GRIPPER] = 100.0 * arm.level
        return {**observed, **arm.pictures()}

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Move for a step; return what was commanded within the limits."""
        arm = self._connected
        if self.config.action == 'ee_delta':
            return self._move_tip(arm, action)
        goals = {joint: float(action[f'{joint}.pos']) for joint in self._joints}
        if self.config.max_relative_target is not None:
            now = arm.positions
            goals = ensure_safe_goal_position(
                {joint: (goal, now[joint]) for joint, goal in goals.items()},
                self.config.max_relative_target)
        level = min(1.0, max(0.0, float(action[GRIPPER]) / 100.0))
        sent = arm.send(goals, level)
        return {**{f'{joint}.pos': sent[joint] for joint in self._joints}, GRIPPER: 100.0 * level}

    def _move_tip(self, arm: Any, action: dict[str, Any]) -> dict[str, Any]:
        """Move the tip by what is given within -1..1; return that."""
        sent = {name: min(1.0, max(-1.0, float(action.get(name, 0.0)))) for name in DELTA[:3]}
        gripper = int(action.get('gripper', 1))
        arm.move_tip([self.config.ee_step * value for value in sent.values()],
                     float(gripper == _OPEN) if gripper in (_CLOSE, _OPEN) else None)
        return {**sent, 'gripper': gripper}

    def disconnect(self) -> None:
        """Let the arm hold, or end the simulation."""
        self._connected.close()
        self._arm = None
        if Armsim.connected is self:
            Armsim.connected = None
