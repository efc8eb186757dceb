# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Whether a stack at rest keeps time for ``--minutes``: ticks that were given up, rates, gaps.

A client writes down when each message came and its stamp.
"""

from __future__ import annotations

from dataclasses import dataclass, field
import itertools
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from benchmarks.options import Options
from benchmarks.stack import joint_states_of, running_stack
from benchmarks.tables import machine_load, Table

RATES = ('topic', 'messages', 'Hz of wall time', 'off by %', 'stamps left out', 'longest gap ms')
#: Messages that may wait for the client while the machine has no time for it.
DEPTH = 1000


@dataclass
class _Arrivals:
    """
    When messages came, and their stamps.

    :param rate: that the topic should have [Hz].
    """

    rate: float
    walls: list[float] = field(default_factory=list)
    stamps: list[int] = field(default_factory=list)

    def note(self, stamp: Any) -> None:
        self.walls.append(time.monotonic())
        self.stamps.append(stamp.sec * 1_000_000_000 + stamp.nanosec)

    def row(self, topic: str) -> tuple[str, ...]:
        rate = (len(self.walls) - 1) / (self.walls[-1] - self.walls[0])
        steps = [later - earlier for earlier, later in itertools.pairwise(self.stamps)]
        left_out = sum(round(step * 1e-9 * self.rate) - 1 for step in steps)
        off = 100.0 * (rate / self.rate - 1.0)
        return (topic, str(len(self.walls)), f'{rate:.3f}', f'{off:+.3f}', str(left_out),
                f'{max(steps) * 1e-6:.0f}')


def main(options: Options) -> None:
    """Print the rates of what always comes, and what the loop says of itself."""
    with running_stack(f'robot:={options.robot}') as stack:
        topics = {'/clock': (Clock, _Arrivals(100.0), lambda message: message.clock),
                  joint_states_of(options.robot): (
                      JointState, _Arrivals(50.0), lambda message: message.header.stamp)}
        for topic, (kind, arrivals, stamp) in topics.items():
            def note(message: Any, note: Any = arrivals.note, stamp: Any = stamp) -> None:
                note(stamp(message))

            stack.client.node.create_subscription(kind, topic, note, DEPTH)
        health = stack.client.collect('/diagnostics', DiagnosticArray, qos_profile_sensor_data)
        first = _loop(health.wait(2))
        time.sleep(60.0 * options.minutes)
        later = health.messages[2:]
    values = [_loop([message]) for message in later]
    lost = float(values[-1]['dropped_s']) - float(first['dropped_s'])
    overruns = int(values[-1]['overruns']) - int(first['overruns'])
    latest = max(float(one['lateness_max_us']) for one in values)
    Table(f'A stack at rest for {options.minutes:g} min', RATES,
          [arrivals.row(topic) for topic, (_, arrivals, _) in topics.items()]).print()
    print(f'\nticks given up: {1000.0 * lost:.0f}; late by more than a tick and made up: '
          f'{overruns}; lateness at worst {latest:.0f} us, p99 of the last 10,000 waits '
          f'{values[-1]["lateness_p99_us"]} us\n{machine_load()}')


def _loop(messages: list[DiagnosticArray]) -> dict[str, str]:
    """Return what the newest message says of the control loop."""
    return {item.key: item.value for status in messages[-1].status for item in status.values}
