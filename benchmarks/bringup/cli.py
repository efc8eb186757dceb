# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
How long the verbs of the ros2 command take beside a running robot: processor and wall time.

With a ROS installation's ros2 on PATH both are measured in turn; that has its daemon running.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
import os
from pathlib import Path
import subprocess
import sys
import threading
import time

from armsim_ros.testing.program import ros_environment
from armsim_ros2.handover import environment_for_real_ros2, find_real_ros2
from benchmarks.options import Options
from benchmarks.stack import joint_states_of, median, running_stack
from benchmarks.tables import Table

SOURCES = Path(__file__).parents[2] / 'ros2'
#: After this time a command is ended [s].
_PATIENCE = 30.0
#: Heading -> command and environment.
Programs = Mapping[str, tuple[list[str], dict[str, str]]]


def main(options: Options) -> None:
    """Print median times of each command."""
    manager = joint_states_of(options.robot).rpartition('/')[0] + '/controller_manager'
    lines = (
        '-h', 'topic -h', 'topic lst', 'pkg list', 'interface show sensor_msgs/msg/JointState',
        'topic list', 'topic type /joint_states', 'topic info -v /joint_states',
        f'topic echo --once {joint_states_of(options.robot)}',
        'topic echo --once /robot_description',
        'service list', 'service type /compute_ik', 'action list', 'node list',
        'node info /move_group', 'param get /move_group use_sim_time', 'param list /move_group',
        f'control list_controllers -c {manager}',
        'service call /get_planning_scene moveit_msgs/srv/GetPlanningScene',
    )
    with running_stack(f'robot:={options.robot}') as stack:
        domain = ros_environment(stack.domain)
        # Without the folders of a ROS installation, to whose ros2 it would hand over.
        own = {**os.environ, **domain, 'PYTHONPATH': str(SOURCES), 'PATH': os.defpath}
        programs = {'': ([sys.executable, '-m', 'armsim_ros2'], own)}
        real = find_real_ros2(os.environ.get('PATH', ''))
        if real is not None:
            theirs = {**environment_for_real_ros2(), **domain}
            programs["upstream's "] = ([str(real)], theirs)
            subprocess.run([real, 'daemon', 'start'], env=theirs, check=True,
                           stdout=subprocess.DEVNULL)
        rows = [(f'ros2 {line}', *(cell for times in measure(line, programs, options.runs)
                                   for cell in cells(times))) for line in lines]
        if real is not None:
            subprocess.run([real, 'daemon', 'stop'], env=theirs, check=True,
                           stdout=subprocess.DEVNULL)
    head = (f'{name}{figure}' for name in programs for figure in (
        'CPU median s', 'wall median s', 'CPU worst s'))
    Table(f'The ros2 command, {options.runs} runs each', ('command', *head), rows).print()


def cells(times: Sequence[tuple[float, float]]) -> list[str]:
    """Return the medians of processor and wall time, and the largest processor time."""
    return [f'{value:.2f}' for value in (
        median([cpu for cpu, _ in times]), median([wall for _, wall in times]), max(times)[0])]


def measure(line: str, programs: Programs, runs: int) -> list[list[tuple[float, float]]]:
    """
    Run a command by each program in turn.

    :returns: for each program, the processor and wall time of each run [s].
    """
    times: list[list[tuple[float, float]]] = [[] for _ in programs]
    for _ in range(runs):
        for found, (command, environment) in zip(times, programs.values(), strict=True):
            start = time.monotonic()
            process = subprocess.Popen([*command, *line.split()], env=environment,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            watchdog = threading.Timer(_PATIENCE, process.kill)
            watchdog.start()
            _, _, usage = os.wait4(process.pid, 0)
            watchdog.cancel()
            process.returncode = 0  # it was waited for
            found.append((usage.ru_utime + usage.ru_stime, time.monotonic() - start))
    return times
