# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How long the verbs of the ros2 command take beside a running robot: processor and wall time."""

from __future__ import annotations

import os
from pathlib import Path
import subprocess
import sys
import time

from armsim_ros.testing.programs.domain import ros_environment
from benchmarks.options import Options
from benchmarks.stack import joint_states_of, median, running_stack
from benchmarks.tables import Table

SOURCES = Path(__file__).parents[2] / 'ros2'


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
        environment = {**os.environ, **ros_environment(stack.domain), 'PYTHONPATH': str(SOURCES)}
        rows = []
        for line in lines:
            times = [measure(line, environment) for _ in range(options.runs)]
            rows.append((f'ros2 {line}', *(f'{median([pair[i] for pair in times]):.2f}'
                                           for i in (0, 1)), f'{max(times)[0]:.2f}'))
    Table(f'The ros2 command, {options.runs} runs each',
          ('command', 'CPU median s', 'wall median s', 'CPU worst s'), rows).print()


def measure(line: str, environment: dict[str, str]) -> tuple[float, float]:
    """Return processor and wall time of a command [s]."""
    start = time.monotonic()
    process = subprocess.Popen([sys.executable, '-m', 'armsim_ros2', *line.split()],
                               env=environment, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    _, _, usage = os.wait4(process.pid, 0)
    process.returncode = 0  # it was waited for
    return usage.ru_utime + usage.ru_stime, time.monotonic() - start
