# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Switches between trajectory, forward and servo control while the arm moves, without ROS.

At every update the step of the drives' reference is compared with what the joint's velocity
limit allows; under velocity control, where the reference keeps near a joint that cannot follow,
the commanded velocity is. Every goal is asked for its end.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
import shutil
import tempfile

import numpy as np

from armsim_ros.control.command_controllers.forward_command_controller import ForwardController
from armsim_ros.control.trajectory.goal import TrajectoryGoal
from armsim_ros.model.cell import Cell
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.resources import share_folder
from armsim_ros.servo.commands import JointJog
from armsim_ros.stack import ArmSim
from armsim_ros.trajectory import JointTrajectory
from benchmarks.options import Options
from benchmarks.streaming.servoed_arm import ServoedArm
from benchmarks.tables import publish, Table

#: Longest time in one mode [s]; how far commands reach [rad]; how fast [rad/s].
LONGEST, FAR, FAST = 0.2, 0.3, 1.5
FORWARD = {'forward position': 'position_stream', 'forward velocity': 'velocity_stream'}
MODES = ('trajectory', *FORWARD, 'servo')


def main(options: Options) -> None:
    """Print the table, and put it into a page where one is named."""
    publish(options.report, 'streaming_switches', switches_table(options.switches, options.seed))


@contextmanager
def robot_with_streams() -> Iterator[Cell]:
    """Give the packaged robot with forward controllers beside its own."""
    with tempfile.TemporaryDirectory() as folder:
        robot = Path(folder) / 'sunday'
        shutil.copytree(share_folder('armsim_ros') / 'config/sunday', robot)
        joints = ', '.join(f'joint_{number}' for number in range(1, 7))
        (robot / 'forward_controllers.yaml').write_text(
            'sunday:\n'
            '  position_stream:\n'
            '    type: position_controllers/JointGroupPositionController\n'
            f'    joints: [{joints}]\n'
            '  velocity_stream:\n'
            '    type: velocity_controllers/JointGroupVelocityController\n'
            f'    joints: [{joints}]\n',
            encoding='utf-8',
        )
        yield load_cell(str(robot))


class _Switcher:
    """The arm, what it is told in each mode, and what its reference did."""

    def __init__(self, cell: Cell, seed: int) -> None:
        self.sim = ArmSim(cell, seed=seed)
        self.sim.step(10)
        self.arm = ServoedArm(self.sim, check_collisions=False)
        self.random = np.random.default_rng(seed)
        self.mode = 'trajectory'
        self.goals: list[TrajectoryGoal] = []
        self.share = 0.0
        limits = [self.sim.model.joints[name].limits.velocity
                  for name in self.sim.simulation.joint_names]
        period = self.sim.simulation.clock.step_ns * 1e-9
        self._allowed = np.array(limits) * period
        self._before = self.sim.simulation.reference_positions
        self.sim.loop.every(self.sim.simulation.clock.step_ns, self._look)
        kinematics = self.arm.kinematics
        indices = kinematics.group_indices(self.arm.group)
        # Far from the ends of the joints, so that nothing but the switches stops the arm.
        self._lower = kinematics.lower[indices] * 0.6
        self._upper = kinematics.upper[indices] * 0.6

    def _look(self, _: int) -> None:
        simulation = self.sim.simulation
        now = simulation.reference_positions.copy()
        step = now - self._before
        if self.mode == 'forward velocity':
            period = simulation.clock.step_ns * 1e-9
            step = np.nan_to_num(simulation.command.velocity) * period
        self.share = max(self.share, float(np.max(np.abs(step) / self._allowed)))
        self._before = now

    def switch(self, mode: str) -> None:
        """Have another mode's controller active."""
        old, new = self._controller(self.mode), self._controller(mode)
        if old != new:
            result = self.sim.manager.switch([new], [old])
            if not result.ok:
                raise RuntimeError(result.message)
        self.mode = mode

    def _controller(self, mode: str) -> str:
        return FORWARD.get(mode, self.arm.controller.name)

    def move(self) -> None:
        """Have the arm move in the present mode, for a random time."""
        seconds = float(self.random.uniform(0.02, LONGEST))
        names = self.arm.stream.target.names
        here = self.arm.q[self.arm.stream.target.indices]
        target = np.clip(here + self.random.uniform(-FAR, FAR, len(names)),
                         self._lower, self._upper)
        speed = np.clip((target - here) / LONGEST, -FAST, FAST)
        if self.mode == 'servo':
            self.arm.start()
            for _ in self.arm.follow(JointJog(names, np.clip(speed, -1.0, 1.0)), seconds):
                pass
            return
        if self.mode == 'trajectory':
            duration = float(self.random.uniform(0.15, 0.4))
            trajectory = JointTrajectory(names, np.array([duration]), target[None])
            self.goals += (goal for goal in self.sim.send_trajectory(trajectory)
                           if isinstance(goal, TrajectoryGoal))
        else:
            controller = self.sim.manager.controllers[FORWARD[self.mode]]
            assert isinstance(controller, ForwardController)
            reason = controller.receive(
                (target if self.mode == 'forward position' else speed).tolist())
            if reason:
                raise RuntimeError(reason)
        self.sim.run_until(self.sim.time + seconds)


def switches_table(count: int, seed: int) -> Table:
    """Return what the reference and the goals did over many switches."""
    with robot_with_streams() as cell:
        switcher = _Switcher(cell, seed)
    sim = switcher.sim
    begin = sim.time
    for _ in range(count):
        others = [mode for mode in MODES if mode != switcher.mode]
        switcher.switch(others[switcher.random.integers(len(others))])
        switcher.move()
    switcher.switch('forward position')
    sim.step(10)
    ends = Counter(goal.status.name for goal in switcher.goals)
    unexplained = sum(goal.done and not (goal.result and goal.result.message)
                      for goal in switcher.goals)
    lost = sum(not goal.done for goal in switcher.goals)
    return Table('Switches between kinds of control, without ROS', ('what', 'figure'), [
        ('switches', f'{count:,} in {sim.time - begin:,.0f} s of simulated time'),
        ('largest step of the reference, share of the velocity limit',
         f'{100.0 * switcher.share:.1f} %'),
        ('goals', ', '.join(f'{ends[name]} {name.lower()}' for name in sorted(ends))),
        ('goals without an end', str(lost)),
        ('goals that ended without a reason', str(unexplained)),
    ])
