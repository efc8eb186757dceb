# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What a running stack costs: processor time and wake-ups of each process, lateness, rates.

Idle, executing goal after goal, idle with clients that subscribe to everything, and several
stacks side by side, each in a domain of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
import re
import time

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from benchmarks import listener
from benchmarks.bringup.startup import startup_table
from benchmarks.controllers.control_thread import goals_without_pause
from benchmarks.options import Options
from benchmarks.stack import joint_states_of, peer, processor_seconds, READY, running_stack, Stack
from benchmarks.tables import Table

#: Stacks that run side by side.
STACKS = 4
#: The program's statistics look back so far; no phase is shorter [s].
WINDOW = 10.0
COSTS = ('phase', 'process', '% of a core', 'wake-ups a second')
KEPT = ('phase', 'tick late p50 us', 'p99 us', '/clock Hz', 'joint_states Hz')


@dataclass(frozen=True)
class Phase:
    """
    What was seen of a stack for a while.

    :param costs: process -> percent of a processor, wake-ups a second.
    :param kept: lateness and rates as text, in the order of ``KEPT``.
    """

    name: str
    costs: dict[str, tuple[float, float]]
    kept: tuple[str, ...]

    def rows(self) -> Iterator[tuple[str, ...]]:
        """Yield a row a process, and their sum."""
        share, wakes = (sum(values) for values in zip(*self.costs.values(), strict=True))
        for process, cost in {**self.costs, 'all': (share, wakes)}.items():
            yield self.name, process, f'{cost[0]:.1f}', f'{cost[1]:.0f}'


def real_time_tables(options: Options) -> Iterable[Table]:
    """Yield the tables of start-up, costs, and what is kept."""
    yield startup_table(options)
    yield from phase_tables([*_one_stack(options), *_side_by_side(options)], 'A running stack')


def phase_tables(phases: Sequence[Phase], title: str) -> Iterator[Table]:
    """Yield the tables of what phases cost and what was kept in them."""
    yield Table(
        f'{title}: processor time and wake-ups', COSTS,
        [row for phase in phases for row in phase.rows()],
    )
    yield Table(
        f'{title}: lateness and rates', KEPT, [(phase.name, *phase.kept) for phase in phases],
    )


def _one_stack(options: Options) -> Iterator[Phase]:
    with running_stack(f'robot:={options.robot}') as stack:
        yield watched('idle', [stack], options)
        with goals_without_pause(stack, options.robot):
            yield watched('executing', [stack], options)
        with ExitStack() as opened:
            for _ in range(options.clients):
                client = opened.enter_context(peer('listener', domain=stack.domain))
                client.wait_for_line(listener.SETTLED, 120.0)
            yield watched(f'idle, {options.clients} subscribers', [stack], options)


def _side_by_side(options: Options) -> Iterator[Phase]:
    with ExitStack() as opened:
        stacks = [
            opened.enter_context(running_stack(f'robot:={options.robot}', wait=False))
            for _ in range(STACKS)]
        for stack in stacks:
            stack.program.wait_for_line(re.escape(READY), 120.0)
        yield watched(f'idle, each of {STACKS} stacks', stacks, options)


def watched(name: str, stacks: Sequence[Stack], options: Options) -> Phase:
    """Watch stacks for a while: mean costs, and the worst of what each of them keeps."""
    kept = [_Kept(stack, options.robot) for stack in stacks]
    before = [_use_of(stack) for stack in stacks]
    began = time.monotonic()
    time.sleep(max(options.seconds, WINDOW))
    passed = time.monotonic() - began
    after = [_use_of(stack) for stack in stacks]
    scale = 1.0 / (passed * len(stacks))
    costs = {
        process: (
            100.0 * scale * sum(
                end[process][0] - begin[process][0]
                for begin, end in zip(before, after, strict=True)),
            scale * sum(
                end[process][1] - begin[process][1]
                for begin, end in zip(before, after, strict=True)),
        )
        for process in before[0]}
    figures = [each.figures(passed) for each in kept]
    p50, p99 = (max(column) for column in list(zip(*figures, strict=True))[:2])
    clock, states = (min(column) for column in list(zip(*figures, strict=True))[2:])
    return Phase(name, costs, (f'{p50:.0f}', f'{p99:.0f}', f'{clock:.1f}', f'{states:.1f}'))


class _Kept:
    """What a stack publishes while it is watched."""

    def __init__(self, stack: Stack, robot: str) -> None:
        profile = qos_profile_sensor_data
        self._clock = stack.client.collect('/clock', Clock, profile)
        self._states = stack.client.collect(joint_states_of(robot), JointState, profile)
        self._health = stack.client.collect('/diagnostics', DiagnosticArray, profile)
        for collector in (self._clock, self._states, self._health):
            collector.wait(1)
        self._began = len(self._clock.messages), len(self._states.messages)

    def figures(self, seconds: float) -> tuple[float, float, float, float]:
        """Return lateness p50 and p99 [us], rates of clock and joint states [Hz]."""
        counts = len(self._clock.messages), len(self._states.messages)
        rates = [(now - then) / seconds for now, then in zip(counts, self._began, strict=True)]
        values = {
            item.key: item.value
            for message in self._health.messages for status in message.status
            for item in status.values}
        for collector in (self._clock, self._states, self._health):
            collector.close()
        late = [float(values[f'lateness_{key}_us']) for key in ('p50', 'p99')]
        return late[0], late[1], rates[0], rates[1]


def _use_of(stack: Stack) -> dict[str, tuple[float, int]]:
    """Return process -> processor time [s] and wake-ups so far."""
    return {
        name: (processor_seconds(process), _wake_ups(process))
        for name, process in stack.processes().items()}


def _wake_ups(process: int) -> int:
    """Return how often the threads of a process have waited and gone on."""
    count = 0
    for status in Path(f'/proc/{process}/task').glob('*/status'):
        match = re.search(r'^voluntary_ctxt_switches:\s+(\d+)', status.read_text(), re.M)
        count += int(match[1]) if match else 0
    return count
