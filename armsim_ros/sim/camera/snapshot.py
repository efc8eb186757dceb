# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The state of the plant that a picture shows, as bytes."""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

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
