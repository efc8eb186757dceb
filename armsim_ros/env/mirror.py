# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Puts what is measured of a running arm into the simulation of an environment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import math

import mujoco

from armsim_ros.arrays import Vector
from armsim_ros.model.transforms import matrix_from_quat_wxyz
from armsim_ros.sim.simulation import Simulation


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
