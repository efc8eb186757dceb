# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What else planning costs: edits of the scene, Cartesian paths, cancelling."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations
from statistics import median
import threading
import time

import numpy as np

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.planner import MotionPlanner
from armsim_ros.planning.request import (
    CartesianRequest,
    Constraints,
    JointConstraint,
    MotionPlanRequest,
)
from armsim_ros.planning.scene.objects import AttachedObject, CollisionObject, ObjectShape
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import SceneUpdate, StartState
from benchmarks.options import Options
from benchmarks.planning.planned_robot import planner_of, states_of

ADD, REMOVE, MOVE = 0, 1, 3
OBJECTS = 10
CARTESIAN_POINTS = 500


def main(options: Options) -> None:
    """Print a line a cost; ``--runs`` says how often plans are cancelled at each stage."""
    planner, scene = planner_of(options.robot)
    group, states = states_of(scene.kinematic_model)
    _edits(scene, group)
    _cartesian(planner, scene, group)
    _cancel(planner, scene, group, states, options.runs)
    _longest_silence(planner, scene, group, states)


def _box(name: str, operation: int, xyz: tuple[float, ...]) -> CollisionObject:
    shapes = (ObjectShape(Box((0.05, 0.05, 0.05))),) if operation == ADD else ()
    return CollisionObject(name, operation, pose=pose_matrix(xyz), shapes=shapes)


def _edits(scene: PlanningScene, group: str) -> None:
    """Time each kind of edit with a check of a state that sees it, less the check itself."""
    checker = CollisionChecker(scene)
    for k in range(OBJECTS):
        scene.apply_object(_box(f'box{k}', ADD, (5.0, k, 0.0)))
    tip = scene.robot.semantic.groups[group].links[-1]
    acm = scene.acm
    held = replace(_box('held', ADD, (0.0, 0.0, 0.5)), frame_id=tip)

    def attach(k: int) -> None:
        scene.apply_attached(AttachedObject(tip, held, (tip,)))

    def detach(k: int) -> None:
        scene.apply_attached(AttachedObject(tip, CollisionObject('held', REMOVE)))

    def remove(k: int) -> None:
        scene.apply_object(CollisionObject('held', REMOVE))

    def add(k: int) -> None:
        scene.apply_object(_box('held', ADD, (5.0, 0.1 * k, 3.0)))

    def move(k: int) -> None:
        scene.apply_object(_box('box0', MOVE, (5.0, 0.1 * k, 1.0)))

    def rules(k: int) -> None:
        scene.set_acm(acm.with_pair(f'box{k % OBJECTS}', tip, bool(k % 2)))

    def padding(k: int) -> None:
        scene.apply(SceneUpdate(is_diff=True, link_padding={tip: 0.001 * (1 + k % 5)}))

    spent: dict[str, list[float]] = {}
    for k in range(50):
        for name, edit in (('add', add), ('remove', remove), ('attach', attach),
                           ('detach', detach), ('remove', remove), ('move', move),
                           ('rules', rules), ('padding', padding)):
            checker.in_collision(scene.q, group)
            began = time.process_time()
            checker.in_collision(scene.q, group)
            idle = time.process_time() - began
            began = time.process_time()
            edit(k)
            checker.in_collision(scene.q, group)
            spent.setdefault(name, []).append(1000.0 * (time.process_time() - began - idle))
    for name, values in spent.items():
        print(f'scene edit, {name}: {median(values):.2f} ms CPU, '
              f'95 % below {float(np.percentile(values, 95)):.2f}')
    scene.clear()


def _cartesian(planner: MotionPlanner, scene: PlanningScene, group: str) -> None:
    """Time a path of so many poses on a circle of 5 cm, from where the arm moves best."""
    model = scene.kinematic_model
    tip = scene.robot.semantic.groups[group].links[-1]
    generator = np.random.default_rng(0)
    indices = model.group_indices(group)
    low = np.maximum(model.lower, -np.pi)[indices]
    high = np.minimum(model.upper, np.pi)[indices]
    states = [model.insert(scene.q, group, values)
              for values in generator.uniform(low, high, (300, len(indices)))]
    q = max((q for q in states if planner.check_state(scene, q, group).valid),
            key=lambda q: np.linalg.svd(model.jacobian(q, tip, group), compute_uv=False)[-1])
    start = model.positions(q)
    pose = model.link_pose(q, tip)
    angles = np.linspace(0.0, 2.0 * np.pi, CARTESIAN_POINTS + 1)[1:]
    waypoints = []
    for angle in angles:
        moved = pose.copy()
        moved[:3, 3] += 0.05 * np.array([0.0, np.sin(angle), np.cos(angle) - 1.0])
        waypoints.append(moved)
    request = CartesianRequest(
        group, tuple(waypoints), 0.01, start_state=StartState.from_positions(start))
    spent, answer = [], None
    for _ in range(5):
        began = time.process_time()
        answer = planner.cartesian_path(request, scene.snapshot())
        spent.append(1000.0 * (time.process_time() - began))
    assert answer is not None
    print(f'Cartesian path of {CARTESIAN_POINTS} points: {median(spent):.0f} ms CPU, '
          f'{answer.fraction:.0%} {answer.message}')


def _request(group: str, start: dict[str, float], goal: dict[str, float]) -> MotionPlanRequest:
    joints = tuple(JointConstraint(name, value, 1e-4, 1e-4) for name, value in goal.items())
    return MotionPlanRequest(group, (Constraints(joints),), StartState.from_positions(start))


def _cancel(
    planner: MotionPlanner, scene: PlanningScene, group: str,
    states: dict[str, dict[str, float]], runs: int
) -> None:
    """Cancel plans at every stage; print how long the answer takes from then."""
    waits = []
    pairs = list(permutations(states, 2))
    for number in range(runs * len(pairs)):
        start, goal = pairs[number % len(pairs)]
        asked = threading.Event()
        told: list[float] = []

        def cancel(asked: threading.Event = asked, told: list[float] = told) -> None:
            told.append(time.monotonic())
            asked.set()

        timer = threading.Timer(0.003 * (1 + number // len(pairs)), cancel)
        timer.start()
        response = planner.plan(
            _request(group, states[start], states[goal]), scene.snapshot(),
            clock=time.monotonic, cancelled=asked.is_set)
        ended = time.monotonic()
        timer.cancel()
        timer.join()
        if response.error_code == MoveItErrorCode.PREEMPTED:
            waits.append(1000.0 * (ended - told[0]))
    print(f'{len(waits)} plans cancelled, answered after: median {median(waits):.1f} ms, worst '
          f'{max(waits):.1f} ms')


def _longest_silence(
    planner: MotionPlanner, scene: PlanningScene, group: str, states: dict[str, dict[str, float]],
) -> None:
    """Print the longest time in which a plan does not ask whether it is still wanted."""
    gaps: list[float] = []
    for start, goal in permutations(states, 2):
        last = [time.thread_time()]

        def asked(last: list[float] = last) -> bool:
            now = time.thread_time()
            gaps.append(1000.0 * (now - last[0]))
            last[0] = now
            return False

        planner.plan(
            _request(group, states[start], states[goal]), scene.snapshot(),
            clock=time.monotonic, cancelled=asked)
    print(f'longest time without a look at the cancel flag: {max(gaps):.1f} ms CPU')
