# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
How long a test waits for its arm, and what it costs to move it.

Each run is a fresh Python: what is told of the first arm has all imports and all files in it.
Wall time; processor time beside it, which other programs disturb less.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from typing import Any

from armsim_ros.testing.program import private_domain
from benchmarks.options import Options
from benchmarks.stack import median
from benchmarks.tables import Table

#: Simulated time of the motion [s].
MOTION = 5.0


def main(options: Options) -> None:
    """Print wall and processor time of some runs in each mode."""
    for mode, title in (('inprocess', "In the test's process"), ('process', 'Programs over DDS')):
        runs = [_measured(mode, options.robot) for _ in range(options.runs)]
        rows = [
            (what, *(f'{value:.3f}' for place in range(2) for value in (
                median([run[what][place] for run in runs]),
                max(run[what][place] for run in runs))))
            for what in runs[0]]
        Table(f'{title}, {options.runs} runs [s]',
              ('what', 'median wall', 'worst wall', 'median CPU', 'worst CPU'), rows).print()


def _measured(mode: str, robot: str) -> dict[str, tuple[float, float]]:
    command = [sys.executable, '-m', 'benchmarks.bringup.testing', mode, robot]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    return dict(json.loads(done.stdout.splitlines()[-1]))


def in_process(robot: str) -> dict[str, tuple[float, float]]:
    """Return what was measured of arms in this process."""
    begin = _now()
    from armsim_ros.testing.in_process import InProcessArm
    from armsim_ros.testing.stacks import built_cell

    arm = InProcessArm(built_cell(robot, None, {}))
    first = _now()
    again = InProcessArm(built_cell(robot, None, {}))
    second = _now()
    again.wait(MOTION)
    rested = _now()
    turned = dict.fromkeys(arm.joints, 0.2)
    arm.follow([(MOTION, turned)])
    return {
        'first arm up': _past(begin, first), 'arm of the next test': _past(first, second),
        f'{MOTION:g} s at rest': _past(second, rested),
        f'{MOTION:g} s of motion': _past(rested, _now()),
    }


def over_dds(robot: str) -> dict[str, tuple[float, float]]:
    """Return what was measured of programs."""
    begin = _now()
    from armsim_ros.testing.started_stack import SharedStack

    def cell() -> Any:
        from armsim_ros.testing.stacks import built_cell

        return built_cell(robot, None, {})

    with private_domain() as domain:
        shared, found = SharedStack(domain), {}
        for what in ('first arm up', 'arm of the next test'):
            user = shared.at_start([f'robot:={robot}'], lambda: cell().settings.namespace)
            from armsim_ros.testing.ros_arm import RosArm

            RosArm(user, cell())
            found[what] = _past(begin, _now())
            begin = _now()
        shared.close()
    return found


def _now() -> tuple[float, float]:
    return time.perf_counter(), time.process_time()


def _past(begin: tuple[float, float], end: tuple[float, float]) -> tuple[float, float]:
    return end[0] - begin[0], end[1] - begin[1]


if __name__ == '__main__':
    measure = {'inprocess': in_process, 'process': over_dds}[sys.argv[1]]
    print(json.dumps(measure(sys.argv[2])))
