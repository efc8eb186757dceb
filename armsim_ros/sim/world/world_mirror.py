# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Differences of the world since an earlier snapshot."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
import math
from typing import NamedTuple

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.model.grippers import Gripper
from armsim_ros.model.transforms import (
    matrix_from_quat_wxyz,
    pose_from_parts,
    quat_wxyz_from_matrix,
)
from armsim_ros.model.world_objects import FLOOR, floor_object, WorldObject
from armsim_ros.sim.vacuum_gripper import VacuumGripper
from armsim_ros.sim.world.world_scene import WorldScene

#: Smaller motions are not reported [m], [rad].
LEAST_WAY, LEAST_TURN = 1e-3, math.radians(0.5)


class Holder(NamedTuple):
    """
    What holds an object.

    :param link: that the object goes with.
    :param touch_links: links that may touch it then.
    """

    link: str
    touch_links: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class WorldSnapshot:
    """
    The world at a moment.

    :param epoch: counts how often it began anew.
    :param objects: name -> object, the floor among them.
    :param poses: name -> (7,) position and quaternion wxyz in the world.
    :param held: object -> what holds it.
    """

    epoch: int
    objects: Mapping[str, WorldObject]
    poses: Mapping[str, Vector]
    held: Mapping[str, Holder] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class WorldNews:
    """
    What has changed since the last report.

    :param added: new objects, or all; with (4, 4) poses.
    :param moved: name -> (4, 4).
    :param removed: names.
    :param grasped: objects and their holders that go together from now on.
    :param released: those that do no more; this comes first, grasps come last.
    """

    added: tuple[tuple[WorldObject, Matrix], ...] = ()
    moved: tuple[tuple[str, Matrix], ...] = ()
    removed: tuple[str, ...] = ()
    grasped: tuple[tuple[str, Holder], ...] = ()
    released: tuple[tuple[str, Holder], ...] = ()

    @property
    def empty(self) -> bool:
        """Whether nothing has changed."""
        return not (self.added or self.moved or self.removed or self.grasped or self.released)


class WorldWatch:
    """
    Takes snapshots of a world; only in the thread that ticks.

    :param world: is read.
    :param grippers: may hold objects.
    :param fingers: returns what fingers hold: object -> gripper.
    """

    def __init__(
        self, world: WorldScene, grippers: Iterable[VacuumGripper] = (),
        fingers: Callable[[], Mapping[str, Gripper]] | None = None
    ) -> None:
        self._world = world
        self._version = -1
        self._grippers = tuple(grippers)
        self._fingers = fingers
        self._objects: dict[str, WorldObject] = {}
        self._fixed: dict[str, Vector] = {}
        self.epoch = 0

    def look(self) -> WorldSnapshot:
        """Return the world as it is now."""
        world = self._world
        if world.version != self._version:
            self._version = world.version
            self._objects = dict(world.objects)
            if world.floor is not None:
                self._objects.setdefault(FLOOR, floor_object(world.floor))
            self._fixed = {
                name: _row(world.pose(name) if name in world.objects else item.pose)
                for name, item in self._objects.items() if item.mass is None}
        names, rows = world.free_poses()
        held: dict[str, Holder] = {}
        if self._fingers is not None:
            held.update((name, Holder(gripper.palm, gripper.links))
                        for name, gripper in self._fingers().items())
        held.update((cup.held, Holder(cup.settings.link, (cup.settings.link,)))
                    for cup in self._grippers if cup.held in names)
        poses = {**self._fixed, **dict(zip(names, rows, strict=True))}
        return WorldSnapshot(self.epoch, self._objects, poses, held)


class WorldMirror:
    """Remembers what was reported, and finds the changes."""

    def __init__(self) -> None:
        self._reported: dict[str, tuple[WorldObject, Vector]] = {}
        self._held: dict[str, Holder] = {}
        self._epoch = -1

    def news(self, now: WorldSnapshot, *, whole: bool = False) -> WorldNews:
        """
        Return what has changed, and mark it as reported.

        Where an object is that a link holds, is known by the link, from where it was exactly.

        :param whole: report all objects, for a new subscriber.
        """
        whole = whole or now.epoch != self._epoch
        self._epoch = now.epoch
        removed = tuple(name for name in self._reported if name not in now.objects)
        for name in removed:
            del self._reported[name]
        released = tuple(pair for pair in self._held.items() if now.held.get(pair[0]) != pair[1])
        grasped = tuple(pair for pair in now.held.items()
                        if whole or self._held.get(pair[0]) != pair[1])
        begun = {name for name, _ in grasped}
        self._held = dict(now.held)
        for name, _ in released:
            self._reported.pop(name, None)
        added, moved = [], []
        for name, item in now.objects.items():
            row, known = now.poses[name], self._reported.get(name)
            if whole or known is None or known[0] is not item:
                added.append((item, _pose(row)))
            elif (name in begun and not np.array_equal(known[1], row)) or (
                    name not in now.held and _apart(known[1], row)):
                moved.append((name, _pose(row)))
            else:
                continue
            self._reported[name] = item, row
        return WorldNews(tuple(added), tuple(moved), removed, grasped, released)


def _row(pose: Matrix) -> Vector:
    return np.concatenate([pose[:3, 3], quat_wxyz_from_matrix(pose)])


def _pose(row: Vector) -> Matrix:
    return pose_from_parts(row[:3], matrix_from_quat_wxyz(row[3:]))


def _apart(first: Vector, second: Vector) -> bool:
    """Return whether two poses differ by more than is worth a word."""
    way = float(np.linalg.norm(second[:3] - first[:3]))
    if not way <= LEAST_WAY:
        return True
    cosine = abs(float(first[3:].dot(second[3:])))
    return 2.0 * math.acos(min(1.0, cosine)) > LEAST_TURN
