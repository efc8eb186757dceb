# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Stops at random times in motions of each kind, of an arm of each vendor."""

import random
from types import SimpleNamespace

import numpy as np
import pytest

from armsim_ros.stack import ArmSim
from armsim_ros.trajectory import JointTrajectory
from armsim_ros.vendors import TABLES

JOINTS = tuple(f'joint_{i}' for i in range(1, 7))
FORWARD = SimpleNamespace(
    name='forward', type='forward_command_controller/ForwardCommandController',
    parameters={'joints': JOINTS, 'interface_name': 'position'})


def positions(sim):
    """Return where the arm's joints are (6,)."""
    return np.array([sim.joint_positions[name] for name in JOINTS])


def swing(sim, duration):
    """Return a motion to the other side, from where the arm is."""
    here = positions(sim)
    there = here + np.where(here > 0.0, -0.6, 0.6)
    return JointTrajectory(JOINTS, np.array([duration]), there[None], np.zeros((1, 6)))


def begin(kind, sim, chance):
    """Begin a motion; return what keeps it going, its goals, and how long it lasts [s]."""
    controller = sim.manager.controllers['arm_joint_controller']
    forward = sim.manager.controllers['forward']
    motion = swing(sim, chance.uniform(0.6, 3.0))
    if kind == 'forward':
        sim.manager.switch(activate=['forward'], deactivate=['arm_joint_controller'])
        target = list(motion.positions[0])
        return lambda: forward.receive(target), (), 0.25
    sim.manager.switch(activate=['arm_joint_controller'], deactivate=['forward'])
    if kind == 'execution':
        return (lambda: None), sim.send_trajectory(motion), float(motion.times[-1])
    if kind == 'goal':
        goal = controller.send_goal(motion).goal
        return (lambda: None), (goal,), float(motion.times[-1])
    # As Servo: every command is a point a little ahead of where the last one was.
    step = (motion.positions[0] - positions(sim)) * 0.02
    at = [positions(sim)]

    def stream():
        at[0] = at[0] + step
        controller.set_trajectory(JointTrajectory(JOINTS, np.array([0.02]), at[0][None]))

    return stream, (), 0.5


@pytest.mark.parametrize('vendor', ['none', *TABLES])
def test_nothing_of_an_old_goal_moves_the_arm_after_a_stop(request, vendor):
    """
    After stops at random times the arm rests, and stays where it is once they are cleared.

    HW-B3.
    """
    sim = ArmSim('sunday', overrides={'simulation.hardware.vendor': vendor})
    arm = sim.manager.arm
    sim.manager.load(FORWARD)
    sim.manager.configure('forward')
    stops, moving = request.config.getoption('--stops'), 0
    for seed in range(stops):
        chance = random.Random(seed)
        kind = chance.choice(('goal', 'execution', 'stream', 'forward'))
        keep_going, goals, duration = begin(kind, sim, chance)
        end = sim.time + chance.uniform(0.0, duration)
        while sim.time < end:
            keep_going()
            sim.step(chance.randint(1, 20))
        moving += bool(np.abs(sim.simulation.state.velocity).max() > 0.02)
        sim.protective_stop()
        for _ in range(25):
            keep_going()
            sim.step(20)
        assert all(goal.done for goal in goals), (seed, kind)
        rest = positions(sim)
        if chance.random() < 0.5:
            keep_going()
        sim.run_until(max(sim.time, 1e-9 * (arm.since_ns + arm.unlock_delay_ns) + 0.01))
        sim.clear_stop()
        assert arm.play() == ''
        sim.step(chance.choice((1, 300)))
        sim.run_until(sim.time + 0.5)
        assert np.abs(positions(sim) - rest).max() < 1e-3, (seed, kind)
    assert moving > 0.8 * stops
