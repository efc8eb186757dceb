# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Many plans in a row in one process: what fails, and how far memory grows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from itertools import cycle, permutations
import logging
import os
import time

import numpy as np

from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.planner import never
from armsim_ros.planning.request import Constraints, JointConstraint, MotionPlanRequest
from armsim_ros.planning.scene.objects import CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import StartState
from benchmarks.options import Options
from benchmarks.planning.planned_robot import planner_of, states_of
from benchmarks.stack import resident_mib

WARM = 500
"""Plans after which memory is first looked at: until then tables and libraries fill."""
BOXES = 2
REPORTS = 10


def main(options: Options) -> None:
    """
    Plan ``--goals`` times between named states, past boxes that come, move and go.

    Every tenth request is cancelled, every fourth has a goal that collides or may collide.
    """
    planner, scene = planner_of(options.robot, _silent())
    model = scene.kinematic_model
    group, states = states_of(model)
    pairs = cycle(permutations(states, 2))
    rng = np.random.default_rng(options.seed)
    warm = min(WARM, options.goals)
    codes: Counter[str] = Counter()
    before, began = 0.0, time.monotonic()
    for number in range(warm + options.goals):
        if number == warm:
            before = resident_mib(os.getpid())
        _edit(scene, group, rng, number)
        start, goal = next(pairs)
        wanted = dict(states[goal])
        if number % 4 == 3:
            wanted = {name: value + rng.normal(0.0, 0.3) for name, value in wanted.items()}
        response = planner.plan(
            _request(group, states[start], wanted, number), scene.snapshot(),
            clock=time.monotonic,
            cancelled=_after(int(rng.integers(1, 60))) if number % 10 == 9 else never)
        if number >= warm:
            codes[response.error_code.name] += 1
        done = number - warm + 1
        if done > 0 and done % max(1, options.goals // REPORTS) == 0:
            print(f'{done} plans in {time.monotonic() - began:.0f} s, memory '
                  f'{resident_mib(os.getpid()) - before:+.1f} MiB, '
                  + ', '.join(f'{name} {count}' for name, count in codes.most_common()),
                  flush=True)


def _silent() -> logging.Logger:
    """Return a log that keeps nothing and says nothing: most failures are wanted here."""
    log = logging.getLogger('planning_endurance')
    log.setLevel(logging.CRITICAL)
    return log


def _after(count: int) -> Callable[[], bool]:
    """Return what says True once it has been asked so often."""
    asked = iter(range(count))
    return lambda: next(asked, None) is None


def _edit(scene: PlanningScene, group: str, rng: np.random.Generator, number: int) -> None:
    """Put a box where the arm's last link may go, in place of an older one."""
    model = scene.kinematic_model
    low, high = np.maximum(model.lower, -np.pi), np.minimum(model.upper, np.pi)
    tip = scene.robot.semantic.groups[group].links[-1]
    place = model.link_pose(model.apply_mimic(rng.uniform(low, high)), tip)[:3, 3]
    scene.apply_object(CollisionObject(
        f'box {number % BOXES}', 0, scene.model_frame, pose=pose_matrix(tuple(place)),
        shapes=(ObjectShape(Box(tuple(rng.uniform(0.02, 0.15, 3)))),)))


def _request(
    group: str, start: dict[str, float], goal: dict[str, float], seed: int
) -> MotionPlanRequest:
    joints = tuple(JointConstraint(name, value, 1e-4, 1e-4) for name, value in goal.items())
    return MotionPlanRequest(
        group, (Constraints(joints),), StartState.from_positions(start), seed=seed,
        allowed_planning_time=1.0)
