# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What overlaps at the start.

The physics takes a mesh for its convex hull. Where hulls of a robot overlap at the start, they
would push it all the time, so convex parts of the meshes take their place.
"""

from __future__ import annotations

from typing import Any

import mujoco

from armsim_ros.model.geometry import Mesh
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.sim.physics.contacts import contacts
from armsim_ros.sim.physics.plant import Plant

#: Overlap at the start that is worth a word [m].
START_OVERLAP = 1e-3

Depths = dict[tuple[str, str], float]


def resolve_overlaps(plant: Plant, model: RobotModel) -> list[str]:
    """
    Let no link be pushed because its mesh's hull is larger than the mesh.

    Two links of the robot that still overlap as convex parts pass through each other.

    :param plant: at the start; where hulls overlap it is compiled again.
    :param model: the robot.
    :returns: a line for each pair that overlaps and has a link of the robot in it.
    """
    links = {plant.spec.name(name): name for name in model.links}
    found = _overlaps(plant, links)
    meshes = {body for pair in found for body in pair
              if body in links and _is_mesh(model, links[body])}
    parts = {body: plant.spec.robot.decompose(links[body]) for body in sorted(meshes)}
    lines: list[str] = []
    if any(parts.values()):
        plant.recompile()
        before, found = found, _overlaps(plant, links)
        lines = [_parts_line(pair, depth, parts) for pair, depth in before.items()
                 if pair not in found]
    inseparable = [pair for pair in found if links.keys() >= set(pair) and meshes & set(pair)]
    for first, second in inseparable:
        plant.spec.robot.exclude(links[first], links[second])
    if inseparable:
        plant.recompile()
    return lines + [_line(pair, depth, pair in inseparable) for pair, depth in found.items()]


def _overlaps(plant: Plant, links: dict[str, str]) -> Depths:
    """Return pair of bodies -> how deep they overlap [m], for those with a link in them."""
    data: Any = plant.data
    mujoco.mj_forward(plant.model, data)
    found: Depths = {}
    for contact in contacts(plant.model, data):
        if contact.depth > START_OVERLAP and not links.keys().isdisjoint(contact.bodies):
            found.setdefault(contact.bodies, contact.depth)
    return found


def _is_mesh(model: RobotModel, link: str) -> bool:
    return any(isinstance(shape.geometry, Mesh) for shape in model.links[link].collisions)


def _parts_line(pair: tuple[str, str], depth: float, parts: dict[str, int]) -> str:
    counts = ' and '.join(f"{parts[body]} of '{body}'" for body in pair if parts.get(body))
    return (f"the hulls of '{pair[0]}' and '{pair[1]}' overlap by {depth * 1e3:.1f} mm at the "
            f'start, so the physics takes convex parts: {counts}')


def _line(pair: tuple[str, str], depth: float, passes: bool) -> str:
    first, second = pair
    text = f"'{first}' and '{second}' overlap by {depth * 1e3:.1f} mm at the start"
    if passes:
        return (f'{text} and pass through each other in the physics; move the robot, or disable '
                'the pair in the SRDF')
    return f'{text}; move the robot or the object, or disable the pair in the SRDF'
