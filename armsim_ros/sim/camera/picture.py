# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a camera gives: colour, depth, points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsim_ros.sim.camera.camera import Camera

Depths = NDArray[np.float32]


class Picture(NamedTuple):
    """
    Colour and depth of a moment.

    :param colour: (h, w, 3) red, green, blue.
    :param depth: (h, w) along the camera's axis [m]; +inf where nothing is within the range, -inf
        where something is nearer than it (REP 118).
    """

    colour: NDArray[np.uint8]
    depth: Depths


def measured(depth: Depths, limits: tuple[float, float]) -> Depths:
    """Return depths [m] with what lies beyond the range (nearest, farthest) [m] as infinite."""
    nearest, farthest = limits
    depth = np.where(depth > farthest, np.float32(np.inf), depth)
    return np.where(depth < nearest, np.float32(-np.inf), depth)


def points(picture: Picture, camera: Camera) -> NDArray[np.float32]:
    """
    Return the points that the pixels show.

    :returns: (h, w, 4) x, y, z in the optical frame [m], NaN where no depth is, and the colour
        as PCL has it: three bytes in a float.
    """
    depth = np.where(np.isfinite(picture.depth), picture.depth, np.float32(np.nan))
    centre_u, centre_v = camera.centre
    columns = (np.arange(camera.width, dtype=np.float32) - centre_u) / camera.focal
    lines = (np.arange(camera.height, dtype=np.float32) - centre_v) / camera.focal
    found = np.empty((*depth.shape, 4), np.float32)
    found[..., 0] = depth * columns.astype(np.float32)
    found[..., 1] = depth * lines.astype(np.float32)[:, None]
    found[..., 2] = depth
    packed = picture.colour.astype(np.uint32) @ np.array([1 << 16, 1 << 8, 1], np.uint32)
    found[..., 3] = packed.view(np.float32)
    return found
