# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arm of a task in this process, stepped by its actions."""

from collections.abc import Mapping, Sequence
from typing import Any

from armsim_ros.tasks import TaskEnv, TASKS


class LocalArm:
    """
    Runs the episodes of a task.

    A task that is done begins the next episode with the next action.

    :param config: an ``ArmsimConfig``.
    """

    def __init__(self, config: Any) -> None:
        self.env: TaskEnv = TASKS[config.task](
            config.robot, period=1.0 / config.fps, cameras=tuple(config.camera_names),
            image_size=(config.image_height, config.image_width))
        self._seed, self._cameras = config.seed, bool(config.camera_names)
        self._begin()

    @property
    def positions(self) -> dict[str, float]:
        """Joint -> position [rad or m]."""
        return self.env.sim.joint_positions

    @property
    def level(self) -> float:
        """1 for an open gripper or a cup that is on."""
        return self.env.hand.level

    def pictures(self) -> dict[str, Any]:
        """Return camera -> picture (h, w, 3)."""
        return self.env.draw_pictures() if self._cameras else {}

    def send(self, goals: Mapping[str, float], level: float) -> dict[str, float]:
        """Move for a step; return what the joints were commanded within the limits."""
        self._begin_if_done()
        self.env.step(self.env.command_of(goals, level))
        return self.env.commanded

    def move_tip(self, way: Sequence[float], level: float | None) -> None:
        """Move the tip for a step (3,) [m]; without a level the hand stays as it is."""
        self._begin_if_done()
        self._level = self._level if level is None else level
        self.env.step(self.env.command_by(way, self._level))

    def close(self) -> None:
        """End the simulation."""
        self.env.close()

    def _begin_if_done(self) -> None:
        if self.env.is_success:
            self._begin()

    def _begin(self) -> None:
        self.env.reset(seed=self._seed)
        self._seed += 1
        self._level = self.env.hand.level
