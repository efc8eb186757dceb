# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What an environment shows: named vectors of joints, tip, objects and suction."""

from __future__ import annotations

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.env.gym_base import Box, Dict
from armsim_ros.model.transforms import quat_xyzw_from_matrix
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
        spaces = {name: Box(np.full(size, -np.inf), np.full(size, np.inf), dtype=np.float64)
                  for name, size in sizes.items() if size}
        if cups:
            spaces['held'] = Box(np.zeros(len(cups)), np.ones(len(cups)), dtype=np.float64)
        self.space = Dict(spaces)

    def read(self, simulation: Simulation) -> dict[str, Vector]:
        """Return the present observation, in arrays of its own."""
        places = [simulation.index[name] for name in self._joints]
        state = simulation.state
        found = {
            'joint_positions': state.position[places],
            'joint_velocities': state.velocity[places],
            'joint_efforts': state.effort[places],
            'tip_pose': _parts(simulation.link_pose(self._tip)),
        }
        if self._objects:
            poses = [_parts(simulation.world.pose(name)) for name in self._objects]
            found['object_poses'] = np.concatenate(poses)
        if self._cups:
            held = [bool(cup.held) for cup in simulation.vacuum_grippers.values()]
            found['held'] = np.array(held, dtype=np.float64)
        return found


def _parts(pose: Matrix) -> Vector:
    return np.concatenate((pose[:3, 3], quat_xyzw_from_matrix(pose)))
