# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 topic hz``, ``bw`` and ``delay``."""

from __future__ import annotations

from argparse import Namespace
from collections import deque
from collections.abc import Callable, Sequence
import sys
import time
from typing import Any

from armsim_ros2.commands.topic_echo import topic_class
from armsim_ros2.errors import CliError
from armsim_ros2.parsing import argument, Arguments, hidden, positive_int
from armsim_ros2.session import graph_verb, Session
from armsim_ros2.values import predicate


def _subscribe(session: Session, topic: str, receive: Callable[[Any], None], raw: bool = False
               ) -> None:
    """Subscribe to a topic; wait until it is published."""
    from rclpy.qos import qos_profile_sensor_data

    kind = session.find(lambda: topic_class(session, topic))
    if kind is None:
        print(f'WARNING: topic [{topic}] does not appear to be published yet')
        while kind is None:
            time.sleep(0.1)
            kind = topic_class(session, topic)
    session.node.create_subscription(kind, session.absolute(topic), receive,
                                     qos_profile_sensor_data, raw=raw)


def summary(title: str, average: float, samples: Sequence[int]) -> str:
    """
    Return the text about a window.

    :param samples: times [ns].
    """
    import numpy

    return (f'{title}: {average:.3f}\n\tmin: {min(samples) * 1e-9:.3f}s '
            f'max: {max(samples) * 1e-9:.3f}s std dev: {numpy.std(samples) * 1e-9:.5f}s '
            f'window: {len(samples)}')


class Intervals:
    """
    Times between messages.

    :param window: number of intervals that count.
    """

    def __init__(self, window: int) -> None:
        self._intervals: deque[int] = deque(maxlen=window)
        self._last = -1
        self._printed = 0

    def add(self, now: int) -> None:
        """
        Note a message.

        :param now: time of its arrival [ns]; 0 while there is no simulated time.
        """
        if now == 0 or now < self._last:
            if now == 0 and self._intervals:
                print('time has reset, resetting counters')
            self._intervals.clear()
        elif self._last >= 0:
            self._intervals.append(now - self._last)
        self._last = now or -1

    def report(self) -> str | None:
        """Return the text about the last window, None within 1 s after the text before."""
        if not self._intervals:
            return None
        if self._printed == 0 or self._last < self._printed:
            self._printed = self._last
            return None
        if self._last < self._printed + 1_000_000_000:
            return None
        self._printed = self._last
        mean = sum(self._intervals) / len(self._intervals)
        return summary('average rate', 1e9 / mean if mean > 0 else 0.0, self._intervals)


def _hz(session: Session, options: Namespace) -> None:
    accept = predicate(options.filter_expr) if options.filter_expr else None
    intervals = Intervals(options.window)
    clock = session.node.get_clock()

    def receive(message: Any) -> None:
        if accept is None or accept(message):
            intervals.add(time.time_ns() if options.wall_time else clock.now().nanoseconds)
            text = intervals.report()
            if text:
                print(text)

    _subscribe(session, options.topic, receive, raw=accept is None)
    session.spin()


def bandwidth_text(sizes: Sequence[int], duration: float) -> str:
    """
    Return the text about a window of messages.

    :param sizes: of the messages [B].
    :param duration: from the first message until now [s].
    """
    rate = sum(sizes) / duration
    if rate < 1000:
        scale, digits, unit = 1.0, 0, 'B'
    elif rate < 1_000_000:
        scale, digits, unit = 1e3, 2, 'KB'
    else:
        scale, digits, unit = 1e6, 2, 'MB'
    total, mean, least, greatest = (
        f'{value / scale:.{digits}f} {unit}'
        for value in (rate, sum(sizes) / len(sizes), min(sizes), max(sizes)))
    return (f'{total}/s from {len(sizes)} messages\n'
            f'\tMessage size mean: {mean} min: {least} max: {greatest}')


def _bw(session: Session, options: Namespace) -> None:
    window: deque[tuple[int, int]] = deque(maxlen=options.window)
    clock = session.node.get_clock()

    def report() -> None:
        if len(window) < 2:
            return
        duration = (clock.now().nanoseconds - window[0][0]) * 1e-9
        if duration <= 0:
            print('WARNING: time is reset!', file=sys.stderr)
            window.clear()
            return
        print(bandwidth_text([size for _, size in window], duration))

    _subscribe(session, options.topic,
               lambda data: window.append((clock.now().nanoseconds, len(data))), raw=True)
    print(f'Subscribed to [{options.topic}]')
    session.node.create_timer(1.0, report)
    session.spin()


def _delay(session: Session, options: Namespace) -> None:
    delays: deque[int] = deque(maxlen=options.window)
    new = False
    clock = session.node.get_clock()

    def receive(message: Any) -> None:
        nonlocal new
        stamp = getattr(getattr(message, 'header', None), 'stamp', None)
        if stamp is None:
            raise CliError(f"msg does not have header: topic '{options.topic}'")
        now = clock.now().nanoseconds
        if now == 0:
            if delays:
                print('time has reset, resetting counters')
            delays.clear()
            return
        delays.append(now - stamp.sec * 1_000_000_000 - stamp.nanosec)
        new = True

    def report() -> None:
        nonlocal new
        if not delays:
            return
        if not new:
            print('no new messages')
            return
        new = False
        print(summary('average delay', sum(delays) / len(delays) * 1e-9, delays))

    _subscribe(session, options.topic, receive)
    session.node.create_timer(1.0, report)
    session.spin()


def _window(default: int) -> Arguments:
    return argument('-w', '--window', type=positive_int, default=default, metavar='N',
                    help='number of messages that count (default: %(default)s)')


_topic = argument('topic', help='name of the topic')

HZ = graph_verb(
    'print the rate of a topic', _hz, _topic, _window(10000),
    argument('--filter', dest='filter_expr', metavar='EXPR',
             help='count only messages for which this Python expression of m is true'),
    argument('--wall-time', action='store_true', help='measure with the system clock'),
    hidden('topic'))
BW = graph_verb('print the bandwidth of a topic', _bw, _topic, _window(100), hidden('topic'))
DELAY = graph_verb('print the age of messages by the stamp of their header', _delay, _topic,
                   _window(10000), hidden('topic'))
