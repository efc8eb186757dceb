# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Kinematics and dynamics of some joints of a robot, as a controller computes them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import mujoco
import numpy as np

from armsim_ros.arrays import Matrix, selector, Vector
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.errors import ControllerError, nearest
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.sim.physics.mujoco_model import PlantSpec

#: Of the model alone: what rotors add is the hardware's matter.
_SETTINGS = SimulationSettings(armature=0.0, armature_linear=0.0, gravity=(0.0, 0.0, -9.81))


class Chain(Protocol):
    """Parameters that name joints, tip and base."""

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that move the tip."""

    @property
    def end_effector_frame(self) -> str:
        """The tip's link."""

    @property
    def base_frame(self) -> str:
        """Frame of poses."""


class ArmDynamics:
    """
    The joints of a controller; all others are at 0, as if they were fixed.

    The base frame is a link that none of the joints moves; gravity is along -z of the root link.

    :param joints: (n,) those that move.
    :param tip: the link whose pose and Jacobian are asked for.
    :param base: frame of poses; a name that the robot lacks is its root link.
    :raises ControllerError: a joint or link that the robot lacks, or joints that do not move it.
    """

    def __init__(self, model: RobotModel, joints: Sequence[str], tip: str, base: str) -> None:
        active = model.active_joints
        for name in joints:
            if name not in active:
                raise ControllerError(
                    f"joint '{name}' cannot be controlled; known: {', '.join(active)}"
                    f'{nearest(name, active)}')
        if tip not in model.links:
            hint = nearest(tip, tuple(model.links)) or f'known: {", ".join(model.links)}'
            raise ControllerError(f"end_effector_frame: no link '{tip}'; {hint}")
        spec = PlantSpec(model, _SETTINGS, contacts=False)
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        found = [self._model.joint(spec.name(name)) for name in joints]
        self._qpos = selector([int(joint.qposadr[0]) for joint in found])
        self._places = np.array([int(joint.dofadr[0]) for joint in found])
        self._qvel = selector(self._places.tolist())
        self._links = {name: int(self._model.body(spec.name(name)).id) for name in model.links}
        self._tip = self._links[tip]
        self._base = self._links.get(base, self._links[model.root_link])
        self._jacobian = np.zeros((6, self._model.nv))
        self._product = np.empty(self._model.nv)
        self._units = np.eye(self._model.nv)[self._places]
        self.move(np.zeros(len(joints)), np.zeros(len(joints)))
        idle = [name for name, column in zip(joints, self.jacobian().T, strict=True)
                if not column.any()]
        if idle:
            raise ControllerError(f"joint '{idle[0]}' does not move link '{tip}'")

    @classmethod
    def of_controller(cls, name: str, model: RobotModel | None, chain: Chain) -> ArmDynamics:
        """
        Return the dynamics of a controller's chain.

        :param name: of the controller.
        :raises ControllerError: a parameter is missing, or as the constructor does.
        """
        for key in ('joints', 'end_effector_frame'):
            if not getattr(chain, key):
                raise ControllerError(f"parameter '{key}' of '{name}' is missing")
        if model is None:
            raise ControllerError(f"'{name}' needs the robot's description")
        return cls(model, chain.joints, chain.end_effector_frame, chain.base_frame)

    def move(self, positions: Vector, velocities: Vector) -> None:
        """Be at positions (n,) [rad or m] with velocities (n,) [rad/s or m/s]."""
        data = self._data
        data.qpos[self._qpos], data.qvel[self._qvel] = positions, velocities
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_comPos(self._model, data)

    @property
    def pose(self) -> Matrix:
        """The tip in the base frame (4, 4)."""
        return self.frame('')

    def frame(self, link: str) -> Matrix:
        """Return a link, '' is the tip, in the base frame (4, 4)."""
        body = self._links[link] if link else self._tip
        data = self._data
        turn, origin = data.xmat[self._base].reshape(3, 3).T, data.xpos[self._base]
        pose = np.eye(4)
        pose[:3, :3] = turn @ data.xmat[body].reshape(3, 3)
        pose[:3, 3] = turn @ (data.xpos[body] - origin)
        return pose

    def weight(self, link: str) -> Vector:
        """
        Return force and torque of the weight of a link and all beyond it (6,) [N, N*m].

        Torques are about the link's origin; all is in the axes of the link.
        """
        data, body = self._data, self._links[link]
        axes = data.xmat[body].reshape(3, 3)
        force = float(self._model.body_subtreemass[body]) * self._model.opt.gravity
        lever = data.subtree_com[body] - data.xpos[body]
        return np.concatenate((axes.T @ force, axes.T @ np.cross(lever, force)))

    def has(self, link: str) -> bool:
        """Return whether the robot has a link."""
        return link in self._links

    def jacobian(self, link: str = '') -> Matrix:
        """
        Return how a link moves with the joints (6, n): linear above angular, base axes.

        :param link: '' is the tip.
        """
        found, body = self._jacobian, self._links[link] if link else self._tip
        mujoco.mj_jacBody(self._model, self._data, found[:3], found[3:], body)
        turn = self._data.xmat[self._base].reshape(3, 3).T
        columns = found[:, self._places]
        return np.concatenate((turn @ columns[:3], turn @ columns[3:]))

    def inertia(self) -> Matrix:
        """Return the joints' matrix of inertia (n, n) [kg*m^2]."""
        model, data = self._model, self._data
        mujoco.mj_fwdPosition(model, data)
        found = np.empty((len(self._places), len(self._places)))
        for row, unit in zip(found, self._units, strict=True):
            mujoco.mj_mulM(model, data, self._product, unit)
            row[:] = self._product[self._places]
        return found

    def gravity(self) -> Vector:
        """Return the torques that hold the joints against gravity (n,) [N*m]."""
        velocities = self._data.qvel.copy()
        self._data.qvel[:] = 0.0
        found = self._bias()
        self._data.qvel[:] = velocities
        return found

    def coriolis(self) -> Vector:
        """Return what Coriolis and centrifugal forces need (n,) [N*m]."""
        return self._bias() - self.gravity()

    def _bias(self) -> Vector:
        mujoco.mj_comVel(self._model, self._data)
        force: Vector = np.empty(self._model.nv)
        mujoco.mj_rne(self._model, self._data, 0, force)
        found: Vector = force[self._places]
        return found
