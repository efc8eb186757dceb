# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A copy of the plant that snapshots put where they were taken."""

from __future__ import annotations

import mujoco
import numpy as np

from armsim_ros.sim.camera.snapshot import Snapshot
from armsim_ros.sim.physics.compiler import model_from_bytes


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
