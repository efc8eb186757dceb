# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How long a user waits: from the start of bringup to joint states, to the ready line."""

from __future__ import annotations

import re
import time

from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState

from benchmarks.options import Options
from benchmarks.stack import joint_states_of, median, READY, running_stack
from benchmarks.tables import Table


def main(options: Options) -> None:
    """Print the medians of a few starts."""
    startup_table(options).print()


def startup_table(options: Options) -> Table:
    """Return how long a few starts took."""
    states, ready = [], []
    topic = joint_states_of(options.robot)
    for _ in range(options.runs):
        with running_stack(f'robot:={options.robot}', wait=False) as stack:
            stack.client.collect(topic, JointState, qos_profile_sensor_data).wait(1, 60.0)
            states.append(time.monotonic() - stack.program.started)
            stack.program.wait_for_line(re.escape(READY), 60.0)
            ready.append(time.monotonic() - stack.program.started)
    return Table(
        f'From the command on, {options.runs} starts', ('what', 'median s', 'worst s'),
        [
            (name, f'{median(times):.2f}', f'{max(times):.2f}')
            for name, times in ((f'first {topic}', states), (f'"{READY}"', ready))],
    )
