# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Processor share of every process, and lateness of the control tick: idle, moving, and with clients.

Beside it, in the same time: a loop that does nothing but wait for the same deadlines and step
bare MuJoCo in the same world, and an empty rclpy action server.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
import re
import threading
import time

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState

from armsim_ros.clients.trajectory import trajectory_message, TrajectoryClient
from armsim_ros.testing.program import Program
from benchmarks import listener
from benchmarks.controllers import bare_loop
from benchmarks.options import Options
from benchmarks.stack import arm_of, joint_states_of, peer, processor_seconds, running_stack, Stack

#: The program's statistics look back so far; no phase is shorter [s].
WINDOW = 10.0
#: Time of a move [s], and how far each joint goes [rad or m].
MOVE, DISTANCE = 0.4, 0.1
LATENESS = ('p50', 'p99', 'max')


def main(options: Options) -> None:
    """Print one block a phase."""
    with running_stack(f'robot:={options.robot}') as stack, peer(
        'controllers.empty_action_server', domain=stack.domain) as empty:
        watch(stack, empty, options, 'idle')
        with goals_without_pause(stack, options.robot):
            watch(stack, empty, options, 'moving')
            with ExitStack() as opened:
                clients = [
                    opened.enter_context(peer('listener', domain=stack.domain))
                    for _ in range(options.clients)]
                for program in clients:
                    program.wait_for_line(listener.SETTLED, 120.0)
                watch(stack, empty, options,
                      f'moving, {options.clients} clients subscribed to everything')


def watch(stack: Stack, empty: Program, options: Options, phase: str) -> None:
    """Watch for a while and print."""
    processes = {**stack.processes(), 'empty action server': empty.process.pid}
    with peer(
        'controllers.bare_loop', options.robot, domain=stack.domain, settled=bare_loop.STARTED
    ) as bare:
        diagnostics = stack.client.collect(
            '/diagnostics', DiagnosticArray, qos_profile_sensor_data)
        before = {name: processor_seconds(process) for name, process in processes.items()}
        began = time.monotonic()
        time.sleep(max(options.seconds, WINDOW))
        watched = time.monotonic() - began
        shares = {
            name: 100.0 * (processor_seconds(process) - before[name]) / watched
            for name, process in processes.items()}
        diagnostics.close()
        bare.stop()
    beside = dict(re.findall(r'(\w+)=([\d.]+)', bare.output[-1]))
    ours = {
        item.key: item.value
        for status in diagnostics.messages[-1].status
        for item in status.values}
    print(f'{phase}: share of a processor')
    for name, share in shares.items():
        print(f'  {name:<22}{share:8.1f} %')
    print(f'  {"bare loop":<22}{float(beside["share"]):8.1f} %')
    print(f'  lateness in us, {ours["priority"]:<12}' + ''.join(f'{key:>10}' for key in LATENESS))
    for name, values in (
        ('control tick', [ours[f'lateness_{key}_us'] for key in LATENESS]),
        ('bare loop', [beside[key] for key in LATENESS]),
    ):
        print(f'    {name:<26}' + ''.join(f'{value:>10}' for value in values), flush=True)


@contextmanager
def goals_without_pause(stack: Stack, robot: str) -> Iterator[None]:
    """Send goal after goal, forth and back, from a thread of its own."""
    controller, joints = arm_of(robot)
    state = stack.client.collect(joint_states_of(robot), JointState).wait(1)[-1]
    home = dict(zip(state.name, state.position, strict=True))
    arm = TrajectoryClient(stack.client, controller)
    stop = threading.Event()

    def send() -> None:
        step = 0.0
        while not stop.is_set():
            step = DISTANCE - step
            there = [home[name] + step for name in joints]
            arm.send(trajectory_message(joints, [(MOVE, there)])).result(60.0)

    thread = threading.Thread(target=send)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()
