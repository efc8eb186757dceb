# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Processor time of simulated steps, beside bare ``mj_step`` of the same model in the same state.

Both take turns of a simulated second, so that other programs hit both alike; a figure is the
median of the turns. The bare arm, which nobody steers, begins anew in our state every tenth of a
second, before it can fall asleep.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
import tempfile
import time

import mujoco
import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.stack import ArmSim
from armsim_ros.trajectory import JointTrajectory
from benchmarks.options import Options
from benchmarks.robots import write_robot
from benchmarks.tables import Table

HEAD = ('world', 'controllers', 'arm', 'us a step', 'bare mj_step', 'ratio', 'steps a second')
TURN, TURNS, AGAIN = 1000, 12, 100
RATES = (1000, 250, 100)
#: Simulated time in which what fell comes to rest and falls asleep [s].
SETTLING = 3.0
#: Height of the lowest of the objects that fall, and the step to the next [m].
LOWEST, STEP = 1.6, 0.4
#: Time of a move there and back again [s].
MOVE = 2.0


@dataclass(frozen=True)
class Situation:
    """
    A world and what happens in it.

    :param robot: name or folder.
    :param world: name or file.
    :param settling: simulated time before the measurement [s].
    :param turns: how many simulated seconds are measured.
    """

    name: str
    robot: str
    world: str
    settling: float = SETTLING
    turns: int = TURNS


def lockstep_tables(options: Options) -> Iterable[Table]:
    """Yield the table of steps, and one of whole tasks."""
    with tempfile.TemporaryDirectory() as folder:
        rows = [
            _row(situation, rate, moves=moves)
            for situation in _situations(options.robot, Path(folder))
            for rate in RATES
            for moves in (False, True)]
    yield Table('Steps without ROS, processor time', HEAD, rows)
    yield Table(
        'Tasks without ROS', ('task', 'processor s', 'simulated s'),
        [_task('100 s of an arm at rest', options.robot, lambda sim: sim.run_until(100.0)),
         _task('scan_food, planned and executed, with the imports of the planner', options.robot,
               lambda sim: sim.execute(sim.plan('scan_food'))),
         _task('scan_food, planned and executed', options.robot,
               lambda sim: sim.execute(sim.plan('scan_food')))],
    )


def _situations(robot: str, folder: Path) -> list[Situation]:
    empty, falling, arms = folder / 'empty.yaml', folder / 'falling.yaml', folder / 'arms'
    empty.write_text('floor: true\n', encoding='utf-8')
    boxes = '\n'.join(
        f'  box_{i}: {{mass: 0.3, xyz: [{0.8 + 0.01 * i}, 0.8, {LOWEST + STEP * i}], '
        'parts: [{shape: {type: box, size: [0.1, 0.1, 0.1]}}]}'
        for i in range(10))
    falling.write_text(f'floor: true\nobjects:\n{boxes}\n', encoding='utf-8')
    arms.mkdir()
    write_robot(arms, 30)
    return [
        Situation('empty', robot, str(empty)),
        Situation('feeding_place', robot, 'feeding_place'),
        Situation('ten objects that fall', robot, str(falling), settling=0.0, turns=3),
        Situation('30 joints', str(arms), str(empty)),
    ]


def _row(situation: Situation, rate: int, *, moves: bool) -> tuple[str, ...]:
    sim = ArmSim(situation.robot, world=situation.world, overrides={
        'controller_manager.update_rate': rate})
    sim.run_until(situation.settling)
    if moves:
        sim.send_trajectory(_there_and_back(sim, TURN * situation.turns * 1e-3))
    ours, bare = _turns(sim, situation.turns)
    return (
        situation.name, f'{rate} Hz', 'moves' if moves else 'at rest', f'{ours:.1f}',
        f'{bare:.1f}', f'{ours / bare:.2f}', f'{1e6 / ours:,.0f}',
    )


def _turns(sim: ArmSim, turns: int) -> tuple[float, float]:
    """Return the times of a step of ours and of a bare one [us]."""
    times = np.zeros((2, turns))
    for turn in range(turns):
        model = sim.simulation.mujoco_model
        data = mujoco.MjData(model)
        for _ in range(TURN // AGAIN):
            mujoco.mj_copyData(data, model, sim.simulation.mujoco_data)
            began = time.process_time()
            for _ in range(AGAIN):
                mujoco.mj_step(model, data)
            times[1, turn] += time.process_time() - began
        began = time.process_time()
        sim.step(TURN)
        times[0, turn] = time.process_time() - began
    ours, bare = np.median(times, axis=1) * 1e6 / TURN
    return float(ours), float(bare)


def _there_and_back(sim: ArmSim, duration: float) -> JointTrajectory:
    """Return a motion of all joints under trajectory control that lasts longer than that."""
    joints = max((controller.joints for controller in sim.manager.controllers.values()
                  if isinstance(controller, JointTrajectoryController)), key=len)
    home = np.array([sim.joint_positions[name] for name in joints])
    count = np.arange(1, int(duration / MOVE) + 3)
    positions: Matrix = home + 0.3 * (count % 2)[:, None]
    zeros = np.zeros_like(positions)
    times = count.astype(np.float64) * MOVE
    return JointTrajectory(tuple(joints), times, positions, zeros, zeros)


def _task(name: str, robot: str, task: Callable[[ArmSim], object]) -> tuple[str, ...]:
    sim = ArmSim(robot)
    began = time.process_time()
    task(sim)
    return name, f'{time.process_time() - began:.2f}', f'{sim.time:.1f}'
