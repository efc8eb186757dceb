# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""States of a simulation: its start, given, saved bit by bit, or kept for when it runs away."""

from __future__ import annotations

from collections.abc import Mapping
import copy
from dataclasses import dataclass
import hashlib
import logging
from typing import Any, ClassVar, TYPE_CHECKING

import mujoco
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import nearest, SimulationError

if TYPE_CHECKING:
    from armsim_ros.control.hardware_interface import JointArrays
    from armsim_ros.model.robot_model import RobotModel
    from armsim_ros.sim.clock import SimClock
    from armsim_ros.sim.drives.servo import Servo
    from armsim_ros.sim.physics.plant import Plant
    from armsim_ros.sim.sensors import Sensors
    from armsim_ros.sim.vacuum_gripper import VacuumGripper
    from armsim_ros.sim.world.world_scene import WorldScene

#: How much of an ``MjData`` is awake; its pickle has it not.
_AWAKE = ('nbody_awake', 'nparent_awake', 'ntree_awake', 'nv_awake')


class Restorable:
    """A part whose attributes, but for some that never change, are its state."""

    unchanging: ClassVar[frozenset[str]] = frozenset()
    """Attributes that are not part of the state: settings, and other parts."""

    def save(self) -> dict[str, Any]:
        """Return a copy of all that changes while it works."""
        state = {name: value for name, value in vars(self).items() if name not in self.unchanging}
        return copy.deepcopy(state)

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Be what it was when ``save`` was called; on another of the same kind, too."""
        vars(self).update(copy.deepcopy(dict(saved)))


@dataclass(frozen=True, eq=False)
class PlantState:
    """
    The physics.

    :param data: a copy of the ``MjData``, with all that the next step reads.
    :param welds: (neq, k) where welds hold their two bodies.
    :param gains: (m, 2) stiffness and damping of the drives.
    :param inputs: (m,) of the drives, as they were given last.
    """

    data: Any
    welds: Matrix
    gains: Matrix
    inputs: Vector

    def __getstate__(self) -> dict[str, Any]:
        """Return what a pickle holds, with the counts that MuJoCo leaves out of its own."""
        return {**vars(self), 'awake': {name: getattr(self.data, name) for name in _AWAKE}}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take over what a pickle held."""
        for name, count in state.pop('awake').items():
            setattr(state['data'], name, count)
        vars(self).update(state)


@dataclass(frozen=True, eq=False)
class SimulationState:
    """
    A whole simulation: physics, drives, suction cups, commands, time.

    :param objects: names of the world's objects; a simulation with others cannot take it.
    :param fixed: poses (4, 4) of those that never move by themselves.
    :param drives: of the servo.
    :param grippers: suction cup -> its state.
    :param commands: (8, n) commands and feed-forward of all joints.
    :param other_commands: of sensors and gpios.
    :param given_states: that controllers set, of the whole and of each robot in it.
    :param written: the commands that were taken over last.
    :param time: steps done, and time before the first of them [ns].
    """

    objects: tuple[str, ...]
    fixed: Mapping[str, Matrix]
    plant: PlantState
    drives: Mapping[str, Any]
    grippers: Mapping[str, Mapping[str, Any]]
    commands: Matrix
    other_commands: Mapping[str, float]
    given_states: tuple[Mapping[str, float], ...]
    written: tuple[bytes, int]
    time: tuple[int, int]


class RestorableSimulation:
    """The part of a simulation that puts it at its start, elsewhere, or back to a state."""

    model: RobotModel
    joint_names: tuple[str, ...]
    state: JointArrays
    clock: SimClock
    world: WorldScene
    vacuum_grippers: dict[str, VacuumGripper]
    other_commands: dict[str, float]
    given_states: dict[str, float]
    given_states_of_parts: list[dict[str, float]]
    _inputs: Matrix
    _written: tuple[bytes, int]
    _plant: Plant
    _servo: Servo
    _sensors: Sensors
    _initial: Vector
    _active: Any
    _bounded: bytes

    def save_state(self) -> SimulationState:
        """Return all that the future depends on; between two control periods."""
        objects = self.world.objects
        return SimulationState(
            tuple(objects),
            {name: self.world.pose(name) for name in objects if objects[name].mass is None},
            self._plant.save(), self._servo.save(),
            {name: gripper.save() for name, gripper in self.vacuum_grippers.items()},
            self._inputs.copy(), dict(self.other_commands),
            tuple(dict(states) for states in (self.given_states, *self.given_states_of_parts)),
            self._written, (self.clock.steps, self.clock.start_ns))

    def restore_state(self, saved: SimulationState) -> None:
        """
        Be exactly what was saved, here or in another simulation of the same robot and world.

        :raises SimulationError: the world has other objects than it had then.
        """
        if self.world.names != saved.objects:
            raise SimulationError(
                f'the state is of a world with {", ".join(saved.objects) or "no objects"}; here '
                f'there are {", ".join(self.world.names) or "none"}; make them the same first')
        for name, pose in saved.fixed.items():
            if self.world.pose(name).tobytes() != pose.tobytes():
                self.world.set_pose(name, pose)
        self._plant.set_state(saved.plant)
        self._servo.restore(saved.drives)
        for name, gripper in self.vacuum_grippers.items():
            gripper.restore(saved.grippers[name])
        self._inputs[:], self._written = saved.commands, saved.written
        self.other_commands.update(saved.other_commands)
        # In place: controllers hold on to them.
        for given, values in zip(
            (self.given_states, *self.given_states_of_parts), saved.given_states, strict=True
        ):
            given.clear()
            given.update(values)
        self.clock.steps, self.clock.start_ns = saved.time

    def digest(self) -> str:
        """Return a hash of all that the future depends on: plant, drives, time."""
        parts = hashlib.sha256(self._plant.state_bytes())
        parts.update(self._servo.state_bytes())
        parts.update(self._bounded)
        parts.update(self.clock.now_ns.to_bytes(16, 'little', signed=True))
        return parts.hexdigest()

    def reset(self) -> None:
        """Put robot and objects back to the start; time goes on, claims stay."""
        for gripper in self.vacuum_grippers.values():
            gripper.switch_off()
        self._sensors.forget_zeros()
        self.world.return_to_start()
        self._plant.reset(self._initial)
        self._settle_in()

    def begin(self, positions: Mapping[str, float], poses: Mapping[str, Matrix]) -> None:
        """
        Begin anew at time 0, without compiling the physics again.

        What was changed in the ``MjModel``, such as a mass, stays.

        :param positions: joint -> [rad or m]; the others start as usual.
        :param poses: free object -> where it is, (4, 4) in the world.
        :raises SimulationError: a joint or an object that is not there.
        """
        for name in positions:
            if name not in self.model.active_joints:
                raise SimulationError(self._undriven(name))
        start = self._initial
        if positions:
            known = dict(zip(self.joint_names, self._initial.tolist(), strict=True))
            full = self.model.complete({**known, **positions})
            start = np.array([full[name] for name in self.joint_names])
        for gripper in self.vacuum_grippers.values():
            gripper.switch_off()
            gripper.losses.clear()
        self.world.return_to_start()
        self.clock.reset()

        def place_objects() -> None:
            for name, pose in poses.items():
                self.world.set_pose(name, pose)

        self._plant.reset(start, place_objects)
        self._settle_in()

    def recover(self) -> None:
        """Put everything at rest where it last was stable, after ``step`` has raised."""
        for gripper in self.vacuum_grippers.values():
            gripper.release()
        self._plant.restore()
        self._settle_in()

    def set_positions(self, positions: Mapping[str, float]) -> None:
        """
        Put joints elsewhere at once, at rest; mimic joints follow.

        :param positions: joint -> [rad or m]; joints that are not there stay.
        :raises SimulationError: a joint that is not there or that follows another.
        """
        for name in positions:
            joint = self.model.joints.get(name)
            if joint is None or not joint.active:
                raise SimulationError(self._undriven(name))
        now = dict(zip(self.joint_names, self.state.position, strict=True))
        full = self.model.complete({**now, **positions})
        self._plant.place(np.array([full[name] for name in self.joint_names]))
        self._settle_in()

    def _settle_in(self) -> None:
        self._inputs[:8] = np.nan
        self._plant.read()
        # Nothing has acted yet.
        self.state.effort[:] = self.state.acceleration[:] = 0.0
        self._written = (b'', 0)
        self._servo.dynamics.set_gravity(self._plant.model.opt.gravity)
        self._servo.restart(self.state.position[self._active])

    def _undriven(self, name: str) -> str:
        joint = self.model.joints.get(name)
        if joint is not None and joint.mimic is not None:
            return f"joint '{name}' follows '{joint.mimic.joint}' and cannot be driven itself"
        hint = nearest(name, self.model.active_joints) or ', '.join(self.model.active_joints)
        return f"robot '{self.model.name}' has no joint '{name}' that can be driven; {hint}"


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
