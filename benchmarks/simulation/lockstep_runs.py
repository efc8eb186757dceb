# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Whether runs over DDS in lockstep repeat themselves: a pick of 30 s, and how many digests it has.

``--runs N`` of them, each after a reset of all; every tenth in new programs. ``--busy N``
processes compute beside them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
import subprocess
import sys
import time

from simulation_interfaces.srv import ResetSimulation, StepSimulation
from std_srvs.srv import Empty, Trigger

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.move_group import MoveGroupClient
from armsim_ros.clients.trajectory import TrajectoryClient
from benchmarks.options import Options
from benchmarks.stack import median, running_stack

GROUP, ARM = 'manipulator', '/sunday/arm_joint_controller'
#: Length of a run [ms], and runs of one stack.
LENGTH, OF_A_STACK = 30_000, 10
#: Steps of the physics in one request.
MOST_STEPS = 10_000


def main(options: Options) -> None:
    """Print how often each digest came, and the wall time of a run."""
    digests: Counter[str] = Counter()
    walls: list[float] = []
    with busy_processes(options.busy):
        while len(walls) < options.runs:
            with running_stack('mode:=lockstep', 'seed:=0') as stack:
                for _ in range(min(OF_A_STACK, options.runs - len(walls))):
                    began = time.monotonic()
                    digests[run(stack.client)] += 1
                    walls.append(time.monotonic() - began)
    for digest, count in digests.items():
        print(f'{count} x {digest}')
    print(f'{len(walls)} runs of {LENGTH / 1000:.0f} s beside {options.busy} busy processes, '
          f'each in {median(walls):.1f} s')


@contextmanager
def busy_processes(count: int) -> Iterator[None]:
    """Have processes compute."""
    running = [subprocess.Popen([sys.executable, '-c', 'while True: pass']) for _ in range(count)]
    try:
        yield
    finally:
        for process in running:
            process.kill()
            process.wait()


def run(client: ClientNode) -> str:
    """Move, pick, carry, let go, stand; return the digest."""
    reset = ResetSimulation.Request(scope=ResetSimulation.Request.SCOPE_ALL)
    client.call('/reset_simulation', ResetSimulation, reset)
    move_group = MoveGroupClient(client)
    states, arm = move_group.named_states(), TrajectoryClient(client, ARM)
    for name, cup in (('scan_food', 'on'), ('home', 'off'), ('scan_food', 'on')):
        answer = move_group.plan(GROUP, states[GROUP, name])
        trajectory = answer.planned_trajectory.joint_trajectory
        goal = arm.send(trajectory)
        assert goal.accepted()
        end = trajectory.points[-1].time_from_start
        step(client, end.sec * 1000 + end.nanosec // 1_000_000 + 200)
        goal.result()
        client.call(f'/sunday/vacuum_gripper/{cup}', Empty)
    step(client, LENGTH - int(client.call('/simulation/sync', Trigger).message) // 1_000_000)
    return str(client.call('/simulation/digest', Trigger).message)


def step(client: ClientNode, count: int) -> None:
    """Move time by so many steps."""
    while count > 0:
        steps = min(count, MOST_STEPS)
        client.call('/step_simulation', StepSimulation, StepSimulation.Request(steps=steps), 60.0)
        count -= steps
