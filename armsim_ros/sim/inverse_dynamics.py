# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The torques that move the robot alone along a reference."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.sim.mujoco_model import PlantSpec

Vector = NDArray[np.float64]

#: Below this velocity dry friction is fed forward in part [rad/s or m/s].
FRICTION_VELOCITY = 0.01


class InverseDynamics:
    """
    Discrete-time inverse dynamics of the robot without its world.

    Gravity, inertia, Coriolis, rotor inertia, damping and dry friction; mimic joints load the
    joint that they follow.

    :param model: the robot.
    :param settings: gravity, timestep, rotor inertia.
    """

    def __init__(self, model: RobotModel, settings: SimulationSettings) -> None:
        """Compile the robot alone."""
        self._model = PlantSpec(model, settings, contacts=False).compile()
        self._data = mujoco.MjData(self._model)
        plant_order = [self._model.joint(i).name for i in range(self._model.njnt)]
        prefix = f'{model.name}/'
        # All joints have one degree of freedom: position, velocity and joint numbers agree.
        self._joints = np.array(
            [plant_order.index(prefix + name) for name in model.movable_joints], dtype=np.intp
        )
        self._expand, self._offset = _mimic_map(model)
        scatter = np.zeros((self._model.nv, len(model.movable_joints)))
        scatter[self._joints, np.arange(len(self._joints))] = 1.0
        self._from_active = scatter @ self._expand
        self._to_active = np.ascontiguousarray(self._from_active.T)
        self._full_offset = scatter @ self._offset
        self._squares = np.ascontiguousarray(self._to_active**2)
        rows, lengths = self._model.M_rowadr, self._model.M_rownnz
        self._diagonal = (rows + lengths - 1).astype(np.intp)
        self._step_damping = self._model.dof_damping * self._model.opt.timestep
        friction = self._model.dof_frictionloss.copy()
        self._friction = friction if friction.any() else None
        self._qpos, self._qvel = self._data.qpos, self._data.qvel
        self._qacc, self._force = self._data.qacc, self._data.qfrc_inverse
        self._inertia = self._data.M

    def torques(self, position: Vector, velocity: Vector, acceleration: Vector) -> Vector:
        """
        Return the torques that take the reference to ``velocity + h*acceleration`` in one step.

        :param position: (n,) of the active joints at the start of the step [rad or m].
        :param velocity: (n,) at the start of the step [rad/s or m/s].
        :param acceleration: (n,) change of velocity in the step by its time [rad/s^2 or m/s^2].
        :returns: (n,) [N*m or N].
        """
        np.matmul(self._from_active, position, out=self._qpos)
        self._qpos += self._full_offset
        np.matmul(self._from_active, velocity, out=self._qvel)
        np.matmul(self._from_active, acceleration, out=self._qacc)
        mujoco.mj_inverse(self._model, self._data)
        # The integrator takes damping at the end of the step, mj_inverse at its start.
        force = self._force + self._step_damping * self._qacc
        if self._friction is not None:
            force += self._friction * np.tanh(self._qvel / FRICTION_VELOCITY)
        torques: Vector = self._to_active @ force
        return torques

    def joint_inertias(self) -> Vector:
        """Return each joint's own inertia at the last reference (n,) [kg*m^2 or kg]."""
        inertias: Vector = self._squares @ self._inertia[self._diagonal]
        return inertias

    def expand(self, values: Vector) -> Vector:
        """Return positions of all movable joints from those of the active ones."""
        return self._expand @ values + self._offset


def _mimic_map(model: RobotModel) -> tuple[Vector, Vector]:
    """Return S, c with q(all movable) = S q(active) + c."""
    names, active = model.movable_joints, model.active_joints
    zero = model.complete(dict.fromkeys(active, 0.0))
    offset = np.array([zero[name] for name in names], dtype=np.float64)
    expand = np.zeros((len(names), len(active)))
    for column, driver in enumerate(active):
        one = model.complete({**dict.fromkeys(active, 0.0), driver: 1.0})
        expand[:, column] = np.array([one[name] for name in names]) - offset
    return expand, offset
