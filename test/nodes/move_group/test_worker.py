# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the threads that compute beside the executor."""

from __future__ import annotations

from collections.abc import Callable, Iterator
import threading
from typing import Any

import pytest

from armsim_ros.nodes.move_group.worker import Job, Worker

PATIENCE = 30.0


class Woken:
    """Stands for the executor, and is told of every job that ends."""

    def __init__(self) -> None:
        self._condition = threading.Condition()

    def wake(self) -> None:
        """Note that something has ended."""
        with self._condition:
            self._condition.notify_all()

    def until(self, condition: Callable[[], bool]) -> None:
        """Look at the begin and whenever woken, until something is so."""
        with self._condition:
            while not condition():
                assert self._condition.wait(PATIENCE), 'nothing woke the executor'


@pytest.fixture
def executor() -> Woken:
    """Give what stands for the executor."""
    return Woken()


@pytest.fixture
def worker(executor: Woken) -> Iterator[Worker]:
    """Give a worker, ended afterwards."""
    made: Any = Worker('test', executor)  # type: ignore[arg-type]
    yield made
    made.close()


def done(executor: Woken, *jobs: Job) -> list[Any]:
    """Return the values of jobs when all of them have one."""
    executor.until(lambda: all(job.done() for job in jobs))
    return [job.result() for job in jobs]


def test_jobs_are_done_in_their_order(worker: Worker, executor: Woken) -> None:
    """Each gives its value."""
    seen: list[int] = []
    jobs = [worker.submit(lambda k=k: seen.append(k) or k) for k in range(5)]
    assert done(executor, *jobs) == seen == [0, 1, 2, 3, 4]


def test_an_exception_is_raised_where_the_job_is_awaited(
    worker: Worker, executor: Woken
) -> None:
    """The next job is done all the same."""
    failing, next_one = worker.submit(lambda: 1 // 0), worker.submit(lambda: 2)
    executor.until(next_one.done)
    with pytest.raises(ZeroDivisionError):
        failing.result()


def test_jobs_that_yield_take_turns(worker: Worker, executor: Woken) -> None:
    """A short job does not wait for the end of a long one."""
    seen: list[str] = []
    gate = threading.Event()

    def long(name: str) -> Iterator[None]:
        gate.wait(PATIENCE)
        for k in range(3):
            seen.append(f'{name}{k}')
            yield
        return name

    jobs = [worker.submit(lambda: long('a')), worker.submit(lambda: long('b')),
            worker.submit(lambda: seen.append('short'))]
    gate.set()
    assert done(executor, *jobs)[:2] == ['a', 'b']
    assert seen == ['a0', 'b0', 'short', 'a1', 'b1', 'a2', 'b2']


def test_a_job_that_is_cancelled_in_the_queue_is_never_begun(
    worker: Worker, executor: Woken
) -> None:
    """Those behind it are done."""
    gate = threading.Event()
    first = worker.submit(lambda: gate.wait(PATIENCE))
    second, third = worker.submit(lambda: 2), worker.submit(lambda: 3)
    second.cancel()
    gate.set()
    assert done(executor, first, third) == [True, 3]
    assert not second.begun


def test_idle_means_that_all_before_is_done(worker: Worker, executor: Woken) -> None:
    """Who waits for it sees what the jobs before have done."""
    seen: list[int] = []
    gate = threading.Event()
    worker.submit(lambda: gate.wait(PATIENCE))
    worker.submit(lambda: seen.append(1))
    waiting = worker.idle().__await__()
    next(waiting)
    gate.set()
    executor.until(lambda: bool(seen))
    for _ in waiting:
        pass
    assert seen == [1]


def test_short_work_is_done_at_once_where_nothing_waits(worker: Worker) -> None:
    """It needs no thread but the caller's, and its errors are raised where it is awaited."""
    job = worker.submit_short(threading.get_ident)
    assert job.done()
    assert job.result() == threading.get_ident()
    with pytest.raises(ZeroDivisionError):
        worker.submit_short(lambda: 1 // 0).result()


def test_short_work_waits_behind_other_jobs(worker: Worker, executor: Woken) -> None:
    """It does not overtake what was submitted before, and the thread does it."""
    gate = threading.Event()
    first = worker.submit(lambda: gate.wait(PATIENCE))
    second = worker.submit_short(threading.get_ident)
    assert not second.done()
    gate.set()
    assert done(executor, first, second)[1] != threading.get_ident()
