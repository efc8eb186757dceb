# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Planning beside and around the cells of an octomap, compared with boxes of the same shape.

Processor time of a plan of the Panda, the median of the requests of a scene: a wall of 12,800
cells beside the arm, and a pillar of cells in its way, with the same pillar as a single box.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
import statistics
import time

import numpy as np

from armsim_ros import ArmSim
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.budget import CountingClock
from armsim_ros.planning.request import Constraints, MotionPlanRequest
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.octomap import octomap_from_cells
from benchmarks.options import Options
from benchmarks.tables import machine_load, replace_section, Table

RESOLUTION = 0.025
REQUESTS = 14
#: Lowest cells and numbers of cells along x, y, z.
Block = tuple[tuple[int, int, int], tuple[int, int, int]]
WALL: Block = ((-32, 30, 0), (80, 2, 80))
PILLAR: Block = ((16, -2, 0), (5, 5, 30))


def main(options: Options) -> None:
    """Print the times."""
    sim = ArmSim('panda', overrides={'planning_parameters.scene_from_world': 'false'})
    rows = []
    for name, cells, boxes in (
        ('nothing', (), ()), ('wall of cells', (WALL,), ()), ('wall as a box', (), (WALL,)),
        ('pillar of cells', (PILLAR,), ()), ('pillar as a box', (), (PILLAR,)),
        ('both of cells', (WALL, PILLAR), ()), ('both as boxes', (), (WALL, PILLAR)),
    ):
        _put(sim, cells, boxes)
        times, solved = _plans(sim)
        rows.append((name, str(sum(np.prod(block[1]) for block in cells)),
                     f'{1e3 * statistics.median(times):.0f}', f'{1e3 * sum(times):.0f}',
                     f'{solved} of {REQUESTS}'))
    table = Table('Panda [ms of processor time]', ('scene', 'cells', 'median', 'all', 'solved'),
                  rows)
    table.print()
    if options.report:
        replace_section(Path(options.report), 'octomap_planning', [
            machine_load(), '', *table.markdown()])


def _put(sim: ArmSim, cells: Sequence[Block], boxes: Sequence[Block]) -> None:
    sim.scene.clear()
    sim.scene.set_octomap(None)
    if cells:
        keys = np.vstack([
            np.stack(np.meshgrid(*map(np.arange, count), indexing='ij'), -1).reshape(-1, 3) + low
            for low, count in cells])
        sim.scene.set_octomap(octomap_from_cells(
            keys, np.ones(len(keys), dtype=np.float32), RESOLUTION, np.eye(4)))
    for number, (low, count) in enumerate(RESOLUTION * np.array(boxes).reshape(-1, 2, 3)):
        sim.scene.apply_object(CollisionObject(
            f'box_{number}', pose=pose_matrix(low + 0.5 * count),
            shapes=(ObjectShape(Box(tuple(count.tolist()))),)))


def _plans(sim: ArmSim) -> tuple[list[float], int]:
    """Return the times [s] of the requests, and how many were solved."""
    times, solved = [], 0
    for number in range(-1, REQUESTS):
        side = 1.0 if number % 2 else -1.0
        start, goal = ({f'panda_joint{k}': value for k, value in enumerate(
            (turn, 0.35, 0.0, -1.9 - 0.05 * (number // 2), 0.0, 2.25, 0.785), 1)}
            for turn in (-0.9 * side, 0.9 * side))
        sim.scene.set_positions(start)
        request = MotionPlanRequest(
            group_name='panda_arm', goal_constraints=(Constraints.of_joints(goal),),
            seed=number + 1)
        begin = time.process_time()
        response = sim.planner.plan(request, sim.scene.snapshot(), clock=CountingClock())
        if number >= 0:  # the first makes tables that the others use
            times.append(time.process_time() - begin)
            solved += response.success
    return times, solved
