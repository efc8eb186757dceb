# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How an arm stops, how its speed slider acts, and what a vendor costs; in simulated time."""

from __future__ import annotations

import time
from types import SimpleNamespace

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.control.trajectory.goal import TrajectoryGoal
from armsim_ros.control.trajectory.joint_trajectory_controller import JointTrajectoryController
from armsim_ros.stack import ArmSim
from armsim_ros.trajectory import JointTrajectory
from benchmarks.options import Options
from benchmarks.tables import Table

ARM, SCALED = 'arm_joint_controller', 'scaled_joint_trajectory_controller'
STOPS, LONGEST = 20, 0.6


class Subject:
    """
    An arm that swings to and fro.

    :param vendor: '' for none.
    """

    def __init__(self, vendor: str) -> None:
        self.sim = sim = ArmSim(
            'sunday', overrides={'simulation.hardware.vendor': vendor or 'none'})
        self.joints = sim.manager.controllers[ARM].joints
        if vendor:
            sim.manager.load(SimpleNamespace(
                name=SCALED, type='ur_controllers/ScaledJointTrajectoryController', parameters={
                    'joints': self.joints, 'command_interfaces': ['position'],
                    'state_interfaces': ['position', 'velocity'],
                    'speed_scaling_interface_name': 'speed_scaling/speed_scaling_factor'}))
            sim.manager.configure(SCALED)

    def swing(self, controller: str = ARM) -> TrajectoryGoal:
        """Send a motion of all joints by 0.5 rad, in 2 s."""
        here = self.positions
        follower = self.sim.manager.controllers[controller]
        assert isinstance(follower, JointTrajectoryController)
        goal = follower.send_goal(JointTrajectory(
            self.joints, np.array([2.0]), (here + np.where(here > 0.0, -0.5, 0.5))[None],
            np.zeros((1, len(here))))).goal
        assert goal is not None
        return goal

    @property
    def positions(self) -> Vector:
        """Where the joints are (n,) [rad]."""
        return np.array([self.sim.joint_positions[name] for name in self.joints])

    def stop(self) -> tuple[float, float, float]:
        """Stop a motion; return when it slows down, ends its goal, rests [s] after the cause."""
        sim, state = self.sim, self.sim.simulation.state
        goal = self.swing()
        sim.run_until(sim.time + 1.0)
        sim.protective_stop()
        begin, fast = sim.time, float(np.abs(state.velocity).max())
        slower = ended = rests = float('nan')
        while sim.time < begin + LONGEST:
            sim.step()
            speed, passed = float(np.abs(state.velocity).max()), sim.time - begin
            slower = passed if np.isnan(slower) and speed < 0.999 * fast else slower
            ended = passed if np.isnan(ended) and goal.done else ended
            rests = passed if np.isnan(rests) and speed < 1e-3 else rests
        sim.clear_stop()
        sim.step(20)
        return slower, ended, rests

    def path(self, slider: float) -> tuple[float, Matrix]:
        """Move at a slider; return the time that it takes [s], and the path (k, n) [rad]."""
        self.sim.manager.arm.set_slider(slider)
        goal, start, path = self.swing(SCALED), self.sim.time, []
        while not goal.done:
            self.sim.step()
            path.append(self.positions)
        return self.sim.time - start, np.array(path)

    def cost(self) -> float:
        """Return the processor time of a control period of a motion [us]."""
        sim, costs = self.sim, []
        for _ in range(5):
            self.swing()
            begin = time.process_time()
            sim.step(2000)
            costs.append(time.process_time() - begin)
            sim.step(500)
        return min(costs) / (2000 / sim.loop.steps_per_update) * 1e6


def main(options: Options) -> None:
    """Print the table."""
    plain = Subject('')
    stops = np.array([plain.stop() for _ in range(STOPS)]) * 1e3
    vendor = Subject('ur')
    vendor.sim.manager.switch([SCALED], [ARM])
    vendor.sim.step(20)
    full, wanted = vendor.path(1.0)
    half, found = vendor.path(0.5)
    apart = max(float(np.abs(wanted - point).max(axis=1).min()) for point in found[::5])
    costs = [Subject(name).cost() for name in ('', 'ur')]
    slower, ended, rests = (f'{value:.0f} ms' for value in stops.max(axis=0))
    Table('Stops and the speed slider', ('what', 'value'), [
        ('from the cause to the first slower step', slower),
        ('to the end of the goal', ended),
        ('to rest', rests),
        ('duration at half the slider over that at full speed', f'{half / full:.3f}'),
        ('distance of the two paths', f'{apart * 1e3:.2f} mrad'),
        ('processor time of a control period without a vendor', f'{costs[0]:.0f} us'),
        ('of one of Universal Robots', f'{costs[1]:.0f} us'),
    ]).print()
