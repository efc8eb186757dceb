# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Finds a plant that ran away, and keeps states to go back to."""

from __future__ import annotations

import logging
from typing import Any

import mujoco
import numpy as np

from armsim_ros.arrays import Vector

#: No joint of a robot moves as fast [rad/s or m/s].
VELOCITY_LIMIT = 1000.0
#: Steps between two states that are kept.
CHECKPOINT_STEPS = 200


def keep_physics_quiet() -> None:
    """Have MuJoCo's warnings logged for developers, not printed and put into MUJOCO_LOG.TXT."""
    mujoco.set_mju_user_warning(logging.getLogger('armsim_ros.sim').debug)


class Checkpoints:
    """
    Two states of the plant, so that the older is well before a fault.

    :param model: the ``MjModel``.
    :param data: its ``MjData``; its present state is the first to go back to.
    """

    def __init__(self, model: Any, data: Any) -> None:
        self._signature = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)
        size = mujoco.mj_stateSize(model, self._signature)
        self._older, self._newer = np.empty(size), np.empty(size)
        self._countdown = CHECKPOINT_STEPS
        mujoco.mj_getState(model, data, self._older, self._signature)
        self._newer[:] = self._older

    @staticmethod
    def stable(velocity: Vector) -> bool:
        """Return False where a velocity is huge or no number; quick, for each step."""
        return float(velocity.dot(velocity)) < VELOCITY_LIMIT**2

    def step(self, model: Any, data: Any, count: int = 1) -> None:
        """Count good steps; keep the state after them when it is time."""
        self._countdown -= count
        if self._countdown <= 0:
            self._countdown = CHECKPOINT_STEPS
            self._older, self._newer = self._newer, self._older
            mujoco.mj_getState(model, data, self._newer, self._signature)

    def restore(self, model: Any, data: Any) -> None:
        """Go back to the older state, at rest."""
        mujoco.mj_resetData(model, data)
        mujoco.mj_setState(model, data, self._older, self._signature)
        data.qvel[:] = 0.0


def unstable_element(
    joints: tuple[str, ...], velocities: Vector, last_velocities: Vector, model: Any, data: Any
) -> str:
    """
    Return what ran away, the fastest first; '' where nothing did.

    :param joints: the robot's joints.
    :param velocities: (n,) theirs [rad/s or m/s].
    :param last_velocities: (n,) a step before, finite.
    :param model: the ``MjModel``; its other joints are objects, which may be fast.
    :param data: its ``MjData``.
    """
    speeds = np.abs(np.where(np.isfinite(velocities), velocities, np.inf))
    order = np.lexsort((np.abs(last_velocities), speeds))
    if len(joints) and speeds[order[-1]] > VELOCITY_LIMIT:
        fastest = order[-1]
        return f"joint '{joints[fastest]}' moves at {velocities[fastest]:.3g}"
    for i in range(model.njnt):
        start = int(model.jnt_dofadr[i])
        count = 6 if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_FREE else 1
        if not np.isfinite(data.qvel[start : start + count]).all():
            return f"'{model.joint(i).name}' has no finite velocity"
    return ''
