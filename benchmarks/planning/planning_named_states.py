# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Time and length of plans between all named states of a robot, from request to response."""

from itertools import permutations
from statistics import median
import time

from armsim_ros.planning.request import Constraints, JointConstraint, MotionPlanRequest
from armsim_ros.planning.scene.update import StartState
from benchmarks.options import Options
from benchmarks.planning.planned_robot import planner_of


def main(options: Options) -> None:
    """Print one line a pair of states: solved, median and largest time, path, duration."""
    planner, scene = planner_of(options.robot)
    model = scene.kinematic_model
    print(f'{"from":>14} {"to":>14} {"solved":>7} {"median ms":>10} {"max ms":>8} '
          f'{"path rad":>9} {"lasts s":>8}')
    for group, states in model.robot.semantic.named_states.items():
        for start, goal in permutations(states, 2):
            joints = tuple(
                JointConstraint(name, value, 1e-4, 1e-4) for name, value in states[goal].items())
            times = []
            solved = []
            for seed in range(options.runs):
                request = MotionPlanRequest(
                    group, (Constraints(joints),), StartState.from_positions(states[start]),
                    seed=seed)
                began = time.perf_counter()
                response = planner.plan(request, scene.snapshot(), clock=time.monotonic)
                times.append(1000.0 * (time.perf_counter() - began))
                if response.success:
                    solved.append(response)
            length = median(each.path_length for each in solved) if solved else float('nan')
            lasts = median(each.trajectory.duration for each in solved) if solved else float('nan')
            print(f'{start:>14} {goal:>14} {len(solved):>3}/{options.runs:<3} '
                  f'{median(times):>10.1f} {max(times):>8.1f} {length:>9.2f} {lasts:>8.2f}')
