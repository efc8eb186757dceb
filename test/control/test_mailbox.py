# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Requests of other threads."""

from concurrent.futures import ThreadPoolExecutor

from armsim_ros.control.mailbox import Mailbox


def test_requests_keep_their_order_and_wake_the_loop():
    """Requests come out as they went in, so many as are wanted; each one wakes."""
    woken = []
    mailbox = Mailbox(lambda: woken.append(1))
    for request in range(5):
        mailbox.post(request)
    assert mailbox.take(2) == [0, 1]
    assert mailbox.take_all() == [2, 3, 4]
    assert not mailbox
    assert mailbox.take(3) == mailbox.take_all() == []
    assert len(woken) == 5


def test_two_threads_take_each_request_once():
    """While two threads empty the mailbox nothing is lost, taken twice, or raised."""
    mailbox = Mailbox(lambda: None)
    for _ in range(50):
        for request in range(200):
            mailbox.post(request)
        with ThreadPoolExecutor(2) as pool:
            halves = list(pool.map(lambda _: mailbox.take_all(), range(2)))
        assert sorted(halves[0] + halves[1]) == list(range(200))


def test_a_full_mailbox_keeps_the_newest():
    """Of a stream that nobody takes, the oldest goes."""
    mailbox = Mailbox(lambda: None, capacity=2)
    for request in range(5):
        mailbox.post(request)
    assert mailbox.take_all() == [3, 4]
    assert not mailbox
