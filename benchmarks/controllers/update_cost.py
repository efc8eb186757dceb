# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Cost of one update of the controllers, beside a whole control tick and bare MuJoCo.

The three are timed in turn within one loop, with the clock of the thread's own processor time, so
that other programs on the machine hardly count.
"""

from __future__ import annotations

from pathlib import Path
import tempfile
import time

import mujoco
import numpy as np

from armsim_ros.stack import ArmSim
from armsim_ros.trajectory import JointTrajectory
from benchmarks.options import Options
from benchmarks.robots import joint_names, write_robot

JOINTS = (6, 30)
WARM_UP = 500
#: Simulated time of a move [s], and its waypoints.
DURATION, WAYPOINTS = 4.0, 20
COLUMNS = ('controllers update', 'control tick', 'bare mj_step')


def main(options: Options) -> None:
    """Print a table for each number of joints."""
    print('processor time of one call in us' + ' ' * 8 + 'p50      p99   p50 by mj_step')
    for joints in JOINTS:
        with tempfile.TemporaryDirectory() as folder:
            sim = ArmSim(write_robot(Path(folder), joints))
        for phase in ('holding', 'moving'):
            if phase == 'moving':
                sim.send_trajectory(_waves(joint_names(joints)))
            times = _measure(sim, round(min(options.seconds, DURATION) * 1000) - WARM_UP)
            bare = float(np.median(times[2]))
            for name, samples in zip(COLUMNS, times, strict=True):
                p50, p99 = np.percentile(samples, (50, 99))
                print(f'{joints:3d} joints {phase:<8} {name:<19}{p50:8.1f} {p99:8.1f} '
                      f'{p50 / bare:10.2f}')


def _measure(sim: ArmSim, count: int) -> np.ndarray:
    """Return times (3, count) [us] of update, tick and mj_step."""
    simulation, manager, clock = sim.simulation, sim.manager, time.thread_time_ns
    model = simulation.mujoco_model
    data = mujoco.MjData(model)
    period = simulation.clock.step_ns * 1e-9
    times = np.empty((3, count))
    for i in range(-WARM_UP, count):
        begin = clock()
        manager.update(simulation.clock.now_ns, period)
        updated = clock()
        simulation.write(1)
        simulation.step()
        stepped = clock()
        data.qpos[:] = simulation.mujoco_data.qpos
        data.qvel[:] = simulation.mujoco_data.qvel
        data.ctrl[:] = simulation.mujoco_data.ctrl
        bare = clock()
        mujoco.mj_step(model, data)
        done = clock()
        if i >= 0:
            times[:, i] = updated - begin, stepped - begin, done - bare
    return times * 1e-3


def _waves(names: list[str]) -> JointTrajectory:
    """Return a trajectory of quintic segments that moves all joints until the end."""
    phases = np.linspace(0.0, 3.0, len(names))
    times = np.linspace(DURATION / WAYPOINTS, DURATION, WAYPOINTS)
    angles = 0.3 * np.outer(np.sin(times), np.cos(phases))
    velocities, accelerations = 0.3 * np.outer(np.cos(times), np.cos(phases)), -angles
    velocities[-1] = accelerations[-1] = 0.0
    return JointTrajectory(tuple(names), times, angles, velocities, accelerations)
