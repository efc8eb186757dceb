# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The objects of the running world: where they are, come and go."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import nearest, SimulationError
from armsim_ros.model.transforms import (
    matrix_from_quat_wxyz,
    pose_from_parts,
    quat_wxyz_from_matrix,
)
from armsim_ros.sim.mujoco_model import object_body_name, PlantSpec
from armsim_ros.sim.world_objects import WorldObject

Matrix = NDArray[np.float64]

_PREFIX = object_body_name('')


class WorldScene:
    """
    World objects of a simulation, by name.

    :param plant: the specification that holds them.
    :param recompile: makes an edited specification the running one and keeps the state; calls
        ``bind``.
    """

    def __init__(self, plant: PlantSpec, recompile: Callable[[], None]) -> None:
        """Wait for ``bind``."""
        self._plant = plant
        self._recompile = recompile
        self._model: Any = None
        self._data: Any = None

    def bind(self, model: Any, data: Any) -> None:
        """Take over a newly compiled ``MjModel`` and its ``MjData``."""
        self._model, self._data = model, data

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all objects."""
        bodies = (body.name for body in self._plant.spec.bodies)
        return tuple(name[len(_PREFIX) :] for name in bodies if name.startswith(_PREFIX))

    def pose(self, name: str) -> Matrix:
        """
        Return where an object is in the world (4, 4).

        :raises SimulationError: there is none of that name.
        """
        body = self._body(name)
        address = self._free_address(body)
        if address is None:
            xyz, quat = self._model.body_pos[body], self._model.body_quat[body]
        else:
            xyz = self._data.qpos[address : address + 3]
            quat = self._data.qpos[address + 3 : address + 7]
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
            self._model.body_pos[body], self._model.body_quat[body] = pose[:3, 3], quat
            placed = self._plant.spec.body(object_body_name(name))
            placed.pos, placed.quat = pose[:3, 3], quat
            return
        self._data.qpos[address : address + 3] = pose[:3, 3]
        self._data.qpos[address + 3 : address + 7] = quat
        start = int(self._model.body_dofadr[body])
        self._data.qvel[start : start + 6] = 0.0

    def add(self, thing: WorldObject) -> None:
        """
        Put a new object into the running world.

        :raises SimulationError: its name is taken, or the physics refuses it; the world stays
            as it was.
        """
        self._plant.add_object(thing)
        try:
            self._recompile()
        except SimulationError:
            self._plant.remove_object(thing.name)
            raise

    def remove(self, name: str) -> None:
        """
        Take an object out of the running world.

        :raises SimulationError: there is none of that name.
        """
        self._body(name)
        self._plant.remove_object(name)
        self._recompile()

    def _body(self, name: str) -> int:
        if name not in self.names:
            hint = nearest(name, self.names) or f'there are: {", ".join(self.names) or "none"}'
            raise SimulationError(f"the world has no object '{name}'; {hint}")
        return int(self._model.body(object_body_name(name)).id)

    def _free_address(self, body: int) -> int | None:
        """Return where a free object's pose starts in qpos, None for one that never moves."""
        if self._model.body_jntnum[body] == 0:
            return None
        return int(self._model.jnt_qposadr[self._model.body_jntadr[body]])
