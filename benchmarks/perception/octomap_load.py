# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What clouds at 10 Hz cost the control loop and planning; in a page with ``--report``."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

from moveit_msgs.msg import PlanningSceneComponents
from moveit_msgs.srv import GetPlanningScene

from benchmarks.options import Options
from benchmarks.perception.cloud_publisher import PUBLISHED
from benchmarks.simulation.camera import moving_and_planning, PLANS
from benchmarks.simulation.real_time import phase_tables
from benchmarks.stack import peer, running_stack, Stack
from benchmarks.tables import machine_load, replace_section, Table

RATE = 10
CLOUDS = '/camera/depth/points', 'camera_color_optical_frame'


def main(options: Options) -> None:
    """Print the tables; write them where ``--report`` says."""
    phases, plans = [], []
    for name, words in (('without an octomap', ()),
                        (f'octomap of clouds at {RATE} Hz', ('octomap:=true',))):
        with running_stack('robot:=sunday', *words) as stack, ExitStack() as opened:
            # In both phases: a driver takes its own processor time.
            driver = opened.enter_context(peer(
                'perception.cloud_publisher', *CLOUDS, str(RATE), domain=stack.domain))
            driver.wait_for_line(PUBLISHED, 60.0)
            phase, row = moving_and_planning(name, stack, options, driver.output)
            print(f'{name}: {_nodes(stack)} bytes of octomap', flush=True)
        phases.append(phase)
        plans.append(row)
    lines: list[str] = []
    tables = (*phase_tables(phases, 'Octomaps'), Table('Octomaps: planning', PLANS, plans))
    for table in tables:
        table.print()
        lines += table.markdown()
    if options.report:
        replace_section(Path(options.report), 'octomap_load', [machine_load(), '', *lines])


def _nodes(stack: Stack) -> int:
    """Return the size of the octomap in the scene."""
    request = GetPlanningScene.Request()
    request.components.components = PlanningSceneComponents.OCTOMAP
    scene = stack.client.call('/get_planning_scene', GetPlanningScene, request).scene
    return len(scene.world.octomap.octomap.data)
