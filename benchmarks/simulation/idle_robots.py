# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What each robot of the package costs while it does nothing: processor time of its programs."""

from __future__ import annotations

import time

from armsim_ros.resources import cell_names, robot_names
from benchmarks.options import Options
from benchmarks.stack import processor_seconds, running_stack
from benchmarks.tables import machine_load, publish, Table

PROGRAMS = ('simulation', 'move_group')


def main(options: Options) -> None:
    """Print the table; write it where ``--report`` says."""
    publish(options.report, 'idle', Table(
        'Robots at rest', ('robot', *(f'{name}, % of a core' for name in PROGRAMS)),
        [(name, *_shares(name, options.seconds)) for name in (*robot_names(), *cell_names())]),
        machine_load())


def _shares(robot: str, seconds: float) -> list[str]:
    with running_stack(f'robot:={robot}') as stack:
        time.sleep(2.0)  # what follows a start
        processes = stack.processes()
        before = {name: processor_seconds(processes[name]) for name in PROGRAMS}
        began = time.monotonic()
        time.sleep(seconds)
        passed = time.monotonic() - began
        return [f'{100.0 * (processor_seconds(processes[name]) - before[name]) / passed:.1f}'
                for name in PROGRAMS]
