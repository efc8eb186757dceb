# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Cost of one control tick and how closely the arm follows, beside bare MuJoCo in the same run.

A tick is one physics step with the controllers' update, the drives and the physics. The moves
go from the start to a named state and back, quintic from rest to rest.
"""

from __future__ import annotations

from collections.abc import Callable
import time

import mujoco
import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.stack import ArmSim
from armsim_ros.trajectory import JointTrajectory
from benchmarks.options import Options


def microseconds(samples: list[int] | Vector) -> Vector:
    """Return median, 99th percentile and maximum of times in nanoseconds."""
    return np.asarray(np.percentile(samples, (50, 99, 100))) / 1e3


def timed(function: Callable[[], object], count: int) -> Vector:
    """Return the times [ns] of so many calls."""
    samples = np.empty(count)
    for i in range(count):
        begin = time.perf_counter_ns()
        function()
        samples[i] = time.perf_counter_ns() - begin
    return samples


def bare_physics(sim: ArmSim, count: int) -> Vector:
    """Return the times of mj_step on a model and state like the simulation's own."""
    plant = sim.simulation.mujoco_model
    data = mujoco.MjData(plant)
    data.qpos[:] = sim.simulation.mujoco_data.qpos
    return timed(lambda: mujoco.mj_step(plant, data), count)


def move(
    sim: ArmSim, joints: tuple[str, ...], goal: Vector, duration: float
) -> tuple[float, float, list[int]]:
    """Run one quintic move; return the errors [rad] during it, after it, and tick times [ns]."""
    start = np.array([sim.joint_positions[name] for name in joints])
    zeros = np.zeros((2, len(joints)))
    sim.send_trajectory(JointTrajectory(
        joints, np.array([0.0, duration]), np.array([start, goal]), zeros, zeros))
    places = [sim.simulation.index[name] for name in joints]
    began = sim.time
    moving, holding, times = 0.0, 0.0, []
    while sim.time < began + duration + 1.0:
        tick = time.perf_counter_ns()
        sim.loop.advance()
        times.append(time.perf_counter_ns() - tick)
        s = min((sim.time - began) / duration, 1.0)
        wanted = start + (goal - start) * (10 * s**3 - 15 * s**4 + 6 * s**5)
        error = np.abs(sim.simulation.state.position[places] - wanted).max()
        if s < 1.0:
            moving = max(moving, error)
        else:
            holding = max(holding, error)
    return moving, holding, times


def farthest_state(sim: ArmSim) -> tuple[tuple[str, ...], Vector]:
    """Return joints and positions of the named state that is farthest from the start."""
    best: tuple[tuple[str, ...], Vector, float] = ((), np.zeros(0), -1.0)
    for group, states in sim.model.semantic.named_states.items():
        joints = sim.model.group(group).active_joints
        home = np.array([sim.joint_positions[name] for name in joints])
        for named in states.values():
            goal = np.array([named[name] for name in joints])
            if len(goal) and (distance := float(np.abs(goal - home).max())) > best[2]:
                best = (joints, goal, distance)
    return best[:2]


def main(options: Options) -> None:
    """Print the tables."""
    sim = ArmSim(options.robot)
    joints, goal = farthest_state(sim)
    home = np.array([sim.joint_positions[name] for name in joints])
    limits = np.array([sim.model.joints[name].limits.velocity for name in joints])
    # A quintic is quickest in its middle: 1.875 times its mean velocity.
    quickest = max(float((1.875 * np.abs(goal - home) / limits).max()), 0.5)
    rows, ticks = [], []
    for duration in (2.0 * quickest, 1.1 * quickest):
        for target in (goal, home):
            moving, holding, times = move(sim, joints, target, duration)
            rows.append((duration, moving, holding))
            ticks += times
    rate = 1.0 / sim.settings.simulation.timestep
    print(f'{options.robot}, {len(joints)} joints, {rate:g} Hz')
    print('largest error of any joint against the trajectory')
    for duration, moving, holding in rows:
        errors = f'{moving * 1e3:.1e} mrad moving, {holding * 1e3:.1e} after'
        print(f'  {duration:.2f} s move: {errors}')
    print('time of one call in us           p50      p99      max')
    for name, samples in (('control tick', ticks), ('bare mj_step', bare_physics(sim, 5000))):
        p50, p99, longest = microseconds(samples)
        print(f'  {name:<26}{p50:9.1f}{p99:9.1f}{longest:9.1f}')
