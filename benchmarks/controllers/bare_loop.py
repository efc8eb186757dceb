# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A peer: a loop that only waits for its deadlines and steps bare MuJoCo, in the robot's own world.

``python -m benchmarks.controllers.bare_loop ROBOT`` asks for the control thread's priority, runs
until it is terminated, and then prints processor share [%] and lateness [us] as key=value.
"""

from __future__ import annotations

import signal
import sys
import time

import mujoco

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.model.loading import load_robot_model
from armsim_ros.sim.assembly import build_simulation
from armsim_ros.sim.pacer import Pacer, prioritize_thread

STARTED = 'bare loop runs'


def run(robot: str) -> None:
    """Step until a signal comes, then print."""
    settings = load_robot_settings(robot)
    simulation = build_simulation(settings, load_robot_model(settings))
    model, data = simulation.mujoco_model, simulation.mujoco_data
    running = [True]
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: running.clear())
    prioritize_thread(settings.simulation.pace.priority)
    pacer, period = Pacer(), settings.simulation.timestep_ns
    print(STARTED, flush=True)
    pacer.start()
    wall, processor = time.monotonic(), time.process_time()
    while running:
        pacer.wait(period)
        mujoco.mj_step(model, data)
    share = (time.process_time() - processor) / (time.monotonic() - wall)
    lateness = pacer.statistics()
    print(f'share={100 * share:.2f} p50={lateness.p50_ns / 1e3:.1f} '
          f'p99={lateness.p99_ns / 1e3:.1f} max={lateness.max_ns / 1e3:.1f}', flush=True)


if __name__ == '__main__':
    run(sys.argv[1])
