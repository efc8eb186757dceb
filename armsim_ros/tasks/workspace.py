# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where a task happens: table, objects, marks, cameras, light, and where the arm starts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.config.world import WorldObjectSettings, WorldSettings
from armsim_ros.env.variation import field_of_view
from armsim_ros.errors import ConfigError, Problem
from armsim_ros.model.cell import Cell
from armsim_ros.sim.assembly import build_simulation
from armsim_ros.tasks.hand import HandModel

#: Edge of the cubes [m].
CUBE = 0.04
_CUBE_MASS = 0.1
_TABLE_THICKNESS = 0.03
#: Of other robots: height of the hand over the table at the start [m].
_CLEARANCE = 0.15
TABLE = 'table'
Box = tuple[tuple[float, ...], tuple[float, ...]]


@dataclass(frozen=True)
class Workspace:
    """
    The place of a task.

    :param centre: of the area in which objects are put, x and y in the world [m].
    :param half: half of its size, x and y [m].
    :param surface: height of the table's top [m].
    :param table: size of the table, x and y [m].
    :param table_at: its middle, x and y [m].
    :param start: named state in which the arm starts, '' for the start of its files.
    """

    centre: tuple[float, float]
    half: tuple[float, float]
    surface: float
    table: tuple[float, float]
    table_at: tuple[float, float]
    start: str = ''

    def on_table(self, height: float = 0.5 * CUBE, share: float = 1.0) -> Box:
        """Return the smallest and largest position of something so high over the table [m]."""
        return self.above(height, height, share)

    def above(self, low: float, high: float, share: float = 1.0) -> Box:
        """
        Return the smallest and largest position between two heights over the table [m].

        :param share: of the area, about its middle.
        """
        (x, y), (dx, dy) = self.centre, (share * half for half in self.half)
        return ((x - dx, y - dy, self.surface + low), (x + dx, y + dy, self.surface + high))


#: Places that suit the included robots.
_KNOWN = {
    'sunday': Workspace((0.095, 0.23), (0.08, 0.045), 1.015, (1.5, 0.8), (0.0, 0.0), 'scan_food'),
    'panda': Workspace((0.45, 0.0), (0.09, 0.12), 0.02, (0.5, 0.8), (0.45, 0.0)),
}


def workspace_of(cell: Cell) -> Workspace:
    """
    Return the place of a robot; below the hand at its start where the robot is not known.

    :raises ConfigError: several robots.
    """
    if len(cell.robots) > 1:
        raise ConfigError(Problem(
            f'a task is for one robot, not for {len(cell.robots)}', allowed='a single robot'))
    known = _KNOWN.get(cell.robots[0].name)
    if known is not None:
        return known
    simulation = build_simulation(cell.settings, cell.model)
    x, y, z = HandModel.of(cell).point(simulation).tolist()
    return Workspace((x, y), (0.06, 0.06), z - _CLEARANCE, (0.3, 0.3), (x, y))


def cube_settings(color: tuple[float, float, float]) -> WorldObjectSettings:
    """Return a cube."""
    return WorldObjectSettings.model_validate({
        'parts': [{'shape': {'type': 'box', 'size': [CUBE] * 3}}], 'mass': _CUBE_MASS,
        'color': (*color, 1.0)})


def task_cell(
    cell: Cell, place: Workspace, cubes: Iterable[tuple[str, tuple[float, float, float]]]
) -> Cell:
    """
    Return a robot in the world of a task.

    :param cubes: name and colour of each.
    """
    x, y, _ = place.on_table()[0]
    height = place.surface + 0.5 * CUBE
    objects = {TABLE: WorldObjectSettings.model_validate({
        'parts': [{'shape': {'type': 'box', 'size': [*place.table, _TABLE_THICKNESS]}}],
        'xyz': (*place.table_at, place.surface - 0.5 * _TABLE_THICKNESS),
        'color': (0.72, 0.66, 0.58, 1.0)})}
    for i, (name, color) in enumerate(cubes):
        item = cube_settings(color)
        objects[name] = item.model_copy(update={'xyz': (x, y + 2 * CUBE * i, height)})
    world = WorldSettings(floor=cell.settings.world.floor, gravity=cell.settings.world.gravity,
                          objects=objects)
    simulation = cell.settings.simulation
    if place.start:
        states = cell.model.semantic.named_states
        start = next(group[place.start] for group in states.values() if place.start in group)
        simulation = simulation.model_copy(update={
            'initial_positions': {**simulation.initial_positions, **start}})
    settings = cell.settings.model_copy(update={
        'world': world, 'world_file': None, 'simulation': simulation})
    return Cell(settings, cell.model, cell.robots)


TARGET = 'target'
#: Camera -> where it is from the middle of the workspace [m], and its focal length [heights].
CAMERAS: dict[str, tuple[tuple[float, float, float], float]] = {
    'front': ((0.0, 0.45, 0.35), 1.1),
    'side': ((0.5, 0.05, 0.25), 1.1),
    'top': ((0.0, 0.02, 0.6), 1.1),
}
LARGEST_PICTURE = 640


def decorate(spec: Any, place: Workspace, mark: str) -> None:
    """
    Add cameras, light and mark to a specification.

    :param mark: ``disc`` on the table, ``ball`` in the air, or nothing.
    """
    middle = np.array([*place.centre, place.surface + 0.03])
    away = middle[:2] / max(1e-9, float(np.linalg.norm(middle[:2])))
    turn = np.array([[away[1], away[0]], [-away[0], away[1]]])  # y points away from the robot
    for name, (offset, focal) in CAMERAS.items():
        position = middle + np.append(turn @ np.array(offset[:2]), offset[2])
        spec.worldbody.add_camera(
            name=name, pos=position, quat=_looking(middle - position), fovy=field_of_view(focal))
    spec.worldbody.add_light(
        name='light', pos=[*place.centre, place.surface + 1.5], dir=[0.0, 0.0, -1.0],
        diffuse=[0.5, 0.5, 0.5], castshadow=False)
    size = spec.visual.global_
    size.offwidth, size.offheight = LARGEST_PICTURE, LARGEST_PICTURE
    if mark:
        kind = mujoco.mjtGeom.mjGEOM_CYLINDER if mark == 'disc' else mujoco.mjtGeom.mjGEOM_SPHERE
        spec.worldbody.add_site(
            name=TARGET, pos=middle, type=kind, rgba=[0.1, 0.7, 0.2, 0.6],
            size=[0.03, 0.001, 0.0] if mark == 'disc' else [0.015, 0.0, 0.0])


def _looking(way: Vector) -> Vector:
    """Return the quaternion wxyz of a camera of MuJoCo's that looks along a way, upright."""
    back = -way / np.linalg.norm(way)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    quaternion = np.empty(4)
    matrix = np.column_stack((right, np.cross(back, right), back))
    mujoco.mju_mat2Quat(quaternion, matrix.ravel())
    return quaternion
