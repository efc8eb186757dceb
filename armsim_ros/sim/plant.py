# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The compiled physics: MuJoCo's model and data, and where the robot's joints lie in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsim_ros.control.hardware_interface import JointArrays
from armsim_ros.errors import SimulationError
from armsim_ros.sim.mujoco_model import PlantSpec
from armsim_ros.sim.stability import Checkpoints, keep_physics_quiet, unstable_element

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


def selector(places: Sequence[int]) -> Any:
    """Return a slice where the places follow each other, else an index array."""
    if places and list(places) == list(range(places[0], places[0] + len(places))):
        return slice(places[0], places[0] + len(places))
    return np.array(places, dtype=np.intp)


class Plant:
    """
    A running specification.

    :param spec: robot and world; it may be edited, ``recompile`` takes the edits over.
    :param joint_names: (n,) the robot's movable joints; the order of all vectors.
    :raises SimulationError: MuJoCo refuses the specification.
    """

    def __init__(self, spec: PlantSpec, joint_names: tuple[str, ...]) -> None:
        """Compile the specification."""
        keep_physics_quiet()
        self.spec = spec
        self.joint_names = joint_names
        self.model: Any = spec.compile()
        self.data: Any = mujoco.MjData(self.model)
        self._bind()

    def step(self, torques: Vector) -> str:
        """
        Do one physics step.

        :param torques: of the motors, in their order [N*m or N].
        :returns: what became unstable, '' where nothing did.
        """
        last = self._qvel[self._qvel_at].copy()
        self._control[:] = torques
        mujoco.mj_step(self.model, self.data)
        if not self._checkpoints.stable(self._qvel):
            culprit = unstable_element(
                self.joint_names, self._qvel[self._qvel_at], last, self.model, self.data
            )
            if culprit:
                return culprit
        self._checkpoints.step(self.model, self.data)
        return ''

    def read(self, state: JointArrays, active: Any) -> None:
        """
        Write the joints' state into arrays.

        :param state: (n,) arrays, changed in place.
        :param active: selects the joints with motors, in the motors' order.
        """
        state.position[:] = self._qpos[self._qpos_at]
        state.velocity[:] = self._qvel[self._qvel_at]
        state.acceleration[:] = self._qacc[self._qvel_at]
        state.effort[active] = self._force

    def reset(self, positions: Vector) -> None:
        """Go back to the start of everything, but with the joints at ``positions`` (n,)."""
        mujoco.mj_resetData(self.model, self.data)
        self.place(positions)

    def place(self, positions: Vector) -> None:
        """Put the joints at ``positions`` (n,), at rest; the world stays as it is."""
        self._qpos[self._qpos_at] = positions
        self._qvel[self._qvel_at] = 0.0
        self._begin()

    def restore(self) -> None:
        """Go back to where everything last was stable, at rest."""
        self._checkpoints.restore(self.model, self.data)
        self._begin()

    def recompile(self) -> None:
        """
        Take over an edited specification; the state of what stays is kept.

        :raises SimulationError: MuJoCo refuses it; the old physics goes on.
        """
        try:
            self.model, self.data = self.spec.spec.recompile(self.model, self.data)
        except (ValueError, RuntimeError, mujoco.FatalError) as error:
            raise SimulationError(f'the physics cannot take the changed world: {error}') from error
        self._bind()

    def body(self, link: str) -> int:
        """Return the body of a link of the robot."""
        return int(self.model.body(self.spec.name(link)).id)

    def pose(self, body: int) -> Matrix:
        """Return where a body is in the world (4, 4)."""
        mujoco.mj_kinematics(self.model, self.data)
        pose = np.eye(4)
        pose[:3, :3] = self.data.xmat[body].reshape(3, 3)
        pose[:3, 3] = self.data.xpos[body]
        return pose

    def push(self, body: int, force: ArrayLike, torque: ArrayLike) -> None:
        """Push a body at its centre of mass, world axes [N, N*m], until another push."""
        self.data.xfrc_applied[body, :3] = force
        self.data.xfrc_applied[body, 3:] = torque

    def state_bytes(self) -> bytes:
        """Return all that the future of the physics depends on."""
        signature = int(mujoco.mjtState.mjSTATE_INTEGRATION)
        state = np.empty(mujoco.mj_stateSize(self.model, signature))
        mujoco.mj_getState(self.model, self.data, state, signature)
        return state.tobytes()

    def _begin(self) -> None:
        mujoco.mj_forward(self.model, self.data)
        self._checkpoints = Checkpoints(self.model, self.data)

    def _bind(self) -> None:
        """Look up addresses and views; they hold until the specification is compiled again."""
        model, data = self.model, self.data
        names = [self.spec.name(name) for name in self.joint_names]
        self._qpos_at = selector([int(model.joint(name).qposadr[0]) for name in names])
        self._qvel_at = selector([int(model.joint(name).dofadr[0]) for name in names])
        self._qpos, self._qvel, self._qacc = data.qpos, data.qvel, data.qacc
        self._control, self._force = data.ctrl, data.actuator_force
        self._checkpoints = Checkpoints(model, data)
