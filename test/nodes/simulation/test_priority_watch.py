# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When a simulation gives up its real-time priority, and takes it again."""

from __future__ import annotations

import os
import threading

import pytest

from armsim_ros.nodes.simulation import threads as priority_watch
from armsim_ros.nodes.simulation.threads import (
    PriorityWatch,
    real_time_use,
    RealTimeThreads,
    time_under_pressure,
)

ME, OTHER = os.getpid(), 1


class Machine:
    """Two processors with an invented pressure, and invented real-time programs."""

    def __init__(self) -> None:
        self.waited = 0.0
        self.used = {ME: 0.0, OTHER: 0.0}
        self.real_time = True
        self.lines: list[str] = []
        self._now = 0.0
        self._watch = PriorityWatch(
            self._switch, self.lines.append, waited=lambda: self.waited,
            used=lambda: dict(self.used), processors=2)
        self._watch.check(0.0)

    def _switch(self, real_time: bool) -> None:
        self.real_time = real_time
        if real_time:
            self.used[ME] = 0.0
        else:
            del self.used[ME]

    def run(self, pressure: float, **cores: float) -> bool:
        """Let programs use cores for 10 s; return whether this one has its priority."""
        for _ in range(2):
            self._now += 5.0
            self.waited += 5.0 * pressure
            for process, share in ((ME, cores.get('me', 0.0)), (OTHER, cores.get('other', 0.0))):
                if process in self.used:
                    self.used[process] += 5.0 * share
            self._watch.check(self._now)
        return self.real_time


@pytest.fixture
def machine() -> Machine:
    """Give a machine at rest."""
    return Machine()


def test_a_single_simulation_keeps_its_priority(machine: Machine) -> None:
    """Under any load, as it leaves most of the machine to others."""
    assert machine.run(1.0, me=0.6)
    assert machine.lines == []


def test_without_others_that_wait_it_keeps_its_priority(machine: Machine) -> None:
    """However much real-time programs use."""
    assert machine.run(0.2, me=1.0, other=0.9)


def test_it_gives_way_where_others_starve(machine: Machine) -> None:
    """One line has the pressure and what real-time programs use."""
    assert not machine.run(0.95, me=0.3, other=1.3)
    assert not machine.run(0.95, other=1.3)
    (line,) = machine.lines
    assert '95% of the time, while those in real time use 80% of all processors' in line


@pytest.mark.parametrize(('pressure', 'other'), [(0.1, 1.3), (0.95, 0.2)])
def test_it_takes_its_priority_again(machine: Machine, pressure: float, other: float) -> None:
    """Once nobody waits, or once other real-time programs leave enough, but not at once."""
    machine.run(0.95, me=0.3, other=1.3)
    assert not machine.run(pressure, other=other)
    for _ in range(2):
        machine.run(pressure, other=other)
    assert machine.real_time
    assert machine.lines[1:] == ['real-time priority taken again']


def test_the_checks_come_before_the_simulation(monkeypatch: pytest.MonkeyPatch) -> None:
    """Simulations that take all processors cannot keep their priority by it."""
    try:
        before = os.sched_getscheduler(0)
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    except OSError:
        pytest.skip('no permission for real-time priority')
    os.sched_setscheduler(0, before, os.sched_param(0))
    monkeypatch.setattr(priority_watch, 'PERIOD', 0.01)
    priorities: list[int] = []
    checked = threading.Event()

    def waited() -> float:
        priorities.append(os.sched_getparam(0).sched_priority)
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        checked.set()
        threading.Event().wait()
        return 0.0

    PriorityWatch(lambda _: None, lambda _: None, waited=waited).start()
    assert checked.wait(10)
    assert priorities[0] == priority_watch.CHECKS


def test_the_threads_get_their_priorities_back() -> None:
    """Each its own; a new thread the least."""
    priorities = []

    def work() -> None:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(3))
        except PermissionError:
            return
        threads = RealTimeThreads()
        me = threading.get_native_id()
        try:
            threads.switch(False)
            priorities.append(os.sched_getscheduler(me))
            threads.switch(True)
            priorities.append(os.sched_getparam(me).sched_priority)
        finally:
            RealTimeThreads().switch(False)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    if not priorities:
        pytest.skip('no permission for real-time priority')
    assert priorities == [os.SCHED_OTHER, 3]


def test_the_machine_is_read() -> None:
    """Times are not negative."""
    assert time_under_pressure() >= 0.0
    assert all(time >= 0.0 for time in real_time_use().values())
