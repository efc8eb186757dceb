# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tasks as an environment of LeRobot, for lerobot-eval and lerobot-train."""

from dataclasses import dataclass, field
from typing import Any

from lerobot.configs import FeatureType, PolicyFeature
from lerobot.envs.configs import EnvConfig
from lerobot.utils.constants import ACTION, OBS_ENV_STATE, OBS_IMAGES, OBS_STATE

from armsim_ros.tasks import TASKS


@EnvConfig.register_subclass('armsim')
@dataclass
class ArmsimEnvConfig(EnvConfig):
    """
    A task of armsim_ros.

    Its features have the names and shapes of a data set that ``armsim collect`` has written with
    the same arguments.

    :param task: part of the id after ``armsim/``.
    :param fps: steps per second.
    :param robot: its name or folder.
    :param action: what an action is: ``position``, ``velocity`` or ``twist``.
    :param obs_type: what is observed; with ``state`` there is no feature for a policy.
    :param cameras: whose pictures are observed.
    :param observation_height: of these [pixels].
    :param observation_width: of these [pixels].
    :param randomize: ``default`` or ``none``.
    :param episode_length: steps after which an episode ends; 0 for those of the task.
    """

    task: str | None = 'PickCube-v1'
    fps: int = 20
    robot: str = 'sunday'
    action: str = 'position'
    obs_type: str = 'pixels_agent_pos'
    cameras: list[str] = field(default_factory=lambda: ['front'])
    observation_height: int = 96
    observation_width: int = 96
    randomize: str = 'default'
    episode_length: int = 0
    render_mode: str = 'rgb_array'

    def __post_init__(self) -> None:
        """Fill in the features of the task."""
        if self.task not in TASKS:
            raise ValueError(f"there is no task '{self.task}'; allowed: {', '.join(TASKS)}")
        arguments = {name: value for name, value in self.gym_kwargs.items()
                     if name != 'max_episode_steps'}
        env: Any = TASKS[self.task](**arguments)
        space, action = env.observation_space, env.action_space
        env.close()
        parts = getattr(space, 'spaces', {})
        self.features = {ACTION: PolicyFeature(FeatureType.ACTION, action.shape)}
        self.features_map = {ACTION: ACTION}
        for name, kind, policy_name in (('agent_pos', FeatureType.STATE, OBS_STATE),
                                        ('environment_state', FeatureType.ENV, OBS_ENV_STATE)):
            if name in parts:
                self.features[name] = PolicyFeature(kind, parts[name].shape)
                self.features_map[name] = policy_name
        for camera, picture in getattr(parts.get('pixels'), 'spaces', {}).items():
            self.features[f'pixels/{camera}'] = PolicyFeature(FeatureType.VISUAL, picture.shape)
            self.features_map[f'pixels/{camera}'] = f'{OBS_IMAGES}.{camera}'

    @property
    def package_name(self) -> str:
        """The module that registers the tasks."""
        return 'armsim_ros.tasks'

    @property
    def gym_id(self) -> str:
        """The task's id."""
        return f'armsim/{self.task}'

    @property
    def gym_kwargs(self) -> dict[str, Any]:
        """The task's arguments."""
        arguments: dict[str, Any] = {
            'robot': self.robot, 'action': self.action, 'obs_type': self.obs_type,
            'cameras': tuple(self.cameras), 'period': 1.0 / self.fps,
            'image_size': (self.observation_height, self.observation_width),
            'randomize': self.randomize, 'render_mode': self.render_mode}
        if self.episode_length:
            arguments['max_episode_steps'] = self.episode_length
        return arguments
