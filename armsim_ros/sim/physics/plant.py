# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The compiled physics: MuJoCo's model and data, and where the robot's joints lie in them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
import copy
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from armsim_ros.arrays import Matrix, selector, Vector
from armsim_ros.control.hardware_interface import JointArrays
from armsim_ros.errors import SimulationError
from armsim_ros.sim.physics.compiler import compile_model, StateTransfer
from armsim_ros.sim.physics.mujoco_model import PlantSpec
from armsim_ros.sim.physics.robot_spec import set_friction
from armsim_ros.sim.physics.saved_state import (
    Checkpoints,
    keep_physics_quiet,
    PlantState,
    unstable_element,
)

#: Steps that are done once more at most, but for a control period, to find an unstable step.
KEPT_STEPS = 10
#: All that the future of the physics depends on, but for what is asleep.
_WHOLE = int(mujoco.mjtState.mjSTATE_INTEGRATION)


class StagedPlant(NamedTuple):
    """
    Physics that waits to take the place of what runs.

    :param transfer: from the running model to this model.
    """

    model: Any
    data: Any
    transfer: StateTransfer


class Plant:
    """
    A running specification.

    :param spec: robot and world; it may be edited, ``recompile`` takes the edits over.
    :param joint_names: (n,) the robot's movable joints; the order of all vectors.
    :param state: (n,) arrays that ``read`` refreshes.
    :param active: selects the joints with drives, in the drives' order.
    :param fingers: (m,) for how many fingers each drive has force.
    :raises SimulationError: MuJoCo refuses the specification.
    """

    def __init__(
        self, spec: PlantSpec, joint_names: tuple[str, ...], state: JointArrays, active: Any,
        fingers: Vector
    ) -> None:
        keep_physics_quiet()
        self.spec, self.joint_names = spec, joint_names
        self._state, self._active = state, active
        self.model: Any = spec.compile()
        self.data: Any = mujoco.MjData(self.model)
        count = len(fingers)
        self._fingers, self._per_finger = fingers, 1.0 / fingers
        self._bounds = np.full(count, np.inf)
        self._gains, self._given = np.zeros((count, 2)), np.zeros(count)
        self._bind()

    def tune(self, stiffness: Vector, damping: Vector) -> None:
        """
        Set what the drives' actuators make of position and velocity.

        :param stiffness: (m,) of the drives, in their order [N*m/rad or N/m].
        :param damping: (m,) [N*m*s/rad or N*s/m].
        """
        self._gains[:, 0], self._gains[:, 1] = stiffness, damping
        self._apply_gains()

    def bound(self, efforts: Vector) -> None:
        """Let the drives give no more than efforts (m,), nor than their own [N*m or N]."""
        self._bounds[:] = efforts
        self._bind_bounds()

    def drive(self, inputs: Vector) -> None:
        """Give the drives' actuators their inputs (m,); they hold until replaced."""
        self._given[:] = inputs
        self._inputs[:] = inputs

    def step(self, count: int = 1) -> tuple[int, str]:
        """
        Do physics steps with the present inputs.

        :returns: steps done, and what became unstable in the last of them, '' where nothing did.
        """
        model, data, checkpoints = self.model, self.data, self._checkpoints
        if count > 1:
            mujoco.mj_getState(model, data, self._before, _WHOLE)
        mujoco.mj_step(model, data, count)
        if checkpoints.stable(self._qvel):
            checkpoints.step(model, data, count)
            return count, ''
        if count > 1:
            return self._retrace(np.tile(self._inputs, (count, 1)))
        velocities = self._qvel[self._qvel_at]
        culprit = unstable_element(self.joint_names, velocities, self._state.velocity, model, data)
        if not culprit:
            checkpoints.step(model, data)
        return 1, culprit

    def follow(
        self, inputs: Matrix, tunings: Mapping[int, Vector], steps: int, expected: Matrix,
        weights: Vector,
    ) -> tuple[int, str]:
        """
        Do a physics step with each row of inputs, as long as the joints are where they should be.

        :param inputs: (k * steps, m) of the drives [N*m or N].
        :param tunings: first row of a control period -> damping (m,) from it on, see ``tune``.
        :param steps: in a control period; whether to go on is checked before each of them.
        :param expected: (k, n) where the joints should be then [rad or m].
        :param weights: (n,) 1 by how far from it they may be, see ``UpdatePlan``.
        :returns: as ``step``.
        """
        model, data = self.model, self.data
        step, stable, control = mujoco.mj_step, self._checkpoints.stable, self._inputs_bytes
        qpos, qvel, qpos_at = self._qpos, self._qvel, self._qpos_at
        checked = bool(weights.any())
        rows, size = inputs.tobytes(), len(control)
        done, kept, culprit = 0, 0, ''
        mujoco.mj_getState(model, data, self._before, _WHOLE)
        for reference in expected:
            if checked:
                share = (reference - qpos[qpos_at]) * weights
                if not share.dot(share) < 1.0:
                    break
            if done in tunings or done - kept >= KEPT_STEPS:
                kept = done
                mujoco.mj_getState(model, data, self._before, _WHOLE)
            if done in tunings:
                self.tune(self._gains[:, 0], tunings[done])
            for at in range(done * size, (done + steps) * size, size):
                control[:] = rows[at : at + size]
                step(model, data)
            done += steps
            if not stable(qvel):
                passed, culprit = self._retrace(inputs[kept:done])
                if culprit:
                    done = kept + passed
                    break
                kept = done
                mujoco.mj_getState(model, data, self._before, _WHOLE)
        if done:
            self._given[:] = inputs[done - 1]
        if done and not culprit:
            self._checkpoints.step(model, data, done)
        return done, culprit

    def _retrace(self, inputs: Matrix) -> tuple[int, str]:
        """Do physics steps (k, m) once more, singly, to stop where a step became unstable."""
        model, data = self.model, self.data
        mujoco.mj_setState(model, data, self._before, _WHOLE)
        for done, row in enumerate(inputs, start=1):
            self._inputs[:] = row
            _, culprit = self.step()
            if culprit:
                return done, culprit
            self.read()
        return len(inputs), ''

    def read(self) -> None:
        """Refresh the joints' state."""
        state = self._state
        state.position[:] = self._qpos[self._qpos_at]
        state.velocity[:] = self._qvel[self._qvel_at]
        state.acceleration[:] = self._qacc[self._qvel_at]
        state.effort[self._active] = self._force * self._per_finger

    def reset(self, positions: Vector, place_objects: Callable[[], object] = lambda: None) -> None:
        """
        Go back to the start of everything, but with the joints at ``positions`` (n,).

        :param place_objects: puts objects elsewhere before anything is computed.
        """
        mujoco.mj_resetData(self.model, self.data)
        place_objects()
        self.place(positions)

    def place(self, positions: Vector) -> None:
        """Put the joints at ``positions`` (n,), at rest; the world stays as it is."""
        self._qpos[self._qpos_at] = positions
        self._qvel[self._qvel_at] = 0.0
        self._begin()

    def place_in(self, data: Any, positions: Vector) -> None:
        """Find what touches in other data of the model, with the joints at positions (n,)."""
        data.qpos[self._qpos_at] = positions
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_collision(self.model, data)

    def restore(self) -> None:
        """Go back to where everything last was stable, at rest."""
        self._checkpoints.restore(self.model, self.data)
        self._begin()

    def save(self) -> PlantState:
        """Return the present state, for ``set_state``."""
        return PlantState(copy.copy(self.data), self.model.eq_data.copy(), self._gains.copy(),
                          self._given.copy())

    def set_state(self, saved: PlantState) -> None:
        """Be exactly what was saved, of a plant of the same specification."""
        mujoco.mj_copyData(self.data, self.model, saved.data)
        self.model.eq_data[:], self._given[:] = saved.welds, saved.inputs
        self.tune(*saved.gains.T)
        self._checkpoints = Checkpoints(self.model, self.data)
        self.read()

    def stage(self) -> StagedPlant:
        """
        Compile an edited specification while the old model runs; from any thread.

        :raises SimulationError: MuJoCo refuses it; the old physics goes on.
        """
        try:
            model = compile_model(self.spec.spec)
        except SimulationError as error:
            raise SimulationError(f'the physics cannot take the changed world: {error}') from None
        return StagedPlant(model, mujoco.MjData(model), StateTransfer(self.model, model))

    def adopt(
        self, staged: StagedPlant, check: Callable[[Any, Any], object] | None = None
    ) -> None:
        """
        Go on with what was staged from the present model; the state of what stays is kept.

        :param check: gets the new ``MjModel`` and ``MjData`` in their present state; where it
            raises, the old physics goes on.
        """
        model, data = staged.model, staged.data
        staged.transfer.copy(self.data, data)
        warm = data.qacc_warmstart.copy()
        mujoco.mj_forward(model, data)
        data.qacc_warmstart[:] = warm
        if check is not None:
            check(model, data)
        self.model, self.data = model, data
        self._bind()

    def recompile(self) -> None:
        """
        Take over an edited specification; the state of what stays is kept.

        :raises SimulationError: MuJoCo refuses it; the old physics goes on.
        """
        self.adopt(self.stage())

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

    def motion(self, body: int) -> tuple[Vector, Vector]:
        """Return how a body's origin moves: (3,) [m/s] and (3,) [rad/s], world axes."""
        self._refresh_velocities()
        velocity = np.empty(6)
        mujoco.mj_objectVelocity(
            self.model, self.data, mujoco.mjtObj.mjOBJ_XBODY, body, velocity, 0)
        return velocity[3:], velocity[:3]

    def acceleration(self, body: int) -> tuple[Vector, Vector]:
        """
        Return the acceleration of a body's origin in the last step.

        :returns: (3,) [m/s^2] and (3,) [rad/s^2], world axes; 0 at rest.
        """
        model, data = self.model, self.data
        if data.body_awake[body] == mujoco.mjtSleepState.mjS_ASLEEP:  # its qacc is an old one
            return np.zeros(3), np.zeros(3)
        self._refresh_velocities()
        acceleration = data.qacc.copy()
        acceleration[self._qvel_at] = self._state.acceleration
        speeds, changes = np.zeros((2, 3, model.nv)), np.zeros((2, 3, model.nv))
        mujoco.mj_jac(model, data, *speeds, data.xpos[body], body)
        mujoco.mj_jacDot(model, data, *changes, data.xpos[body], body)
        linear, angular = speeds @ acceleration + changes @ data.qvel
        return linear, angular

    def _refresh_velocities(self) -> None:
        """Have places and velocities of all bodies follow from the joints now."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_comVel(self.model, self.data)

    def bounds(self, bodies: Sequence[int], frame: int) -> tuple[Vector, Vector]:
        """
        Return the smallest and largest corner of what bodies consist of, (3,) each [m].

        :param bodies: which are measured; planes, which have no end, are left out.
        :param frame: the body in whose axes.
        """
        model, data = self.model, self.data
        mujoco.mj_kinematics(model, data)
        turn, origin = data.xmat[frame].reshape(3, 3), data.xpos[frame]
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for body in bodies:
            start = int(model.body_geomadr[body])
            for geom in range(start, start + int(model.body_geomnum[body])):
                if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
                    continue
                rotation = data.geom_xmat[geom].reshape(3, 3)
                middle, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
                centre = turn.T @ (data.geom_xpos[geom] + rotation @ middle - origin)
                reach = np.abs(turn.T @ rotation) @ half
                low, high = np.minimum(low, centre - reach), np.maximum(high, centre + reach)
        if not np.isfinite(low).all():
            return np.zeros(3), np.zeros(3)
        return low, high

    def push(self, body: int, force: ArrayLike, torque: ArrayLike) -> None:
        """Push a body at its centre of mass, world axes [N, N*m], until another push."""
        self.data.xfrc_applied[body, :3] = force
        self.data.xfrc_applied[body, 3:] = torque

    def state_bytes(self) -> bytes:
        """Return all that the future of the physics depends on."""
        state = np.empty(mujoco.mj_stateSize(self.model, _WHOLE))
        mujoco.mj_getState(self.model, self.data, state, _WHOLE)
        asleep: bytes = self.data.tree_asleep.tobytes()
        return state.tobytes() + asleep

    def wake(self) -> None:
        """Wake all that sleeps: what it lies on may be gone."""
        flags = self.model.opt.enableflags
        self.model.opt.enableflags = flags & ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        mujoco.mj_forward(self.model, self.data)
        self.model.opt.enableflags = flags

    def _begin(self) -> None:
        # The present inputs belong to the previous positions.
        slack = np.zeros(len(self._given))
        self.drive(slack)
        self.tune(slack, slack)
        mujoco.mj_forward(self.model, self.data)
        self._checkpoints = Checkpoints(self.model, self.data)

    def _bind(self) -> None:
        """Look up addresses and views; they hold until the specification is compiled again."""
        model, data = self.model, self.data
        names = [self.spec.name(name) for name in self.joint_names]
        self._qpos_at = selector([int(model.joint(name).qposadr[0]) for name in names])
        self._qvel_at = selector([int(model.joint(name).dofadr[0]) for name in names])
        self._qpos, self._qvel, self._qacc = data.qpos, data.qvel, data.qacc
        drives = len(self._given)
        self._inputs, self._force = data.ctrl[:drives], data.actuator_force[:drives]
        self._inputs_bytes = memoryview(self._inputs).cast('B')
        limited = model.actuator_forcelimited[:drives].astype(np.bool_)
        self._efforts = np.where(limited, model.actuator_forcerange[:drives, 1], np.inf)
        self._bind_bounds()
        self._bias = model.actuator_biasprm[:drives, 1:3]
        self._driven_dofs = model.jnt_dofadr[model.actuator_trnid[:drives, 0]]
        self._rubs = bool(model.dof_frictionloss[self._driven_dofs].any())
        self._apply_gains()
        self._inputs[:] = self._given
        self._before = np.empty(mujoco.mj_stateSize(model, _WHOLE))
        self._checkpoints = Checkpoints(model, data)

    def _apply_gains(self) -> None:
        np.negative(self._gains, out=self._bias)
        if self._rubs:
            set_friction(self.model, self._driven_dofs, np.asarray(self._gains.any(axis=1)))

    def _bind_bounds(self) -> None:
        """Give the actuators the bounds of their forces."""
        most = np.minimum(self._efforts, self._bounds) * self._fingers
        drives, limited = len(most), np.isfinite(most)
        self.model.actuator_forcelimited[:drives] = limited
        most[~limited] = 0.0
        self.model.actuator_forcerange[:drives, 0] = -most
        self.model.actuator_forcerange[:drives, 1] = most
