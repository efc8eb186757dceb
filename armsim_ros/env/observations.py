# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What an environment shows: named vectors of joints, tip, objects and suction."""

from __future__ import annotations

from typing import Any

from gymnasium.spaces import Box, Dict
import mujoco
import numpy as np

from armsim_ros.arrays import selector, Vector
from armsim_ros.sim.physics.mujoco_model import object_body_name
from armsim_ros.sim.simulation import Simulation


class Observations:
    """
    Reads a simulation.

    ``joint_positions``, ``joint_velocities`` and ``joint_efforts`` are (n,), ``tip_pose`` is (7,),
    ``object_poses`` (7 * k,) of the objects that can move, ``held`` 1 for each cup that holds
    something. A pose is x, y, z [m] in the world and a quaternion x, y, z, w.

    :param joints: (n,) the joints with drives.
    :param tip: link of ``tip_pose``.
    :param objects: (k,) names of the objects that can move.
    :param cups: names of the suction cups.
    """

    def __init__(
        self, joints: tuple[str, ...], tip: str, objects: tuple[str, ...], cups: tuple[str, ...]
    ) -> None:
        self._joints, self._tip, self._objects, self._cups = joints, tip, objects, cups
        sizes = {
            'joint_positions': len(joints), 'joint_velocities': len(joints),
            'joint_efforts': len(joints), 'tip_pose': 7, 'object_poses': 7 * len(objects),
        }
        spaces: dict[str, Any] = {
            name: Box(np.full(size, -np.inf), np.full(size, np.inf), dtype=np.float64)
            for name, size in sizes.items() if size}
        if cups:
            spaces['held'] = Box(np.zeros(len(cups)), np.ones(len(cups)), dtype=np.float64)
        self.space = Dict(spaces)
        self._model: Any = None

    def read(self, simulation: Simulation) -> dict[str, Vector]:
        """Return the present observation, in arrays of its own."""
        model, data = simulation.mujoco_model, simulation.mujoco_data
        if model is not self._model:
            self._bind(simulation)
        mujoco.mj_kinematics(model, data)
        state, places = simulation.state, self._places
        poses = np.concatenate((data.xpos.take(self._xyz), data.xquat.take(self._xyzw)), axis=1)
        found = {
            'joint_positions': state.position[places].copy(),
            'joint_velocities': state.velocity[places].copy(),
            'joint_efforts': state.effort[places].copy(),
            'tip_pose': poses[0],
        }
        if self._objects:
            found['object_poses'] = poses[1:].ravel()
        if self._cups:
            held = [bool(cup.held) for cup in simulation.vacuum_grippers.values()]
            found['held'] = np.array(held, dtype=np.float64)
        return found

    def _bind(self, simulation: Simulation) -> None:
        """Find the bodies; their numbers hold until the world is edited."""
        self._model = model = simulation.mujoco_model
        self._places = selector([simulation.index[name] for name in self._joints])
        items = [int(model.body(object_body_name(name)).id) for name in self._objects]
        # Places in the flat arrays; MuJoCo has w first.
        bodies = np.array([[simulation.link_body(self._tip)], *([item] for item in items)])
        self._xyz, self._xyzw = 3 * bodies + np.arange(3), 4 * bodies + np.array([1, 2, 3, 0])
