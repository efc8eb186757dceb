# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The stack under four clients that never rest, for ``--minutes``: what is lost, what grows.

Memory counts from the fifth minute on, or from the first third of a shorter run: until then
tables are filled and libraries loaded.
"""

from __future__ import annotations

from contextlib import ExitStack
import subprocess
import sys
import time

import numpy as np

from armsim_ros.testing.program import ros_environment
from benchmarks.options import Options
from benchmarks.stack import processor_seconds, resident_mib, running_stack

KINDS = ('moves', 'plans', 'edits', 'asks')
PERIOD = 5.0
WARM_UP = 300.0


def main(options: Options) -> None:
    """Print what the clients did, and growth and load of every process."""
    seconds = 60.0 * options.minutes
    # What is carried around would collide with a floor that planning knew.
    arguments = f'robot:={options.robot}', 'scene_from_world:=false'
    with running_stack(*arguments) as stack, ExitStack() as clients:
        running = [
            clients.enter_context(subprocess.Popen(
                [sys.executable, '-m', 'benchmarks.endurance.soak_client', kind, options.robot],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                env=ros_environment(stack.domain)))
            for kind in KINDS]
        processes = stack.processes()
        used = {name: processor_seconds(pid) for name, pid in processes.items()}
        samples: dict[str, list[tuple[float, float]]] = {name: [] for name in processes}
        began = time.monotonic()
        while (elapsed := time.monotonic() - began) < seconds:
            for name, pid in processes.items():
                samples[name].append((elapsed, resident_mib(pid)))
            time.sleep(min(PERIOD, max(seconds - elapsed, 0.0)))
        for name, pid in processes.items():
            share = (processor_seconds(pid) - used[name]) / seconds
            print(f'{name}: {_growth(samples[name], seconds)}, {100.0 * share:.0f} % of a core')
        for client in running:
            output, _ = client.communicate('end\n', timeout=90.0)
            print(output.replace('begins\n', ''), end='')
        reports = stack.program.text.count('please report')
        print(f"{reports} times 'please report' in the log")


def _growth(samples: list[tuple[float, float]], seconds: float) -> str:
    """Return how memory has grown, by a straight line through the samples."""
    begin = min(WARM_UP, seconds / 3.0)
    later = np.array([sample for sample in samples if sample[0] >= begin])
    if len(later) < 3:
        return 'too few samples'
    slope = 60.0 * float(np.polyfit(later[:, 0], later[:, 1], 1)[0])
    return f'{later[0, 1]:.1f} to {later[-1, 1]:.1f} MiB, {slope:+.3f} MiB a minute'
