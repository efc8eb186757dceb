# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The occupied cells of an octomap in the scene, coloured by their height."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Vector
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import quat_wxyz_from_matrix
from armsim_ros.nodes.web.view.shapes import ShapeReader
from armsim_ros.planning.scene.octomap import Octomap

#: Colours from the lowest cell to the highest.
_COLORS = np.array([(68, 1, 84), (49, 104, 142), (53, 183, 121), (253, 231, 37)], dtype=float)


class OctomapDrawing:
    """
    Boxes, one per occupied leaf of the tree, drawn as instances of a single mesh.

    :param scene: of all sessions.
    """

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self._node: Any = None
        self._box, = ShapeReader().parts(Box((1.0, 1.0, 1.0)))

    def show(self, octomap: Octomap | None, node: str) -> int:
        """
        Draw a map and no other; return the number of boxes.

        :param node: path of the frame of the map's pose.
        """
        if self._node is not None:
            self._node.remove()
            self._node = None
        if octomap is None:
            return 0
        centres, edges = octomap.boxes
        if len(edges):
            turns = np.zeros((len(edges), 4), dtype=np.float32)
            turns[:, 0] = 1.0
            heights: Vector = centres @ octomap.pose[2, :3]
            self._node = self._scene.add_batched_meshes_simple(
                f'{node}/octomap', self._box.vertices, self._box.faces, turns,
                centres.astype(np.float32), batched_scales=edges.astype(np.float32),
                batched_colors=height_colors(heights), flat_shading=True, cast_shadow=False,
                receive_shadow=False, lod='off', position=octomap.pose[:3, 3],
                wxyz=quat_wxyz_from_matrix(octomap.pose))
        return len(edges)


def height_colors(heights: Vector) -> NDArray[np.uint8]:
    """Return colours (k, 3) of heights (k,) [m] between the lowest and the highest."""
    low, high = heights.min(), heights.max()
    share = (heights - low) / max(high - low, 1e-9) * (len(_COLORS) - 1)
    places = np.arange(len(_COLORS))
    return np.stack(
        [np.interp(share, places, channel) for channel in _COLORS.T], axis=-1).astype(np.uint8)
