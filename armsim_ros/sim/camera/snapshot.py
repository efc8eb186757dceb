# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a camera draws from, the state of the plant as bytes, and the picture it makes."""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

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


_HEAD = struct.Struct('<Hq')


class Snapshot(NamedTuple):
    """
    The poses of all bodies at a time.

    :param camera: number of the camera that is to show it.
    :param time_ns: simulated time [ns].
    :param places: positions of all joints, then of all bodies in their parents, then quaternions
        of these: fixed objects can be moved, too.
    """

    camera: int
    time_ns: int
    places: bytes

    def to_bytes(self) -> bytes:
        """Return it as a message."""
        return _HEAD.pack(self.camera, self.time_ns) + self.places

    @staticmethod
    def from_bytes(message: bytes) -> Snapshot:
        """Return the snapshot of a message."""
        camera, time_ns = _HEAD.unpack_from(message)
        return Snapshot(camera, time_ns, message[_HEAD.size :])


def take_snapshot(camera: int, time_ns: int, model: Any, data: Any) -> Snapshot:
    """Return the present state of an ``MjModel`` and its ``MjData``."""
    return Snapshot(camera, time_ns, b''.join(
        (data.qpos.tobytes(), model.body_pos.tobytes(), model.body_quat.tobytes())))
