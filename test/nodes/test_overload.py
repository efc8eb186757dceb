# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When a machine is called overloaded."""

from __future__ import annotations

import pytest

from armsim_ros.nodes.watching import OverloadWatch, thread_times


class Machine:
    """Threads with invented times, and the lines that were reported."""

    def __init__(self) -> None:
        self.now = 0.0
        self.times = {'1': (0.0, 0.0), '2': (0.0, 0.0)}
        self.reported: list[str] = []
        self.watch = OverloadWatch(
            'program', read=lambda: dict(self.times), report=self.reported.append)
        self.watch.look(self.now)

    def run(self, seconds: float, used: float, waited: float) -> None:
        """Let a thread compute and wait for shares of a time, and look."""
        self.now += seconds
        before = self.times['2']
        self.times['2'] = before[0] + used * seconds, before[1] + waited * seconds
        self.watch.look(self.now)


@pytest.fixture
def machine() -> Machine:
    """Give a machine at rest."""
    return Machine()


def test_a_program_that_computes_is_no_overload(machine: Machine) -> None:
    """Neither at full speed, nor where it shares a processor."""
    machine.run(10.0, 1.0, 0.0)
    machine.run(10.0, 0.45, 0.55)
    assert machine.reported == []


def test_a_starved_program_says_so_once_a_minute(machine: Machine) -> None:
    """With how long it had to wait."""
    for _ in range(7):
        machine.run(10.0, 0.1, 0.85)
    assert len(machine.reported) == 2
    assert 'of the last 10 s the program had to wait 8.5 s' in machine.reported[0]
    assert machine.watch.is_overloaded


def test_it_ends_when_the_load_does(machine: Machine) -> None:
    """What is late from then on has another reason."""
    machine.run(10.0, 0.1, 0.85)
    machine.run(10.0, 0.1, 0.0)
    assert not machine.watch.is_overloaded


def test_the_kernel_counts_the_threads_of_this_process() -> None:
    """This one has computed."""
    assert any(used > 0.0 for used, _ in thread_times().values())
