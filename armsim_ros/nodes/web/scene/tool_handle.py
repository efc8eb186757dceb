# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The handle at the tool: arrows and arcs that the user drags."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.model.transforms import (
    matrix_from_quat_wxyz,
    pose_from_parts,
    quat_wxyz_from_matrix,
)

#: Of its arrows [m].
_SIZE = 0.16


class ToolHandle:
    """
    Draws a handle in a session's scene.

    :param scene: of the session.
    :param pulled: gets the handle's pose in the robot's root link, (4, 4), when it is pulled.
    """

    def __init__(self, scene: Any, pulled: Callable[[Matrix], Awaitable[None]]) -> None:
        self._base = scene.add_frame('/goal', show_axes=False)
        handle = self._handle = scene.add_transform_controls(
            '/goal/handle', scale=_SIZE, line_width=3.0, depth_test=False, disable_sliders=True)

        async def moved(_event: Any) -> None:
            await pulled(pose_from_parts(
                np.asarray(handle.position), matrix_from_quat_wxyz(handle.wxyz)))

        handle.on_update(moved)

    def place(self, xyz: Matrix, wxyz: Matrix) -> None:
        """Put the robot's root link somewhere; (3,) [m] and (4,)."""
        self._base.position, self._base.wxyz = xyz, wxyz

    def put(self, pose: Matrix) -> None:
        """Put the handle somewhere in the robot's root link; (4, 4)."""
        self._handle.position = pose[:3, 3]
        self._handle.wxyz = quat_wxyz_from_matrix(pose)

    def remove(self) -> None:
        """Take it out of the scene."""
        self._base.remove()
