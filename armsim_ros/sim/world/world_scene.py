# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The objects of the running world: where they are, come and go."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import nearest, SimulationError
from armsim_ros.model.transforms import (
    matrix_from_quat_wxyz,
    pose_from_parts,
    quat_wxyz_from_matrix,
)
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.physics.geoms import contacts
from armsim_ros.sim.physics.mujoco_model import Ground, object_body_name
from armsim_ros.sim.physics.plant import Plant, StagedPlant
from armsim_ros.sim.world.hull_overlaps import LEAST_OVERLAP

Places = NDArray[np.intp]

_PREFIX = object_body_name('')


class OverlapError(SimulationError):
    """A new object would overlap a robot."""


class WorldEdit(NamedTuple):
    """
    A change of the world, compiled and not yet made.

    :param staged: the physics after it.
    :param added: objects that it adds.
    :param removed: objects that it removes.
    :param ground: floor and gravity after it.
    """

    staged: StagedPlant
    added: tuple[WorldObject, ...]
    removed: tuple[WorldObject, ...]
    ground: Ground


class WorldScene:
    """
    World objects of a simulation, by name.

    To compile a changed world takes milliseconds, in ``stage``, which may run beside the loop;
    ``commit`` swaps between two steps. Only one change at a time may be on its way, and where
    fixed objects are moved meanwhile, that move is lost.

    :param plant: the physics that holds them.
    :param items: the objects that it was built with.
    :param ground: its floor and gravity.
    """

    def __init__(self, plant: Plant, items: Iterable[WorldObject], ground: Ground) -> None:
        self._plant = plant
        self._things = {item.name: item for item in items}
        self._ground = ground
        self._free: tuple[Any, tuple[str, ...], Places] | None = None
        self.version = 0
        """Counts the changes of what there is, and of where fixed objects are."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all objects."""
        return tuple(self._things)

    @property
    def objects(self) -> Mapping[str, WorldObject]:
        """Name -> the object as it came into the world, with the pose that it had then."""
        return MappingProxyType(self._things)

    @property
    def floor(self) -> float | None:
        """Height of the floor [m]; None where there is none."""
        return self._ground.floor

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

    def free_poses(self) -> tuple[tuple[str, ...], Matrix]:
        """Return the free objects and where they are: (n, 7) positions, quaternions wxyz."""
        model = self._plant.model
        if self._free is None or self._free[0] is not model:
            names = tuple(name for name, item in self._things.items() if item.mass is not None)
            starts = [self._free_address(self._body(name)) or 0 for name in names]
            places = np.array(starts, dtype=np.intp)[:, None] + np.arange(7)
            self._free = model, names, places
        _, names, places = self._free
        return names, self._plant.data.qpos[places]

    def twist(self, name: str) -> tuple[Vector, Vector]:
        """
        Return how an object moves: (3,) [m/s] at its origin and (3,) [rad/s], world axes.

        :raises SimulationError: there is none of that name.
        """
        body = self._body(name)
        address = self._free_address(body)
        if address is None:
            return np.zeros(3), np.zeros(3)
        start = int(self._plant.model.body_dofadr[body])
        velocity = self._plant.data.qvel[start : start + 6]
        rotation = matrix_from_quat_wxyz(self._plant.data.qpos[address + 3 : address + 7])
        return velocity[:3].copy(), rotation @ velocity[3:]

    def acceleration(self, name: str) -> tuple[Vector, Vector]:
        """
        Return the acceleration of an object's origin, see :meth:`Plant.acceleration`.

        :raises SimulationError: there is none of that name.
        """
        return self._plant.acceleration(self._body(name))

    def set_pose(
        self, name: str, pose: Matrix, twist: tuple[Vector, Vector] | None = None
    ) -> None:
        """
        Put an object elsewhere, at rest unless a twist is given.

        :param pose: (4, 4) in the world.
        :param twist: (3,) [m/s] of its origin and (3,) [rad/s], world axes.
        :raises SimulationError: there is none of that name, or it is fixed and shall move.
        """
        body = self._body(name)
        address = self._free_address(body)
        linear, angular = twist or (np.zeros(3), np.zeros(3))
        if address is None:
            if linear.any() or angular.any():
                raise SimulationError(f"object '{name}' is fixed and cannot have a velocity")
            self._place_fixed(name, pose)
            self._plant.wake()
            return
        self._plant.data.qpos[address : address + 3] = pose[:3, 3]
        self._plant.data.qpos[address + 3 : address + 7] = quat_wxyz_from_matrix(pose)
        start = int(self._plant.model.body_dofadr[body])
        self._plant.data.qvel[start : start + 3] = linear
        self._plant.data.qvel[start + 3 : start + 6] = pose[:3, :3].T @ angular

    def return_to_start(self) -> None:
        """Put the fixed objects back; the physics does so with the free ones at its reset."""
        for name, item in self._things.items():
            if item.mass is None:
                self._place_fixed(name, item.pose)

    def bounds(self, name: str) -> tuple[Vector, Vector]:
        """
        Return the smallest and the largest corner of an object in its own axes, (3,) each [m].

        :raises SimulationError: there is none of that name.
        """
        return self._plant.bounds([self._body(name)], self._body(name))

    def stage(
        self, add: Iterable[WorldObject] = (), remove: Iterable[str] = (),
        ground: Ground | None = None
    ) -> WorldEdit:
        """
        Prepare a change of the world; from any thread, while no other change is on its way.

        :param ground: floor and gravity then; None leaves them as they are.
        :raises SimulationError: a name is taken or not there, or the physics refuses an object;
            the world stays as it was.
        """
        added, spec = tuple(add), self._plant.spec
        for name in remove:
            self._body(name)
        removed = tuple(self._things[name] for name in remove)
        ground = ground or self._ground
        done: list[WorldObject] = []
        try:
            for item in removed:
                spec.remove_object(item.name)
            for item in added:
                spec.add_object(item)
                done.append(item)
            spec.set_ground(ground)
            staged = self._plant.stage()
        except Exception:
            self._undo(done, removed)
            raise
        return WorldEdit(staged, added, removed, ground)

    def commit(self, edit: WorldEdit, *, keep_clear: bool = False) -> str:
        """
        Make a staged change, between two steps.

        :param keep_clear: refuse what would overlap a robot, if it is free to move.
        :returns: which other object a new one overlaps most, so that they will be pushed apart;
            '' where none does.
        :raises OverlapError: a new object overlaps a robot; the change is undone.
        """
        remarks: list[str] = []
        try:
            self._plant.adopt(edit.staged, lambda model, data: remarks.extend(
                _judged_overlaps(model, data, edit.added) if keep_clear else ()))
        except OverlapError:
            self._undo(edit.added, edit.removed)
            raise
        for item in edit.removed:
            del self._things[item.name]
        self._things.update((item.name, item) for item in edit.added)
        self._ground = edit.ground
        self.version += 1
        return remarks[0] if remarks else ''

    def add(self, item: WorldObject) -> None:
        """
        Put a new object into the running world.

        :raises SimulationError: its name is taken, or the physics refuses it; the world stays
            as it was.
        """
        self.commit(self.stage(add=[item]))

    def remove(self, name: str) -> None:
        """
        Take an object out of the running world.

        :raises SimulationError: there is none of that name.
        """
        self.commit(self.stage(remove=[name]))

    def _undo(self, added: Iterable[WorldObject], removed: Iterable[WorldObject]) -> None:
        spec = self._plant.spec
        for item in added:
            spec.remove_object(item.name)
        for item in removed:
            spec.add_object(replace(item, pose=self.pose(item.name)))
        spec.set_ground(self._ground)

    def _place_fixed(self, name: str, pose: Matrix) -> None:
        body, quat = self._body(name), quat_wxyz_from_matrix(pose)
        self._plant.model.body_pos[body], self._plant.model.body_quat[body] = pose[:3, 3], quat
        placed = self._plant.spec.spec.body(object_body_name(name))
        placed.pos, placed.quat = pose[:3, 3], quat
        self.version += 1

    def _body(self, name: str) -> int:
        if name not in self._things:
            hint = nearest(name, self.names) or f'there are: {", ".join(self.names) or "none"}'
            raise SimulationError(f"the world has no object '{name}'; {hint}")
        return int(self._plant.model.body(object_body_name(name)).id)

    def _free_address(self, body: int) -> int | None:
        """Return where a free object's pose starts in qpos, None for one that never moves."""
        if self._plant.model.body_jntnum[body] == 0:
            return None
        return int(self._plant.model.jnt_qposadr[self._plant.model.body_jntadr[body]])


def _judged_overlaps(model: Any, data: Any, added: Iterable[WorldObject]) -> list[str]:
    """Return which objects overlap new ones, the deepest first; refuse what overlaps a robot."""
    new = {object_body_name(item.name): item.mass is not None for item in added}
    remarks = []
    for contact in contacts(model, data):
        if contact.depth <= LEAST_OVERLAP:
            break
        for mine, other in (contact.bodies, contact.bodies[::-1]):
            if mine not in new or other == 'world':
                continue
            pair = (f"'{mine.removeprefix(_PREFIX)}'", f"'{other.removeprefix(_PREFIX)}' by "
                    f'{contact.depth * 1e3:.1f} mm')
            if other.startswith(_PREFIX):
                remarks.append(f'{pair[0]} overlaps {pair[1]}: they will be pushed apart')
            elif new[mine]:
                raise OverlapError(f'{pair[0]} would overlap {pair[1]}; put it elsewhere')
    return remarks
