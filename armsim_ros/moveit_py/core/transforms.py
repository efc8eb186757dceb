# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The frames of a planning scene."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.planning.scene.planning_scene import PlanningScene


class Transforms:
    """
    A snapshot of frames and their poses in a target frame.

    :param target_frame: the frame of all poses.
    """

    def __init__(self, target_frame: str) -> None:
        self._target, self._poses = target_frame, {target_frame: np.eye(4)}

    @classmethod
    def _of(cls, scene: PlanningScene) -> Transforms:
        made = cls(scene.model_frame)
        made._poses.update({name: scene.frame_pose(name) for name in scene.content.frames
                            if scene.has_frame(name)})
        return made

    def get_target_frame(self) -> str:
        """Return the frame of all poses."""
        return self._target

    def get_transform(self, from_frame: str) -> Matrix:
        """
        Return the pose (4, 4) of a frame.

        :raises KeyError: it is not known; the text lists those that are.
        """
        if from_frame not in self._poses:
            raise KeyError(f"frame '{from_frame}' is not known; known: {', '.join(self._poses)}")
        return self._poses[from_frame]

    def get_all_transforms(self) -> Mapping[str, Matrix]:
        """Return frame -> pose (4, 4)."""
        return dict(self._poses)
