# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated arm in this process as a robot of LeRobot."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from lerobot.robots import Robot, RobotConfig
from lerobot.robots.utils import ensure_safe_goal_position
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError

from armsim_ros.tasks import TaskEnv, TASKS

GRIPPER = 'gripper.pos'
#: What the teleoperators ``gamepad`` and ``keyboard_ee`` send; a gripper of 1 stays.
DELTA = ('delta_x', 'delta_y', 'delta_z', 'gripper')
_CLOSE, _OPEN = 0, 2


@RobotConfig.register_subclass('armsim')
@dataclass(kw_only=True)
class ArmsimConfig(RobotConfig):
    """
    A simulated arm, stepped by ``send_action``.

    :param task: part of the id after ``armsim/``; its world is the robot's.
    :param robot: the arm's name or folder.
    :param fps: steps per second.
    :param camera_names: whose pictures are observed.
    :param image_height: of these [pixels].
    :param image_width: of these [pixels].
    :param seed: of the first episode; the next has the next seed.
    :param action: ``joints``, or ``ee_delta``: ways of the tip along the world's axes, -1..1.
    :param ee_step: way of the tip in a step for a delta of 1 [m].
    :param max_relative_target: farthest way of a joint in a step [rad], None for the joint's
        velocity limit.
    """

    task: str = 'PickCube-v1'
    robot: str = 'sunday'
    fps: int = 20
    camera_names: list[str] = field(default_factory=lambda: ['front'])
    image_height: int = 96
    image_width: int = 96
    seed: int = 0
    action: str = 'joints'
    ee_step: float = 0.01
    max_relative_target: float | None = None


class Armsim(Robot):
    """
    The arm of a task.

    Observations are ``<joint>.pos`` [rad], ``gripper.pos`` 0..100 (100 is an open gripper or a cup
    that is on) and a picture per camera; actions are the same without pictures. A task that is
    done begins the next episode with the next action.
    """

    config_class = ArmsimConfig
    name = 'armsim'
    #: The task of the robot that connected last, for the expert.
    connected: 'Armsim | None' = None

    def __init__(self, config: ArmsimConfig) -> None:
        super().__init__(config)
        if config.task not in TASKS:
            raise ValueError(f"there is no task '{config.task}'; allowed: {', '.join(TASKS)}")
        if config.action not in ('joints', 'ee_delta'):
            raise ValueError(f"action '{config.action}'; allowed: joints, ee_delta")
        self.config = config
        self._level = 0.0
        self._env: TaskEnv | None = None
        self._episode = 0

    @cached_property
    def _joints(self) -> tuple[str, ...]:
        if self._env is not None:
            return self._env.state_names[:-1]
        env = self._made()
        env.close()
        return env.state_names[:-1]

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
        """Whether the simulation runs."""
        return self._env is not None

    @property
    def is_calibrated(self) -> bool:
        """Whether it is calibrated: always."""
        return True

    @property
    def task(self) -> TaskEnv:
        """The running task."""
        if self._env is None:
            raise DeviceNotConnectedError(f'{self} is not connected; call connect() first')
        return self._env

    def connect(self, calibrate: bool = True) -> None:
        """Start the simulation with its first episode."""
        if self._env is not None:
            raise DeviceAlreadyConnectedError(f'{self} is connected already')
        self._env = self._made()
        self._begin()
        Armsim.connected = self

    def calibrate(self) -> None:
        """Do nothing: the joints are where they are."""

    def configure(self) -> None:
        """Do nothing: there are no settings on a device."""

    def get_observation(self) -> dict[str, Any]:
        """Return where the joints are, and what the cameras see."""
        env = self.task
        now = env.sim.joint_positions
        observed: dict[str, Any] = {f'{joint}.pos': now[joint] for joint in self._joints}
        observed[GRIPPER] = 100.0 * env.hand.level
        return {**observed, **(env.draw_pictures() if self.config.camera_names else {})}

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Move for a step; return what was commanded within the limits."""
        env = self.task
        if env.is_success:
            self._begin()
        if self.config.action == 'ee_delta':
            return self._move_tip(env, action)
        goals = {joint: float(action[f'{joint}.pos']) for joint in self._joints}
        if self.config.max_relative_target is not None:
            now = env.sim.joint_positions
            goals = ensure_safe_goal_position(
                {joint: (goal, now[joint]) for joint, goal in goals.items()},
                self.config.max_relative_target)
        level = min(1.0, max(0.0, float(action[GRIPPER]) / 100.0))
        env.step(env.command_of(goals, level))
        commanded = env.commanded
        sent = {f'{joint}.pos': commanded[joint] for joint in self._joints}
        return {**sent, GRIPPER: 100.0 * level}

    def _move_tip(self, env: TaskEnv, action: dict[str, Any]) -> dict[str, Any]:
        """Move the tip by what is given within -1..1; return that."""
        sent = {name: min(1.0, max(-1.0, float(action.get(name, 0.0)))) for name in DELTA[:3]}
        gripper = int(action.get('gripper', 1))
        if gripper in (_CLOSE, _OPEN):
            self._level = float(gripper == _OPEN)
        way = [self.config.ee_step * value for value in sent.values()]
        env.step(env.command_by(way, self._level))
        return {**sent, 'gripper': gripper}

    def disconnect(self) -> None:
        """End the simulation."""
        self.task.close()
        self._env = None
        if Armsim.connected is self:
            Armsim.connected = None

    def _made(self) -> TaskEnv:
        config = self.config
        return TASKS[config.task](
            config.robot, period=1.0 / config.fps, cameras=tuple(config.camera_names),
            image_size=(config.image_height, config.image_width))

    def _begin(self) -> None:
        self.task.reset(seed=self.config.seed + self._episode)
        self._level = self.task.hand.level
        self._episode += 1


