# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a second attempt with another seed would win where the first one is slow."""

from __future__ import annotations

from pathlib import Path
import sys
import time

import numpy as np

from benchmarks.options import Options
from benchmarks.planning_problems import problem_sets, problem_text

SEEDS = 4
DELAYS = (0.15, 0.2, 0.3)
SECONDS = 20.0


def main(options: Options) -> None:
    """
    Plan every problem with several seeds; print the share of slow plans, and times.

    The second attempt is thought to cost nothing and to begin after a delay, on a core of its
    own: no real one can win more.
    """
    sys.path.insert(0, str(Path(__file__).parent / 'peers'))
    from armsim import Planner

    for problems in problem_sets(options.problems, options.problems_of_a_scene):
        planner = Planner(problems.for_peers())
        table = []
        for problem in problems.problems:
            text = problem_text(problem)
            planner.prepare(text)
            spent = []
            for seed in range(SEEDS):
                began = time.thread_time()
                planner.plan(text, seed, SECONDS)
                spent.append(time.thread_time() - began)
            table.append(spent)
        alone = np.array(table)
        other = np.roll(alone, 1, axis=1)
        print(f'{problems.robot}: {alone.size} plans, alone: {_figures(alone)}')
        for delay in DELAYS:
            both = np.where(alone > delay, np.minimum(alone, delay + other), alone)
            print(f'  a second attempt after {delay:g} s: {_figures(both)}; '
                  f'{np.mean(alone > delay):.1%} of all plans take longer than that')


def _figures(times: np.ndarray) -> str:
    return (f'mean {1000.0 * times.mean():.0f} ms, 95 % below '
            f'{1000.0 * np.percentile(times, 95):.0f}, 99 % below '
            f'{1000.0 * np.percentile(times, 99):.0f}, worst {1000.0 * times.max():.0f}')
