# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How long a user waits: from the start of bringup to joint states, to the ready line."""

from __future__ import annotations

import time

from sensor_msgs.msg import JointState

from benchmarks.options import Options
from benchmarks.stack import median, READY, running_stack


def main(options: Options) -> None:
    """Print the medians of a few starts."""
    states, ready = [], []
    for _ in range(options.runs):
        with running_stack(wait=False) as stack:
            topic = stack.client.collect('/sunday/joint_states', JointState)
            topic.wait(1, 30.0)
            states.append(time.monotonic() - stack.program.started)
            stack.program.wait_for_line(READY, 60.0)
            ready.append(time.monotonic() - stack.program.started)
    print(f'runs {options.runs}')
    print(f'first /sunday/joint_states  median {median(states):.2f} s  worst {max(states):.2f} s')
    print(f'"{READY}"  median {median(ready):.2f} s  worst {max(ready):.2f} s')
