# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The objects of the running world: where they are, come and go."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import nearest, SimulationError
from armsim_ros.model.transforms import (
    matrix_from_quat_wxyz,
    pose_from_parts,
    quat_wxyz_from_matrix,
)
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.mujoco_model import object_body_name
from armsim_ros.sim.plant import Plant

Matrix = NDArray[np.float64]

_PREFIX = object_body_name('')


class WorldScene:
    """
    World objects of a simulation, by name.

    :param plant: the physics that holds them.
    """

    def __init__(self, plant: Plant) -> None:
        """Keep the physics."""
        self._plant = plant

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all objects."""
        bodies = (body.name for body in self._plant.spec.spec.bodies)
        return tuple(name[len(_PREFIX) :] for name in bodies if name.startswith(_PREFIX))

    def pose(self, name: str) -> Matrix:
        """
        Return where an object is in the world (4, 4).

        :raises SimulationError: there is none of that name.
        """
        body = self._body(name)
        address = self._free_address(body)
        if address is None:
            xyz, quat = self._plant.model.body_pos[body], self._plant.model.body_quat[body]
        else:
            xyz = self._plant.data.qpos[address : address + 3]
            quat = self._plant.data.qpos[address + 3 : address + 7]
        return pose_from_parts(xyz, matrix_from_quat_wxyz(quat))

    def set_pose(self, name: str, pose: Matrix) -> None:
        """
        Put an object elsewhere, at rest.

        :param pose: (4, 4) in the world.
        :raises SimulationError: there is none of that name.
        """
        body = self._body(name)
        address = self._free_address(body)
        quat = quat_wxyz_from_matrix(pose)
        if address is None:
            self._plant.model.body_pos[body], self._plant.model.body_quat[body] = pose[:3, 3], quat
            placed = self._plant.spec.spec.body(object_body_name(name))
            placed.pos, placed.quat = pose[:3, 3], quat
            return
        self._plant.data.qpos[address : address + 3] = pose[:3, 3]
        self._plant.data.qpos[address + 3 : address + 7] = quat
        start = int(self._plant.model.body_dofadr[body])
        self._plant.data.qvel[start : start + 6] = 0.0

    def add(self, thing: WorldObject) -> None:
        """
        Put a new object into the running world.

        :raises SimulationError: its name is taken, or the physics refuses it; the world stays
            as it was.
        """
        self._plant.spec.add_object(thing)
        try:
            self._plant.recompile()
        except SimulationError:
            self._plant.spec.remove_object(thing.name)
            raise

    def remove(self, name: str) -> None:
        """
        Take an object out of the running world.

        :raises SimulationError: there is none of that name.
        """
        self._body(name)
        self._plant.spec.remove_object(name)
        self._plant.recompile()

    def _body(self, name: str) -> int:
        if name not in self.names:
            hint = nearest(name, self.names) or f'there are: {", ".join(self.names) or "none"}'
            raise SimulationError(f"the world has no object '{name}'; {hint}")
        return int(self._plant.model.body(object_body_name(name)).id)

    def _free_address(self, body: int) -> int | None:
        """Return where a free object's pose starts in qpos, None for one that never moves."""
        if self._plant.model.body_jntnum[body] == 0:
            return None
        return int(self._plant.model.jnt_qposadr[self._plant.model.body_jntadr[body]])
