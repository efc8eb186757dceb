# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What edits of the world cost a moving arm, and whether the planning scene keeps to the rules."""

from __future__ import annotations

from pathlib import Path
from threading import Thread
import time

from geometry_msgs.msg import PoseStamped
from simulation_interfaces.srv import DeleteEntity, SpawnEntity

from benchmarks.controllers.control_thread import goals_without_pause
from benchmarks.options import Options
from benchmarks.simulation.real_time import KEPT, watched
from benchmarks.simulation.scene_edits import SceneEdits
from benchmarks.stack import median, percentile, resident_mib, running_stack, Stack
from benchmarks.tables import machine_load, replace_section, Table

#: Objects that come and go while the arm moves.
OBJECTS = 200
BOX = 'armsim://box?size=0.05,0.05,0.05&mass=0.1'
TIMEOUT = 60.0


def main(options: Options) -> None:
    """Print the tables; write them where ``--report`` says."""
    with running_stack('robot:=sunday') as stack, goals_without_pause(stack, 'sunday'):
        phases = [watched('moving', [stack], options)]
        times: list[float] = []
        _come_and_go(stack, OBJECTS // 10, [])
        before = resident_mib(stack.processes()['simulation'])
        edits = Thread(target=_come_and_go, args=(stack, OBJECTS, times))
        edits.start()
        phases.append(watched(f'moving, {OBJECTS} objects come and go', [stack], options))
        edits.join()
        after = resident_mib(stack.processes()['simulation'])
    with running_stack('robot:=sunday') as stack:
        scene, began = SceneEdits(stack.client, options.seed), time.monotonic()
        scene.run(options.edits)
        took = time.monotonic() - began
    kinds = ', '.join(f'{count} {kind}' for kind, count in sorted(scene.counts.items()))
    tables = (
        Table('Edits of the world: the control loop meanwhile', KEPT,
              [(phase.name, *phase.kept) for phase in phases]),
        Table('Edits of the world: from the request to the answer',
              ('requests', 'p50 ms', 'p95 ms', 'simulation before MiB', 'after MiB'),
              [(f'{len(times)} spawns and deletions', f'{median(times):.1f}',
                f'{percentile(times, 0.95):.1f}', f'{before:.1f}', f'{after:.1f}')]),
        Table('Edits of world and scene by turns', ('edits', 'of which', 'as the rules say', 's'),
              [(str(options.edits), kinds, 'after each of them', f'{took:.0f}')]),
    )
    lines: list[str] = []
    for table in tables:
        table.print()
        lines += table.markdown()
    if options.report:
        replace_section(Path(options.report), 'world edits', [machine_load(), '', *lines])


def _come_and_go(stack: Stack, count: int, times: list[float]) -> None:
    """Spawn and delete an object so many times, and note how long each answer took [ms]."""
    for number in range(count):
        name = f'guest_{number}'
        spawn = SpawnEntity.Request(name=name, uri=BOX, initial_pose=PoseStamped())
        place = spawn.initial_pose.pose.position
        place.x, place.y, place.z = 2.0, 2.0, 0.1
        for service, kind, request in (
            ('/spawn_entity', SpawnEntity, spawn),
            ('/delete_entity', DeleteEntity, DeleteEntity.Request(entity=name)),
        ):
            began = time.monotonic()
            result = stack.client.call(service, kind, request, timeout=TIMEOUT).result
            assert result.result == result.RESULT_OK, result.error_message
            times.append(1000.0 * (time.monotonic() - began))
