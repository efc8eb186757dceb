# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Random motions of two arms at once, without ROS.

Both plans are made where the arms stand; what both would sweep is compared as move_group does it.
Motions that would meet are run one after the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from armsim_ros.errors import PlanningError
from armsim_ros.execution.rules import meeting
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.stack import ArmSim
from armsim_ros.trajectory import JointTrajectory
from benchmarks.options import Options
from benchmarks.tables import publish, Table

ROBOT, SIDES = 'two_bots', ('left', 'right')
#: Between two looks at what touches [physics steps].
LOOK = 10


@dataclass
class _Outcome:
    """Time that motions took [s], and looks at which the arms met, as commanded and in truth."""

    seconds: float = 0.0
    met: int = 0
    touched: int = 0


def main(options: Options) -> None:
    """Print the table, and put it into a page where one is named."""
    publish(options.report, 'streaming_two_arms', pairs_table(options.pairs, options.seed))


def pairs_table(count: int, seed: int) -> Table:
    """Return what became of pairs of motions."""
    cell = load_cell(ROBOT)
    random = np.random.default_rng(seed)
    ratios, refused, met, touched = [], 0, 0, 0
    sim = None
    for _ in range(count):
        if sim is None:
            sim = ArmSim(cell, seed=seed)
            sim.step(100)
            checker = CollisionChecker(sim.scene)
        plans = [_plan(sim, random, side) for side in SIDES]
        sim.scene.set_positions(sim.joint_positions)
        if meeting(checker, sim.scene.q, plans[0], plans[1]) is None:
            outcomes = [_run(sim, checker, plans)]
            ratios.append(outcomes[0].seconds / max(plan.duration for plan in plans))
        else:
            refused += 1
            outcomes = [_run(sim, checker, plans[:1])]
            if not outcomes[0].touched:
                outcomes.append(_run(sim, checker, [_plan(sim, random, SIDES[1])]))
        met += sum(one.met > 0 for one in outcomes)
        if any(one.touched for one in outcomes):
            touched += 1
            sim = None  # pushed off their ways: begin anew
    return Table('Motions of two arms at once, without ROS', ('what', 'figure'), [
        ('pairs', f'{count:,}'),
        ('run at once', f'{len(ratios):,}'),
        ('would have met, run one after the other', f'{refused:,}'),
        ('time until both have ended, beside the longer one', _spread(ratios)),
        ('pairs in which the arms met, as commanded, on their own shapes', str(met)),
        ("pairs in which the physics' convex hulls touched", str(touched)),
    ])


def _spread(ratios: list[float]) -> str:
    if not ratios:
        return '-'
    return f'median {np.median(ratios):.3f}, largest {np.max(ratios):.3f}'


def _plan(sim: ArmSim, random: np.random.Generator, side: str) -> JointTrajectory:
    """Return a plan of one arm to a random state that is free and can be reached."""
    group = f'{side}_arm'
    joints = [sim.model.joints[name] for name in sim.model.semantic.groups[group].active_joints]
    reason = ''
    for _ in range(100):
        goal = {joint.name: float(random.uniform(max(joint.limits.lower, -2.0),
                                                 min(joint.limits.upper, 2.0)))
                for joint in joints}
        try:
            return sim.plan(goal, group)
        except PlanningError as error:
            reason = str(error)  # not free, or the other arm is in the way: another one
    raise RuntimeError(f'no free state of {group} found; {reason}')


def _run(sim: ArmSim, checker: CollisionChecker, plans: list[JointTrajectory]) -> _Outcome:
    """Run motions at once."""
    outcome, begin = _Outcome(), sim.time
    goals = [goal for plan in plans for goal in sim.send_trajectory(plan)]
    model = sim.scene.kinematic_model
    names = sim.simulation.joint_names
    while not all(goal.done for goal in goals):
        sim.step(LOOK)
        commanded = dict(zip(names, sim.simulation.reference_positions.tolist(), strict=True))
        outcome.met += checker.in_collision(model.vector(commanded))
        outcome.touched += _touching(sim)
    for goal in goals:
        if goal.status.name != 'SUCCEEDED':
            raise RuntimeError(f'a motion has failed: {goal.result}')
    outcome.seconds = sim.time - begin
    return outcome


def _touching(sim: ArmSim) -> bool:
    """Return whether a link of one arm touches one of the other in the physics."""
    bodies, overlaps = sim.simulation.touching()
    names = sim.simulation.body_names
    arms = [names[body].partition('/')[2].partition('_')[0] for body in range(len(names))]
    return any(
        depth > 0.0 and {arms[one], arms[two]} == set(SIDES)
        for (one, two), depth in zip(bodies, overlaps, strict=True))
