# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Moves the joints of an environment without controllers, or as a running arm was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import math
from typing import Protocol

import mujoco
import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.model.transforms import matrix_from_quat_wxyz
from armsim_ros.sim.simulation import Simulation
from armsim_ros.sim.vacuum_gripper import LOOK_NS, VacuumGripper

#: Simulated time between checks of cups that all hold something [ns].
HELD_LOOK_NS = 10_000_000


class Motion(Protocol):
    """Moves the joints of an environment."""

    def suck(self, on: Sequence[bool]) -> None:
        """Switch the cups on or off."""

    def go(self, end: Vector) -> None:
        """Move from the last command to the next within a step (n,) [rad or m]."""


class JointMotion:
    """
    Commands positions to all drives, and has suction cups check what they hold.

    A step of the environment is one control period of the drives: the reference is a spline from
    command to command, and its dynamics is computed at the commands and interpolated between them.

    :param simulation: its joints must be claimed for positions.
    :param joints: (n,) the joints with drives.
    :param steps: physics steps in a step of the environment.
    """

    def __init__(self, simulation: Simulation, joints: Sequence[str], steps: int) -> None:
        self._simulation, self._steps = simulation, steps
        self._places = np.array([simulation.index[name] for name in joints], dtype=np.intp)
        self._cups: tuple[VacuumGripper, ...] = tuple(simulation.vacuum_grippers.values())
        self._step_ns = simulation.clock.step_ns

    def suck(self, on: Sequence[bool]) -> None:
        """Switch the cups on or off."""
        for cup, requested in zip(self._cups, on, strict=True):
            if requested and not cup.on:
                cup.switch_on()
            elif not requested and cup.on:
                cup.switch_off()

    def go(self, end: Vector) -> None:
        """
        Move from the last command to the next within a step.

        :param end: (n,) [rad or m].
        :raises SimulationError: the physics became unstable.
        """
        simulation, steps = self._simulation, self._steps
        simulation.command.position[self._places] = end
        simulation.write_period(steps)
        done = last = 0
        while done < steps:
            stride = max(1, self._until_check() // self._step_ns)
            count = min(max(1, last + stride - done), steps - done)
            simulation.step(count)
            done += count
            if stride <= done - last:
                for cup in self._cups:
                    cup.look((done - last) * self._step_ns)
                last = done

    def _until_check(self) -> int:
        """Return the time between two checks of the cups [ns]."""
        active = [cup for cup in self._cups if cup.on]
        if not active:
            return self._steps * self._step_ns
        return HELD_LOOK_NS if all(cup.held for cup in active) else LOOK_NS


class Mirror:
    """
    A simulation that is not stepped but follows measurements.

    What a cup holds is what touches it; what fingers hold, what they press.

    :param simulation: follows from now on.
    :param objects: names of the objects that can move.
    """

    def __init__(self, simulation: Simulation, objects: Sequence[str]) -> None:
        self._simulation = simulation
        model = simulation.mujoco_model
        model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        # The measured efforts act in place of the drives.
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
        elements = {name: simulation.joint_element(name) for name in simulation.joint_names}
        self._joints = {name: _addresses(model, element) for name, element in elements.items()}
        self._items = {name: _addresses(model, f'object/{name}') for name in objects}

    def show(
        self, positions: Mapping[str, float], velocities: Mapping[str, float],
        efforts: Mapping[str, float], objects: Mapping[str, tuple[Vector, Vector]],
    ) -> None:
        """
        Be as measured.

        :param positions: joint -> [rad or m]; mimic joints may be left out.
        :param velocities: joint -> [rad/s or m/s].
        :param efforts: joint -> [N*m or N].
        :param objects: name -> pose (7,) x, y, z, qw, qx, qy, qz and velocity (6,) linear and
            angular, all in the world.
        """
        simulation = self._simulation
        data, state = simulation.mujoco_data, simulation.state
        full = simulation.model.complete({
            name: positions[name] for name in simulation.model.active_joints})
        for name, (position_at, velocity_at) in self._joints.items():
            place = simulation.index[name]
            state.position[place] = positions.get(name, full[name])
            state.velocity[place] = velocities.get(name, 0.0)
            data.qpos[position_at] = state.position[place]
            data.qvel[velocity_at] = state.velocity[place]
            effort = efforts.get(name, 0.0)
            data.qfrc_applied[velocity_at] = effort if math.isfinite(effort) else 0.0
        for name, (pose, velocity) in objects.items():
            position_at, velocity_at = self._items[name]
            data.qpos[position_at:position_at + 7] = pose
            data.qvel[velocity_at:velocity_at + 3] = velocity[:3]
            # MuJoCo has the angular velocity in the axes of the body.
            turn = matrix_from_quat_wxyz(pose[3:])
            data.qvel[velocity_at + 3:velocity_at + 6] = turn.T @ velocity[3:]
        mujoco.mj_forward(simulation.mujoco_model, data)
        for cup in simulation.vacuum_grippers.values():
            cup.release()
            if cup.on:
                cup.look()


def _addresses(model: object, joint: str) -> tuple[int, int]:
    """Return where a joint is in ``qpos`` and ``qvel``."""
    found = model.joint(joint)  # type: ignore[attr-defined] # MjModel has no annotations
    return int(found.qposadr[0]), int(found.dofadr[0])
