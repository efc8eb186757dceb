# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The queue between the loop, the executor and the publishing thread."""

import threading

from armsim_ros.nodes.simulation.dispatcher import Dispatcher


def test_calls_are_made_in_order_by_the_thread_that_runs() -> None:
    """Work posted from another thread is done in ours, first come first served."""
    dispatcher = Dispatcher()
    seen: list[tuple[int, threading.Thread]] = []

    def post() -> None:
        for i in range(100):
            dispatcher.post(lambda i=i: seen.append((i, threading.current_thread())))
        dispatcher.post(dispatcher.stop)

    thread = threading.Thread(target=post)
    thread.start()
    dispatcher.run()
    thread.join()
    assert [i for i, _ in seen] == list(range(100))
    assert {who for _, who in seen} == {threading.current_thread()}


def test_stop_before_run_is_not_lost() -> None:
    """A signal during the start ends the run at once."""
    dispatcher = Dispatcher()
    dispatcher.stop()
    dispatcher.run()


def test_later_work_is_done_though_nothing_else_comes() -> None:
    """A deadline is met while the queue is empty."""
    dispatcher = Dispatcher()
    dispatcher.post_later(0.01, dispatcher.stop)
    dispatcher.run()


def test_periodic_work_comes_again() -> None:
    """Work that was asked for every so often is done more than once."""
    dispatcher = Dispatcher()
    calls: list[int] = []

    def work() -> None:
        calls.append(len(calls))
        if len(calls) == 3:
            dispatcher.stop()

    dispatcher.every(0.001, work)
    dispatcher.run()
    assert calls == [0, 1, 2]


def test_what_comes_again_and_again_waits_in_a_bounded_number() -> None:
    """A late thread makes the newest calls of a source, and all of the others."""
    dispatcher = Dispatcher()
    seen: list[tuple[str, int]] = []
    post = dispatcher.bounded(3)
    for i in range(1000):
        post(lambda i=i: seen.append(('tick', i)))
        if i % 100 == 0:
            dispatcher.post(lambda i=i: seen.append(('goal', i)))
    dispatcher.post(dispatcher.stop)
    dispatcher.run()
    assert [i for what, i in seen if what == 'tick'] == [997, 998, 999]
    assert [i for what, i in seen if what == 'goal'] == list(range(0, 1000, 100))


def test_the_last_call_of_a_source_is_always_made() -> None:
    """Whatever thread is quicker, what was posted last is not forgotten."""
    dispatcher = Dispatcher()
    seen: list[int] = []
    post = dispatcher.bounded(1)
    rounds, more = 2000, threading.Semaphore(1)

    def work(i: int) -> None:
        seen.append(i)
        more.release()

    def loop() -> None:
        for i in range(rounds):
            assert more.acquire(timeout=10.0)
            post(lambda i=i: work(i))
            dispatcher.wake()

    thread = threading.Thread(target=loop)
    thread.start()
    runner = threading.Thread(target=dispatcher.run)
    runner.start()
    thread.join()
    dispatcher.post(dispatcher.stop)
    runner.join()
    assert seen == list(range(rounds))


def test_what_the_loop_says_in_a_tick_waits_for_the_end_of_the_tick() -> None:
    """Calls of several sources are made one after the other when the loop is done with them."""
    dispatcher = Dispatcher()
    seen: list[str] = []
    for name in ('clock', 'joint states'):
        dispatcher.bounded()(lambda name=name: seen.append(name))
    dispatcher.bounded()(dispatcher.stop)
    dispatcher.wake()
    dispatcher.run()
    assert seen == ['clock', 'joint states']
