# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Answers that clients which have just started never get, by what Fast DDS sends them through.

As a program it is such a client: ``python -m benchmarks.bringup.lost_answers SERVICE SECONDS``
calls a service, each time with a new participant.
"""

from __future__ import annotations

from contextlib import ExitStack
import re
import sys
import time

from controller_manager_msgs.srv import ListControllers
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor

from armsim_ros.testing.program import private_domain, Program, ros_environment
from benchmarks.options import Options
from benchmarks.stack import arm_of, DOMAINS
from benchmarks.tables import publish, Table

#: The transports as Fast DDS names them.
_TRANSPORTS = {'sockets': 'UDPv4', 'shared memory': 'DEFAULT'}
_CALLERS = 3
#: After this time an answer counts as lost [s].
_PATIENCE = 3.0
#: A client that has not ended so long after its last call never does: it may spin for good in
#: destroy_node, see docs/errors.md [s].
_LONGEST_END = 15.0


def main(options: Options) -> None:
    """Count the calls and the answers of some clients beside the simulation."""
    namespace = arm_of(options.robot)[0].rpartition('/')[0]
    words = f'{namespace}/controller_manager/list_controllers', str(options.seconds)
    rows = []
    for name, transports in _TRANSPORTS.items():
        with private_domain(DOMAINS) as domain, ExitStack() as stack:
            environment = ros_environment(domain) | {
                'FASTDDS_BUILTIN_TRANSPORTS': transports,
                # With LOCALHOST rmw_fastrtps adds shared memory whatever else is set.
                'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}
            simulation = stack.enter_context(Program.module(
                'armsim_ros', 'simulation', f'robot:={options.robot}', environment=environment))
            simulation.wait_for_line('simulation of .* runs', 60.0)
            callers = [stack.enter_context(Program.module(
                'benchmarks.bringup.lost_answers', *words, environment=environment))
                for _ in range(_CALLERS)]
            end = time.monotonic() + options.seconds + _LONGEST_END
            lost = calls = hung = 0
            for caller in callers:
                try:
                    caller.wait(max(end - time.monotonic(), 0.1))
                except AssertionError:
                    hung += 1
                counts = re.findall(r'^(\d+) .* of (\d+)', caller.text, re.MULTILINE)
                lost += sum(int(count) for count, _ in counts)
                calls += sum(int(count) for _, count in counts)
            rows.append((name, str(calls), str(lost), str(hung)))
    publish(options.report, 'lost answers', Table(
        f'{_CALLERS} clients that call list_controllers for {options.seconds:g} s, each time with '
        'a new participant',
        ('sent through', 'calls', 'answers lost', 'clients that never end'), rows))


def call(service: str, seconds: float) -> tuple[int, int]:
    """Call again and again; return how many answers were lost, and of how many calls."""
    lost = calls = 0
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        context = Context()
        rclpy.init(context=context)
        node = rclpy.create_node('caller', context=context)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        client = node.create_client(ListControllers, service)
        if client.wait_for_service(_PATIENCE):
            future = client.call_async(ListControllers.Request())
            executor.spin_until_future_complete(future, _PATIENCE)
            calls += 1
            lost += not future.done()
        executor.shutdown()
        node.destroy_node()
        context.shutdown()
    return lost, calls


if __name__ == '__main__':
    lost_answers, made_calls = call(sys.argv[1], float(sys.argv[2]))
    print(f'{lost_answers} answers lost of {made_calls} calls', flush=True)
