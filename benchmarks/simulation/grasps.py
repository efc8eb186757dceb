# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How many cubes the fingers put where they should: the example, with poses drawn at random."""

from __future__ import annotations

import math
from pathlib import Path
import random
import subprocess
import sys
import time

from armsim_ros.testing.program import private_domain, ros_environment
from armsim_ros.testing.robot_user import running_robot
from benchmarks.options import Options
from benchmarks.tables import Table

EXAMPLE = Path(__file__).parents[2] / 'examples' / 'pick_with_fingers.py'
#: Robot -> its namespace: fingers by a trajectory controller, and by a gripper controller.
ROBOTS = {'ROBOT': '/ROBOT', 'panda': ''}
#: Where cubes may stand: distance from the arm [m], direction and turn [rad].
NEAR, FAR, ASIDE, TURN = 0.33, 0.46, 0.6, math.pi


def drawn_place(numbers: random.Random) -> list[str]:
    """Return x, y [m] and the turn [rad] of a cube."""
    distance, angle = numbers.uniform(NEAR, FAR), numbers.uniform(-ASIDE, ASIDE)
    turn = numbers.uniform(-TURN, TURN)
    values = distance * math.cos(angle), distance * math.sin(angle), turn
    return [f'{value:.3f}' for value in values]


def main(options: Options) -> None:
    """Run the example ``--runs`` times with each robot, ten or more for a figure that tells."""
    for robot, namespace in ROBOTS.items():
        grasps(robot, namespace, options)


def grasps(robot: str, namespace: str, options: Options) -> None:
    """Run the example with one robot and print how it ended."""
    numbers = random.Random(options.seed)
    rows: list[tuple[str, ...]] = []
    with private_domain() as domain, running_robot(
        f'robot:={robot}', 'world:=empty', namespace=namespace, domain=domain):
        good = 0
        for _ in range(options.runs):
            start, end = drawn_place(numbers), drawn_place(numbers)
            begin = time.monotonic()
            run = subprocess.run(
                [sys.executable, str(EXAMPLE), '--robot', robot, '--from', *start, '--to', *end],
                env=ros_environment(domain), capture_output=True, text=True, check=False)
            good += run.returncode == 0
            last = (run.stdout if run.returncode == 0 else run.stderr).strip().splitlines()[-1:]
            seconds = f'{time.monotonic() - begin:.1f}'
            rows.append((' '.join(start), ' '.join(end), seconds, *last))
            print(*rows[-1], flush=True)
    Table(f'{robot}: {good} of {options.runs} cubes are where they should be',
          ('from', 'to', 'time [s]', 'how it ended'), rows).print()
