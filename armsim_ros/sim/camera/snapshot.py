# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The state of the plant that a picture shows, as bytes, and the copy that takes it."""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

import mujoco
import numpy as np

from armsim_ros.sim.physics.compiler import model_from_bytes

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


class PlantCopy:
    """
    A plant that does not move until a snapshot is shown.

    :param content: its ``MjModel`` as bytes.
    """

    def __init__(self, content: bytes) -> None:
        self.model = model_from_bytes(content)
        # What sleeps, and what never moves, would stay where it is.
        self.model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        self.data = mujoco.MjData(self.model)
        self._place()

    def show(self, snapshot: Snapshot) -> None:
        """Put all bodies where they were."""
        model, values = self.model, np.frombuffer(snapshot.places)
        joints, bodies = model.nq, model.nq + 3 * model.nbody
        self.data.qpos[:] = values[:joints]
        model.body_pos[:] = values[joints:bodies].reshape(-1, 3)
        model.body_quat[:] = values[bodies:].reshape(-1, 4)
        self._place()

    def _place(self) -> None:
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)
