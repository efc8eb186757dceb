# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Runs episodes of a task and records them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module, metadata
import os
from pathlib import Path
import sys
from typing import Any

import gymnasium
import numpy as np

from armsim_ros.data.dataset import EpisodeData
from armsim_ros.data.features import (
    ACTION,
    DONE,
    frames_of,
    IMAGES,
    picture_stats,
    REWARD,
    SUCCESS,
)
from armsim_ros.data.video import encoded
from armsim_ros.env.ranges import stream
from armsim_ros.errors import ArmsimError, ConfigError, nearest, Problem
from armsim_ros.resources import own_version
from armsim_ros.tasks import TASKS
from armsim_ros.tasks.base import TaskEnv

Policy = Callable[[Any], Any]
EXPERT, RANDOM = 'expert', 'random'


@dataclass(frozen=True)
class Source:
    """
    Where episodes come from.

    :param env_id: such as ``armsim/PickCube-v1``.
    :param arguments: those of the task.
    :param policy: ``expert``, ``random`` or ``MODULE:CALLABLE``, which gets an observation and
        returns an action. Before each episode its attribute ``task_description`` is set to that
        of the task and its ``reset`` is called, where it has these. Or the folder
        ``pretrained_model`` of a policy that LeRobot has trained, which brings the arguments
        that it needs.
    """

    env_id: str
    arguments: Mapping[str, Any] = field(default_factory=dict)
    policy: str = EXPERT


class PolicyError(ArmsimError):
    """The user's policy failed."""


class EpisodeRunner:
    """
    An environment that runs one episode after the other.

    :param source: where episodes come from.
    :param policy: in place of that of the source; an episode ends where it returns None.
    :raises ConfigError: an unknown id, or a policy that cannot be imported.
    """

    def __init__(self, source: Source, policy: Policy | None = None) -> None:
        self._policy: Any = policy
        if policy is None and source.policy not in (EXPERT, RANDOM):
            self._policy = imported(source.policy)
        suited: Mapping[str, Any] = getattr(self._policy, 'arguments', {})
        self.source = replace(source, arguments={**suited, **source.arguments})
        self.env = made(self.source)
        self.task: TaskEnv = self.env.unwrapped  # type: ignore[assignment]
        #: Where the joints were when the last episode began (n,) [rad or m].
        self.start = self.task.sim.simulation.state.position

    def run(self, seed: int) -> EpisodeData:
        """
        Return the episode of a seed; it depends on nothing else.

        :raises PolicyError: the policy failed.
        """
        columns: dict[str, list[Any]] = {}
        pictures: dict[str, list[Any]] = {}
        info: dict[str, Any] = {}
        for observation, action, reward, info in self.steps(seed):
            frame = {**frames_of(observation), ACTION: action, REWARD: reward,
                     DONE: info['ended'], SUCCESS: info['is_success']}
            for name, value in frame.items():
                (pictures if name.startswith(IMAGES) else columns).setdefault(
                    name, []).append(value)
        columns[DONE][-1] = True
        fps = round(1.0 / self.task.period)
        facts = {'seed': seed, 'randomization': info['randomization'],
                 'digest': self.task.digest(), 'success': bool(info['is_success'])}
        kinds = {REWARD: np.float32, DONE: np.bool_, SUCCESS: np.bool_}
        return EpisodeData(
            {name: np.array(values, dtype=kinds.get(name, np.float32))
             for name, values in columns.items()},
            {name: encoded(values, fps) for name, values in pictures.items()},
            {name: picture_stats(values) for name, values in pictures.items()},
            self.task.task_description, facts)

    def steps(self, seed: int) -> Iterator[tuple[Any, Any, float, dict[str, Any]]]:
        """
        Yield the steps of the episode of a seed: observation, action, and what they led to.

        :returns: the reward and info, which has also ``ended`` and the episode's
            ``randomization``.
        :raises PolicyError: the policy failed.
        """
        observation, begin = self.env.reset(seed=seed)
        self.start = self.task.sim.simulation.state.position.copy()
        policy, ended = self._policy_of(seed), False
        while not ended:
            action = self._clipped(policy, observation)
            if action is None:
                return
            after, reward, terminated, truncated, info = self.env.step(action)
            ended = terminated or truncated
            yield observation, action, float(reward), {
                **info, 'ended': ended, 'randomization': begin['randomization']}
            observation = after

    def close(self) -> None:
        """Give back what the environment holds."""
        self.env.close()

    def _policy_of(self, seed: int) -> Policy:
        if self._policy is not None:
            policy: Policy = self._policy
            if hasattr(self._policy, 'task_description'):
                self._policy.task_description = self.task.task_description
            getattr(self._policy, 'reset', lambda: None)()
            return policy
        if self.source.policy == EXPERT:
            return lambda observation: self.task.expert()
        random, space = stream(seed, 'policy'), self.task.action_space
        return lambda observation: random.uniform(space.low, space.high)

    def _clipped(self, policy: Policy, observation: Any) -> Any:
        space = self.task.action_space
        try:
            chosen = policy(observation)
            if chosen is None:
                return None
            action = np.asarray(chosen, dtype=np.float32)
            return np.clip(self.task.checked_action(action), space.low, space.high).astype(
                np.float32)
        except ArmsimError:
            raise
        except Exception as error:
            raise PolicyError(f"the policy '{self.source.policy}' failed: "
                              f'{type(error).__name__}: {error}') from error


def made(source: Source) -> gymnasium.Env[Any, Any]:
    """
    Return the environment of a source.

    :raises ConfigError: an unknown id.
    """
    name = source.env_id.partition(':')[2] or source.env_id
    name = name.removeprefix('armsim/')
    if name not in TASKS:
        raise ConfigError(Problem(
            f"there is no task '{source.env_id}'", allowed=', '.join(f'armsim/{k}' for k in TASKS),
            remedy=nearest(name, tuple(TASKS))))
    return gymnasium.make(f'armsim/{name}', disable_env_checker=True, **source.arguments)


def versions() -> dict[str, str]:
    """Return the versions on which the bytes of an episode depend."""
    return {'armsim_ros': own_version(), 'mujoco': metadata.version('mujoco')}


def imported(policy: str) -> Policy:
    """
    Return the function of ``MODULE:CALLABLE``, or the policy in a folder of LeRobot's.

    :raises ConfigError: it cannot be imported.
    """
    if (Path(policy) / 'config.json').is_file():
        try:
            checkpoint: Any = import_module('lerobot_robot_armsim.checkpoint')
        except ImportError as error:
            raise ConfigError(Problem(
                f"the policy '{policy}' is LeRobot's, and '{error.name}' is not installed",
                remedy='pip install lerobot_robot_armsim')) from None
        loaded: Policy = checkpoint.Checkpoint(Path(policy))
        return loaded
    module, _, name = policy.partition(':')
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    try:
        found = getattr(import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ConfigError(Problem(
            f"the policy '{policy}' cannot be imported: {error}",
            allowed=f'{EXPERT}, {RANDOM}, MODULE:CALLABLE, or a folder with a config.json of '
                    'LeRobot')) from None
    if not callable(found):
        raise ConfigError(Problem(f"the policy '{policy}' cannot be called"))
    policy_found: Policy = found
    return policy_found
