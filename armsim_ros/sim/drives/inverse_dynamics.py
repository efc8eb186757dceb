# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The torques that move the robot alone along a reference."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.sim.drives.reference import product
from armsim_ros.sim.physics.mujoco_model import PlantSpec

#: Between two nodes that lie so far apart inertia and other torques are taken as linear [steps].
LONGEST_STRIDE = 10


class _Friction:
    """
    Dry friction as the physics makes it, which is soft: viscous below a velocity.

    The inverse of the constraint's force (engine_core_constraint.c of MuJoCo: mj_makeImpedance),
    which depends on the joint's own motion alone.

    :param model: the plant.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        least, most = model.dof_solimp[:, 0], model.dof_solimp[:, 1]
        time_constant = np.maximum(model.dof_solref[:, 0], 2.0 * model.opt.timestep)
        self._most: Vector = model.dof_frictionloss.copy()
        self._damping: Vector = 2.0 / (most * time_constant)
        self._inertia: Vector = least / (1.0 - least) / model.dof_invweight0

    def forces(self, velocity: Matrix, acceleration: Matrix) -> Matrix:
        """Return what overcomes the friction of all joints (k, nv) [N*m or N]."""
        sticking = self._inertia * (acceleration + self._damping * velocity)
        return np.clip(sticking, -self._most, self._most)
#: With so few nodes all columns of the matrix of inertia are interpolated at once.
FEW_NODES = 8


class InverseDynamics:
    """
    Discrete-time inverse dynamics of the robot without its world.

    Gravity, inertia, Coriolis, rotor inertia, damping and dry friction; mimic joints load the
    joint that they follow.

    :param settings: gravity, timestep, rotor inertia.
    """

    def __init__(self, model: RobotModel, settings: SimulationSettings) -> None:
        self._model = PlantSpec(model, settings, contacts=False).compile()
        self._data = mujoco.MjData(self._model)
        plant_order = [self._model.joint(i).name for i in range(self._model.njnt)]
        prefix = f'{model.name}/'
        # All joints have one degree of freedom: position, velocity and joint numbers agree.
        self._joints = np.array(
            [plant_order.index(prefix + name) for name in model.movable_joints], dtype=np.intp)
        self._expand, self._offset = _mimic_map(model)
        scatter = np.zeros((self._model.nv, len(model.movable_joints)))
        scatter[self._joints, np.arange(len(self._joints))] = 1.0
        self._from_active = scatter @ self._expand
        self._driver = np.abs(self._from_active).argmax(axis=1)
        self._ratio = self._from_active[np.arange(self._model.nv), self._driver]
        # From forces, and from inertias, of all joints to those that their drivers bear.
        self._borne_by = np.zeros_like(self._from_active)
        self._borne_by[np.arange(len(self._driver)), self._driver] = self._ratio
        self._inertia_of = self._borne_by**2
        self._full_offset = scatter @ self._offset
        #: Whether every joint is driven and they come in the physics' own order.
        self._plain = bool(
            np.array_equal(self._from_active, np.eye(self._model.nv))
            and not self._full_offset.any())
        rows, lengths = self._model.M_rowadr, self._model.M_rownnz
        self._diagonal = (rows + lengths - 1).astype(np.intp)
        damping = self._model.dof_damping * self._model.opt.timestep
        self._step_damping = damping if damping.any() else None
        self._friction = _Friction(self._model) if self._model.dof_frictionloss.any() else None
        data = self._data
        self._views = data.qpos, data.qvel, data.qacc, data.qfrc_inverse, data.M
        # Where the full matrix of inertia finds its entries in the sparse matrix, else in a zero.
        self._full = np.full((self._model.nv, self._model.nv), len(data.M), dtype=np.intp)
        for row, (start, length) in enumerate(zip(rows, lengths, strict=True)):
            columns = self._model.M_colind[start : start + length]
            self._full[row, columns] = self._full[columns, row] = range(start, start + length)
        self._pair = np.concatenate((self._full, self._full + len(data.M) + 1), axis=1)
        self._node: tuple[bytes, Vector, Vector] = b'', data.M, data.qpos
        #: Bodies with a payload -> their own mass, centre and inertia.
        self._carriers: dict[int, list[Vector]] = {}

    def set_payload(self, body: str, mass: float, centre: Sequence[float]) -> None:
        """
        Count with a point mass at a body from now on, in place of the body's last.

        :param mass: [kg].
        :param centre: (3,) in the axes of the body [m].
        """
        model = self._model
        parts = model.body_mass, model.body_ipos, model.body_iquat, model.body_inertia
        place = model.body(body).id
        own = self._carriers.setdefault(place, [np.copy(part[place]) for part in parts])
        for part, value in zip(parts, own, strict=True):
            part[place] = value
        if mass > 0.0:
            whole = float(own[0]) + mass
            between = np.asarray(centre) - own[1]
            axes = np.zeros(9)
            mujoco.mju_quat2Mat(axes, own[2])
            inertia = axes.reshape(3, 3) @ np.diag(own[3]) @ axes.reshape(3, 3).T
            reduced = float(own[0]) * mass / whole
            inertia += reduced * (between @ between * np.eye(3) - np.outer(between, between))
            moments, directions = np.linalg.eigh(inertia)
            directions[:, 2] *= np.sign(np.linalg.det(directions))
            quat_wxyz = np.zeros(4)
            mujoco.mju_mat2Quat(quat_wxyz, directions.flatten())
            model.body_mass[place], model.body_iquat[place] = whole, quat_wxyz
            model.body_ipos[place] = own[1] + between * (mass / whole)
            model.body_inertia[place] = np.maximum(moments, 0.0)
        mujoco.mj_setConst(model, self._data)
        self._node = b'', *self._node[1:]

    def set_gravity(self, gravity: Vector) -> None:
        """Have another gravity from now on (3,) [m/s^2]."""
        self._model.opt.gravity[:] = gravity
        self._node = b'', *self._node[1:]

    def torques(
        self, position: Matrix, velocity: Matrix, acceleration: Matrix
    ) -> tuple[Matrix, Matrix]:
        """
        Return the torques that take the reference to ``velocity + h*acceleration`` in each step.

        :param position: (k, n) of the active joints at the start of each step [rad or m].
        :param velocity: (k, n) at the start of the step [rad/s or m/s].
        :param acceleration: (k, n) change of velocity in the step by its time [rad/s^2 or m/s^2].
        :returns: (k, n) [N*m or N], and (k, m) matrices of inertia for ``joint_inertias``.
        """
        if not self._plain:
            position = self._spread(position, offset=True)
            velocity, acceleration = self._spread(velocity), self._spread(acceleration)
        forces, inertia = np.empty(position.shape), np.empty((len(position), self._model.nM))
        self._look(position, velocity, acceleration, forces, inertia)
        return self._borne(forces, velocity, acceleration), inertia

    def at_rest(self, position: Matrix) -> tuple[Matrix, Matrix]:
        """Return what ``torques`` does for joints that rest at positions (k, n) [rad or m]."""
        rest = np.zeros_like(position)
        return self.torques(position, rest, rest)

    def torques_between(
        self, position: Matrix, velocity: Matrix, acceleration: Matrix, stride: int
    ) -> tuple[Matrix, Matrix]:
        """
        Return what ``torques`` does, the dynamics computed only at every so many steps.

        Between them the matrix of inertia, and the torques without acceleration, are linear.

        :param position: (k + 1, n) of the active joints before each step, and at the end.
        :param velocity: (k + 1, n) at the same times [rad/s or m/s].
        :param acceleration: (k, n) as for ``torques``.
        :param stride: steps from node to node; k holds a whole number of them.
        :returns: (k, n) [N*m or N], and the nodes' matrices of inertia for ``joint_inertias``.
        """
        if not self._plain:
            position = self._spread(position, offset=True)
            velocity, acceleration = self._spread(velocity), self._spread(acceleration)
        steps, joints = acceleration.shape
        inertia, bias = self._nodes(position[::stride], velocity[::stride])
        # (stride, joint, node): long rows for numpy, and no matrix of all steps.
        share = (np.arange(stride) / stride)[:, None, None]
        changes = acceleration.reshape(-1, stride, joints).transpose(2, 1, 0).copy()[:, :, None]
        padded = np.concatenate((inertia, np.zeros((len(inertia), 1))), axis=1)
        if len(inertia) <= FEW_NODES:
            # All columns at once, added up in the same order.
            nodes = np.concatenate((bias.T[None], padded.T[self._full]))
            ways = share[:, None] * (nodes[..., 1:] - nodes[..., :-1])
            ways += nodes[..., :-1]
            ways[:, 1:] *= changes.transpose(1, 0, 2, 3)
            forces = np.add.reduce(ways, axis=1)
            forces = forces.transpose(2, 0, 1).reshape(steps, joints)
            return self._borne(forces, velocity[:-1], acceleration), inertia
        forces = _between(bias.T.copy(), share)
        # The matrix is symmetric; its columns come one by one, however many steps there are.
        for nodes, change in zip(padded.T[self._full], changes, strict=True):
            part = _between(nodes, share)
            part *= change
            forces += part
        forces = forces.transpose(2, 0, 1).reshape(steps, joints)
        return self._borne(forces, velocity[:-1], acceleration), inertia

    def loads_over(
        self, position: Matrix, velocity: Matrix, features: Matrix
    ) -> tuple[Matrix, Matrix, Matrix, Matrix]:
        """
        Return what a period's features load, the dynamics computed only at its start and end.

        Dry friction, which is not linear, is ``friction``.

        :param position: (2, n) of the active joints there [rad or m].
        :param velocity: (2, n) there [rad/s or m/s].
        :param features: (4, n) those of accelerations.
        :returns: (4, n) by the inertia at the start and (4, n) by its change, (2, n) the torques
            without acceleration and their change, and inertias there for ``joint_inertias``.
        """
        if not self._plain:
            position = self._spread(position, offset=True)
            velocity, features = self._spread(velocity), self._spread(features)
        joints, padded = len(self._full), np.zeros((2, self._model.nM + 1))
        inertia, bias = padded[:, :-1], np.empty((2, joints))
        self._fill_nodes(position, velocity, bias, inertia)
        # Both matrices of inertia side by side.
        loads = product(features, padded.ravel()[self._pair])
        first = loads[:, :joints]
        change = loads[:, joints:] - first
        if self._step_damping is not None:
            first += self._step_damping * features
        bias[1] -= bias[0]
        if self._plain:
            return first, change, bias, inertia
        loads = product(np.concatenate((first, change, bias)), self._borne_by)
        return loads[:4], loads[4:8], loads[8:], inertia

    @property
    def has_friction(self) -> bool:
        """Whether there is dry friction."""
        return self._friction is not None

    def friction(self, velocity: Matrix, acceleration: Matrix) -> Matrix:
        """Return what overcomes dry friction (k, n), arguments as for ``torques`` [N*m or N]."""
        assert self._friction is not None
        if self._plain:
            return self._friction.forces(velocity, acceleration)
        return product(self._friction.forces(
            self._spread(velocity), self._spread(acceleration)), self._borne_by)

    def _nodes(self, position: Matrix, velocity: Matrix) -> tuple[Matrix, Matrix]:
        """
        Return matrices of inertia, and the torques without acceleration.

        :param position: (k, nv) of all joints of the physics; the first is often the last node.
        :param velocity: (k, nv).
        """
        bias, inertia = np.empty(position.shape), np.empty((len(position), self._model.nM))
        self._fill_nodes(position, velocity, bias, inertia)
        return inertia, bias

    def _fill_nodes(
        self, position: Matrix, velocity: Matrix, bias: Matrix, inertia: Matrix
    ) -> None:
        """Write what ``_nodes`` returns; what is known of the first is the last node."""
        known = int(position[0].tobytes() + velocity[0].tobytes() == self._node[0])
        if known:
            inertia[0], bias[0] = self._node[1:]
        rest = np.zeros((len(position) - known, bias.shape[1]))
        self._look(position[known:], velocity[known:], rest, bias[known:], inertia[known:])
        self._node = (position[-1].tobytes() + velocity[-1].tobytes(), inertia[-1].copy(),
                      bias[-1].copy())

    def _look(
        self, position: Matrix, velocity: Matrix, acceleration: Matrix, forces: Matrix,
        inertia: Matrix
    ) -> None:
        """Write the forces (k, nv) and matrices of inertia (k, m) of some states (k, nv)."""
        model, data, inverse = self._model, self._data, mujoco.mj_inverse
        qpos, qvel, qacc, force, matrix = self._views
        for i in range(len(position)):
            qpos[:], qvel[:], qacc[:] = position[i], velocity[i], acceleration[i]
            inverse(model, data)
            forces[i], inertia[i] = force, matrix

    def _borne(self, forces: Matrix, velocity: Matrix, acceleration: Matrix) -> Matrix:
        """Return what the active joints bear (k, n) of forces of all joints (k, nv)."""
        if self._step_damping is not None:
            # The integrator takes damping at the end of the step, mj_inverse at its start.
            forces += self._step_damping * acceleration
        if self._friction is not None:
            forces += self._friction.forces(velocity, acceleration)
        return forces if self._plain else product(forces, self._borne_by)

    def _spread(self, values: Matrix, *, offset: bool = False) -> Matrix:
        """Return values of all joints of the physics from those of the active ones (k, n)."""
        spread: Matrix = values[:, self._driver] * self._ratio
        return spread + self._full_offset if offset else spread

    def joint_inertias(self, inertia: Matrix) -> Matrix:
        """Return each joint's own inertia (k, n) of matrices of inertia (k, m) [kg*m^2 or kg]."""
        own: Matrix = inertia[:, self._diagonal]
        return own if self._plain else product(own, self._inertia_of)

    def expand(self, values: Vector) -> Vector:
        """Return positions of all movable joints from those of the active ones."""
        return self._expand @ values + self._offset


def _between(nodes: Matrix, share: Matrix) -> Matrix:
    """Return values (stride, n, k) on the ways from node to node (n, k + 1)."""
    ways: Matrix = share * (nodes[:, 1:] - nodes[:, :-1])
    ways += nodes[:, :-1]
    return ways


def stride_of(steps: int) -> int:
    """Return how many steps of a control period of so many lie between two nodes."""
    return next(n for n in range(min(steps, LONGEST_STRIDE), 0, -1) if steps % n == 0)


def _mimic_map(model: RobotModel) -> tuple[Vector, Vector]:
    """Return S, c with q(all movable) = S q(active) + c."""
    names, active = model.movable_joints, model.active_joints
    zero = model.complete(dict.fromkeys(active, 0.0))
    offset = np.array([zero[name] for name in names], dtype=np.float64)
    expand = np.zeros((len(names), len(active)))
    for column, driver in enumerate(active):
        positions = model.complete({**dict.fromkeys(active, 0.0), driver: 1.0})
        expand[:, column] = np.array([positions[name] for name in names]) - offset
    return expand, offset
