# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Observations of tasks, in the kinds that LeRobot's own environments have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from gymnasium.spaces import Box, Dict, Space
import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import selector, Vector
from armsim_ros.env.actions import Actions
from armsim_ros.tasks.hand import HandModel

ObsType = Literal['state', 'environment_state_agent_pos', 'pixels', 'pixels_agent_pos']
OBS_TYPES: tuple[ObsType, ...] = (
    'state', 'environment_state_agent_pos', 'pixels', 'pixels_agent_pos')
#: Bounds of what has no limits of its own: positions [m], joint velocities [rad/s or m/s].
_FAR, _FAST = 10.0, 100.0
_POSE = ('x', 'y', 'z', 'qx', 'qy', 'qz', 'qw')


class TaskObservations:
    """
    Composes observations.

    ``agent_pos`` is the positions of the arm's joints and, last, 1 for an open gripper or a cup
    that is on. ``environment_state`` is the poses of tip and objects, and the target's position.
    ``state`` is both, with the joints' velocities between them.

    :param kind: what an observation is.
    :param actions: with the limits of the joints.
    :param joints: all joints with drives.
    :param hand: what grasps.
    :param objects: the objects that can move.
    :param target: whether there is a target.
    :param cameras: whose pictures are observed.
    :param size: height and width of these [pixels].
    """

    def __init__(
        self, kind: ObsType, actions: Actions, joints: tuple[str, ...], hand: HandModel,
        objects: tuple[str, ...], target: bool, cameras: tuple[str, ...], size: tuple[int, int],
    ) -> None:
        self._kind = kind
        self.pictures = kind.startswith('pixels')
        arm = [i for i, name in enumerate(joints) if name != hand.joint]
        self._arm = selector(arm)
        self.state_names = (*(joints[i] for i in arm), 'gripper')
        items = ('tip', *objects)
        self.environment_names = (*(f'{name}.{part}' for name in items for part in _POSE),
                                  *((f'target.{part}' for part in 'xyz') if target else ()))
        agent = (np.append(actions.lower[arm] - 1.0, 0.0),
                 np.append(actions.upper[arm] + 1.0, 1.0))
        speed = np.full(len(arm), _FAST)
        pose = [*[_FAR] * 3, *[1.0] * 4]
        bound = np.array([*pose * len(items), *([_FAR] * 3 if target else [])])
        self._agent = agent[0].astype(np.float32), agent[1].astype(np.float32)
        self._bound = bound.astype(np.float32)
        self._low = np.concatenate((agent[0], -speed, -bound)).astype(np.float32)
        self._high = np.concatenate((agent[1], speed, bound)).astype(np.float32)
        picture: dict[str, Space[Any]] = {
            name: Box(0, 255, (*size, 3), np.uint8) for name in cameras}
        parts: dict[str, Space[Any]] = {
            'pixels': Dict(picture), 'agent_pos': Box(
                self._agent[0], self._agent[1], dtype=np.float32),
            'environment_state': Box(-self._bound, self._bound, dtype=np.float32)}
        self.space: Space[Any] = {
            'state': Box(self._low, self._high, dtype=np.float32),
            'environment_state_agent_pos': Dict(
                {name: parts[name] for name in ('agent_pos', 'environment_state')}),
            'pixels': Dict({'pixels': parts['pixels']}),
            'pixels_agent_pos': Dict({name: parts[name] for name in ('pixels', 'agent_pos')}),
        }[kind]

    def agent_pos(self, now: Mapping[str, Vector], level: float) -> NDArray[np.float32]:
        """Return ``agent_pos`` of an observation of ``ArmEnv``."""
        values = np.append(now['joint_positions'][self._arm], level).astype(np.float32)
        return np.minimum(np.maximum(values, self._agent[0]), self._agent[1])

    def environment_state(
        self, now: Mapping[str, Vector], target: Vector | None
    ) -> NDArray[np.float32]:
        """Return ``environment_state`` of an observation of ``ArmEnv``."""
        parts = [now['tip_pose']]
        if 'object_poses' in now:
            parts.append(now['object_poses'])
        if target is not None:
            parts.append(target)
        values = np.concatenate(parts).astype(np.float32)
        return np.minimum(np.maximum(values, -self._bound), self._bound)

    def compose(
        self, now: Mapping[str, Vector], level: float, target: Vector | None,
        pictures: dict[str, NDArray[np.uint8]] | None,
    ) -> Any:
        """
        Return an observation.

        :param now: an observation of ``ArmEnv``.
        :param level: of the gripper or cup.
        :param target: (3,) where it is [m], None without one.
        :param pictures: camera -> (h, w, 3), where they are observed.
        """
        if self._kind == 'state':
            parts = [now['joint_positions'][self._arm], (level,),
                     now['joint_velocities'][self._arm], now['tip_pose']]
            if 'object_poses' in now:
                parts.append(now['object_poses'])
            if target is not None:
                parts.append(target)
            values = np.concatenate(parts, dtype=np.float32, casting='same_kind')
            np.maximum(values, self._low, out=values)
            return np.minimum(values, self._high, out=values)
        if self._kind == 'pixels':
            return {'pixels': pictures}
        agent = self.agent_pos(now, level)
        if self._kind == 'pixels_agent_pos':
            return {'pixels': pictures, 'agent_pos': agent}
        return {'agent_pos': agent, 'environment_state': self.environment_state(now, target)}
