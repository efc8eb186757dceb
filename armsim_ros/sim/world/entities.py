# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All that is in a simulation by name: the robots and the objects of the world."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import nearest, SimulationError
from armsim_ros.model.geometry import Geometry, half_extent, Mesh, Plane
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.physics.mujoco_model import Ground, object_body_name
from armsim_ros.sim.simulation import Simulation
from armsim_ros.sim.world.world_scene import WorldEdit


def object_bounds(item: WorldObject) -> tuple[Matrix, Matrix]:
    """Return the smallest and the largest corner of an object in its own axes, (3,) each [m]."""
    corners = []
    for part in item.parts:
        if isinstance(part.geometry, Plane):
            continue
        low, high = _bounds(part.geometry)
        middle = part.origin[:3, :3] @ (0.5 * (low + high)) + part.origin[:3, 3]
        reach = np.abs(part.origin[:3, :3]) @ (0.5 * (high - low))
        corners += [middle - reach, middle + reach]
    if not corners:
        return np.zeros(3), np.zeros(3)
    return np.min(corners, axis=0), np.max(corners, axis=0)


def _bounds(geometry: Geometry) -> tuple[Matrix, Matrix]:
    if isinstance(geometry, Mesh):
        return geometry.vertices.min(axis=0), geometry.vertices.max(axis=0)
    assert not isinstance(geometry, Plane)
    half = half_extent(geometry)
    return -half, half


#: The frame of all poses.
WORLD_FRAME = 'world'


class Category(IntEnum):
    """Constants of ``simulation_interfaces/msg/EntityCategory``."""

    OBJECT = 0
    ROBOT = 1
    HUMAN = 2
    DYNAMIC_OBJECT = 4
    STATIC_OBJECT = 5


class UnknownEntityError(SimulationError):
    """There is no entity of a name."""


@dataclass(frozen=True, slots=True)
class EntityInfo:
    """
    What is known of an entity besides its state.

    :param tags: labels to filter by.
    """

    category: Category
    description: str = ''
    tags: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class EntityState:
    """
    Where an entity is and how it moves, in the world.

    :param pose: (4, 4).
    :param linear: (3,) velocity of its origin [m/s].
    :param angular: (3,) [rad/s].
    :param linear_acceleration: (3,) of its origin [m/s^2].
    :param angular_acceleration: (3,) [rad/s^2].
    """

    pose: Matrix
    linear: Vector = field(default_factory=lambda: np.zeros(3))
    angular: Vector = field(default_factory=lambda: np.zeros(3))
    linear_acceleration: Vector = field(default_factory=lambda: np.zeros(3))
    angular_acceleration: Vector = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True, slots=True)
class RobotEntity:
    """
    A robot of the simulation.

    :param root_link: its pose is the robot's.
    :param links: all its links.
    """

    name: str
    root_link: str
    links: tuple[str, ...]


class Entities:
    """
    Robots and objects by name, with what people know of them.

    Only the thread that ticks may ask for states and change them; names and infos can be asked
    for from any thread.

    :param simulation: holds them.
    :param robots: the robots in it.
    """

    def __init__(self, simulation: Simulation, robots: Iterable[RobotEntity]) -> None:
        self._simulation = simulation
        self._robots = {robot.name: robot for robot in robots}
        self._infos: dict[str, EntityInfo] = {}
        self._loaded = dict(simulation.world.objects)

    @property
    def spawned(self) -> tuple[str, ...]:
        """Names of the objects that came after the world was loaded."""
        return tuple(name for name, item in self._simulation.world.objects.items()
                     if self._loaded.get(name) is not item)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all entities, sorted."""
        return tuple(sorted({*self._robots, *self._simulation.world.names}))

    @property
    def robots(self) -> tuple[str, ...]:
        """Names of the robots."""
        return tuple(self._robots)

    def is_robot(self, name: str) -> bool:
        """Return whether an entity is a robot."""
        return name in self._robots

    def info(self, name: str) -> EntityInfo:
        """
        Return what is known of an entity.

        :raises UnknownEntityError: there is none of that name.
        """
        self._check(name)
        return self._infos.get(name) or EntityInfo(self._category(name))

    def set_info(self, name: str, info: EntityInfo) -> None:
        """
        Replace what is known of an entity.

        :raises UnknownEntityError: there is none of that name.
        """
        self._check(name)
        self._infos[name] = info

    def forget_infos(self) -> None:
        """Have every entity as it is described without :meth:`set_info`."""
        self._infos.clear()

    def state(self, name: str) -> EntityState:
        """
        Return where an entity is and how it moves; ``robot/link`` is an entity, too.

        :raises UnknownEntityError: there is none of that name.
        """
        world, simulation = self._simulation.world, self._simulation
        if name in world.objects:
            return EntityState(world.pose(name), *world.twist(name), *world.acceleration(name))
        link = self._link(name)
        if link is None:
            self._check(name)
        assert link is not None
        return EntityState(simulation.link_pose(link), *simulation.link_motion(link),
                           *simulation.link_acceleration(link))

    def states(self, names: Iterable[str]) -> dict[str, EntityState]:
        """Return the states of those of the names that are there, of the same moment."""
        return {name: self.state(name) for name in names if self.has(name)}

    def bounds(self, name: str) -> tuple[Vector, Vector]:
        """
        Return the smallest and the largest corner of an entity in its own axes, (3,) [m].

        :raises UnknownEntityError: there is none of that name.
        """
        self._check(name)
        robot = self._robots.get(name)
        if robot is None:
            return self._simulation.world.bounds(name)
        return self._simulation.link_bounds(robot.links, robot.root_link)

    def world_bounds(self, name: str) -> tuple[Vector, Vector]:
        """Return the smallest and the largest corner along the world's axes, (3,) each [m]."""
        low, high = self.bounds(name)
        pose = self.state(name).pose
        middle = pose[:3, :3] @ (0.5 * (low + high)) + pose[:3, 3]
        reach = np.abs(pose[:3, :3]) @ (0.5 * (high - low))
        return middle - reach, middle + reach

    def frame_pose(self, frame: str) -> Matrix:
        """
        Return where a frame is in the world (4, 4): the world itself, a link, or an entity.

        :param frame: '' is the world.
        :raises UnknownEntityError: there is no such frame.
        """
        if frame in ('', WORLD_FRAME):
            return np.eye(4)
        if frame in self._simulation.model.links:
            return self._simulation.link_pose(frame)
        return self.state(frame).pose

    def body(self, frame: str) -> int:
        """
        Return the number of the body of a link or a free object in the physics.

        :raises UnknownEntityError: there is no such link or entity.
        :raises SimulationError: an object that is fixed.
        """
        simulation = self._simulation
        item = simulation.world.objects.get(frame)
        if item is None:
            link = frame if frame in simulation.model.links else self._link(frame)
            if link is None:
                self._check(frame)
            assert link is not None
            return simulation.link_body(link)
        if item.mass is None:
            raise SimulationError(f"object '{frame}' is fixed; only what has a mass is moved")
        return int(simulation.mujoco_model.body(object_body_name(frame)).id)

    def set_state(self, name: str, state: EntityState) -> None:
        """
        Put an object somewhere, with a velocity.

        :raises UnknownEntityError: there is none of that name.
        :param state: its acceleration is not used.
        :raises SimulationError: a robot; a velocity or an acceleration for what is fixed.
        """
        if name in self._robots:
            raise SimulationError(
                f"robot '{name}' is fixed to the world; its joints move by its controllers")
        self._check(name)
        if (self._category(name) is Category.STATIC_OBJECT
                and (state.linear_acceleration.any() or state.angular_acceleration.any())):
            raise SimulationError(f"object '{name}' is fixed and cannot have an acceleration")
        self._simulation.world.set_pose(name, state.pose, (state.linear, state.angular))

    def stage_spawn(self, items: Iterable[WorldObject]) -> WorldEdit:
        """Prepare new objects, see :meth:`WorldScene.stage`."""
        return self._simulation.world.stage(add=items)

    def spawn(self, edit: WorldEdit) -> str:
        """
        Add prepared objects; only from the thread that ticks.

        :returns: which other object one of them overlaps, '' where none does.
        :raises OverlapError: a free object overlaps a robot; nothing is added then.
        """
        return self._simulation.world.commit(edit, keep_clear=True)

    def stage_delete(self, names: Iterable[str]) -> WorldEdit:
        """
        Prepare that objects go.

        :raises UnknownEntityError: there is none of a name.
        :raises SimulationError: an entity is a robot.
        """
        names = tuple(names)
        for name in names:
            self._check(name)
            if name in self._robots:
                raise SimulationError(f"robot '{name}' cannot be deleted; end the simulation")
        return self._simulation.world.stage(remove=names)

    def stage_reset(self, *, whole: bool) -> WorldEdit | None:
        """
        Prepare that the objects that were spawned go.

        :param whole: whether those of the loaded world that were deleted come back; then all
            are in the order of the loaded world.
        :returns: None where nothing changes.
        """
        world = self._simulation.world
        if whole and any(world.objects.get(name) is not item
                         for name, item in self._loaded.items()):
            return world.stage(add=self._loaded.values(), remove=world.names)
        spawned = self.spawned
        return world.stage(remove=spawned) if spawned else None

    def commit(self, edit: WorldEdit) -> None:
        """Make a prepared change; only from the thread that ticks."""
        self._simulation.world.commit(edit)
        gone = {item.name for item in edit.removed}
        self._infos = {name: info for name, info in self._infos.items() if name not in gone}

    def stage_load(self, items: Iterable[WorldObject], ground: Ground) -> WorldEdit:
        """Prepare a world in place of the present world."""
        world = self._simulation.world
        return world.stage(add=items, remove=world.names, ground=ground)

    def load(self, edit: WorldEdit) -> None:
        """Take a prepared world in place of the present world; only from the thread that ticks."""
        self.commit(edit)
        self._loaded = {item.name: item for item in edit.added}

    def has(self, name: str) -> bool:
        """Return whether there is an entity, or a link of a robot, of that name."""
        return name in self._simulation.world.objects or self._link(name) is not None

    def free_name(self, requested: str, reserved: Iterable[str] = ()) -> str:
        """Return a name, or with ``_1``, ``_2`` ... behind it the first that is not taken."""
        reserved, number, name = tuple(reserved), 0, requested
        while name in reserved or self.has(name):
            number += 1
            name = f'{requested}_{number}'
        return name

    def _category(self, name: str) -> Category:
        if name in self._robots:
            return Category.ROBOT
        free = self._simulation.world.objects[name].mass is not None
        return Category.OBJECT if free else Category.STATIC_OBJECT

    def _link(self, name: str) -> str | None:
        """Return the link that a robot's name, or ``robot/link``, refers to."""
        robot = self._robots.get(name)
        if robot is not None:
            return robot.root_link
        owner, _, link = name.partition('/')
        robot = self._robots.get(owner)
        return link if robot is not None and link in robot.links else None

    def _check(self, name: str) -> None:
        if name in self._robots or name in self._simulation.world.objects:
            return
        hint = nearest(name, self.names) or f'there are: {", ".join(self.names)}'
        raise UnknownEntityError(f"there is no entity '{name}'; {hint}")


def relative_state(state: EntityState, frame: Matrix) -> EntityState:
    """
    Return a state that was given in a frame as a state in the world.

    :param frame: (4, 4) of the frame; twist and acceleration are given along its axes.
    """
    turn = frame[:3, :3]
    return EntityState(
        frame @ state.pose, turn @ state.linear, turn @ state.angular,
        turn @ state.linear_acceleration, turn @ state.angular_acceleration)
