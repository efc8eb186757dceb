# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Random jogs among obstacles, with the physics and the drives, without ROS.

Each jog is a twist or a joint jog, as fast as servo's scales allow; every now and then the arm
goes somewhere else by a plan. What touches is what MuJoCo finds, not what servo believes.
"""

from __future__ import annotations

from collections import Counter
from itertools import chain
from pathlib import Path
import tempfile

import numpy as np

from armsim_ros.errors import PlanningError
from armsim_ros.servo.commands import Command, JointJog, ServoStatus, Twist
from armsim_ros.stack import ArmSim
from benchmarks.options import Options
from benchmarks.streaming.servoed_arm import moving_links, ServoedArm, touched
from benchmarks.tables import publish, Table

#: Time of a jog [s], and jogs before the arm goes somewhere else.
JOG, PLACES = 0.6, 20
WORLD = """
floor: true
objects:
  left: {xyz: [0.3, 0.3, 1.4], parts: [{shape: {type: box, size: [0.1, 0.1, 0.4]}}]}
  right: {xyz: [0.3, -0.4, 1.4], parts: [{shape: {type: box, size: [0.1, 0.1, 0.4]}}]}
  above: {xyz: [-0.2, 0.1, 1.75], parts: [{shape: {type: box, size: [0.3, 0.3, 0.1]}}]}
  table: {xyz: [0, 0, 1.0], parts: [{shape: {type: box, size: [1.5, 1.5, 0.03]}}]}
"""


def main(options: Options) -> None:
    """Print the table, and put it into a page where one is named."""
    publish(options.report, 'streaming_jogs', jogs_table(options.jogs, options.seed))


def jogs_table(count: int, seed: int) -> Table:
    """Return what became of random jogs."""
    with tempfile.TemporaryDirectory() as folder:
        world = Path(folder) / 'boxes.yaml'
        world.write_text(WORLD, encoding='utf-8')
        sim = ArmSim('sunday', world=world, seed=seed,
                     overrides={'planning_parameters.scene_from_world': True})
    arm = ServoedArm(sim)
    random = np.random.default_rng(seed)
    links = moving_links(sim)
    kinematics = arm.kinematics
    indices = kinematics.group_indices(arm.group)
    lower, upper = kinematics.lower[indices], kinematics.upper[indices]
    codes: Counter[str] = Counter()
    contacts: set[tuple[str, str]] = set()
    passed, farthest, begin = 0.0, 0.0, sim.time
    for number in range(count):
        if number % PLACES == 0:
            _go_elsewhere(arm, random)
        arm.start()
        before = arm.q[indices]
        command = _jog(random, arm)
        for cycle in chain(arm.follow(command, JOG), arm.come_to_rest()):
            contacts |= touched(sim, links)
            codes.update({finding.code.name for finding in cycle.findings} or {'NO_WARNING'})
            q = arm.q[indices]
            passed = max(passed, float(np.max(np.maximum(lower - q, q - upper))))
        farthest += float(np.abs(arm.q[indices] - before).max())
    cycles = sum(codes.values())
    shares = ', '.join(f'{name} {100 * codes[name] / cycles:.0f} %' for name in
                       (code.name for code in ServoStatus) if codes[name])
    return Table('Random jogs among obstacles, without ROS', ('what', 'figure'), [
        ('jogs', f'{count:,} in {sim.time - begin:,.0f} s of simulated time'),
        ('joint that moved farthest in a jog, mean', f'{farthest / count:.2f} rad'),
        ('contacts', ', '.join(f'{one} and {two}' for one, two in sorted(contacts)) or '0'),
        ('past the limit of a joint', f'{max(0.0, passed):.4f} rad'),
        ('status of the cycles', shares),
    ])


def _jog(random: np.random.Generator, arm: ServoedArm) -> Command:
    if random.random() < 0.5:
        names = arm.stream.target.names
        return JointJog(names, random.uniform(-1.0, 1.0, len(names)))
    frame = (arm.stream.target.base, arm.stream.target.tip)[random.integers(2)]
    return Twist(frame, random.uniform(-1.0, 1.0, 3), random.uniform(-1.0, 1.0, 3))


def _go_elsewhere(arm: ServoedArm, random: np.random.Generator) -> None:
    """Go to a random free state by a plan."""
    limits = [(name, *bounds) for name, *bounds in zip(
        arm.stream.target.names, arm.stream.bounds.lower, arm.stream.bounds.upper, strict=True)]
    for _ in range(100):
        goal = {name: float(random.uniform(low, high)) for name, low, high in limits}
        try:
            arm.sim.execute(arm.sim.plan(goal))
            return
        except PlanningError:
            continue  # not free, or walled in: another one
    raise RuntimeError('no free state found to go to')
