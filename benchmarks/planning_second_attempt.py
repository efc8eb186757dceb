# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a second attempt in a process of its own wins, by the wall clock."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
import sys
import time

import numpy as np

from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.planners import PlannerTable
from benchmarks.options import Options
from benchmarks.planning_problems import problem_sets, problem_text

DELAY = 0.5
SECONDS = 20.0
SEARCHES = {'adaptive domains': True, "OMPL's": False}


def main(options: Options) -> None:
    """Plan every problem with two kinds of RRT-Connect, alone and helped in turn; print times."""
    sys.path.insert(0, str(Path(__file__).parent / 'peers'))
    from armsim import Planner

    for problems in problem_sets(options.problems, options.problems_of_a_scene):
        world = Planner(problems.for_peers())
        for search, adaptive in SEARCHES.items():
            group = problems.for_peers()['group']
            settings = replace(world.planner.settings, planners=PlannerTable(
                {'this': {'type': 'geometric::RRTConnect', 'adaptive_domains': adaptive}},
                {group: 'this'}))
            planners = {
                delay: MotionPlanner(
                    world.scene, settings=settings, second_attempt_delay=delay)
                for delay in (0.0, DELAY)
            }
            spent: dict[float, list[float]] = {delay: [] for delay in planners}
            for problem in problems.problems:
                text = problem_text(problem)
                for delay, planner in planners.items():
                    world.planner = planner
                    world.prepare(text)
                    began = time.perf_counter()
                    world.plan(text, -1, SECONDS)
                    spent[delay].append(time.perf_counter() - began)
            for delay, planner in planners.items():
                planner.close()
                helped = f'with a second attempt after {delay:g} s' if delay else 'alone'
                print(f'{problems.robot}, {search}, {helped}: {_figures(np.array(spent[delay]))}')


def _figures(times: np.ndarray) -> str:
    return (f'{np.mean(times > DELAY):.0%} take longer than {DELAY:g} s; median '
            f'{1000.0 * np.median(times):.0f} ms, mean {1000.0 * times.mean():.0f}, 95 % below '
            f'{1000.0 * np.percentile(times, 95):.0f}, worst {1000.0 * times.max():.0f}')
