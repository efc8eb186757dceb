# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 topic pub``."""

from __future__ import annotations

from argparse import Namespace
import math
import sys
import time
from typing import Any

from armsim_ros2.commands.names import name_argument
from armsim_ros2.commands.rejections import print_rejections
from armsim_ros2.errors import CliError
from armsim_ros2.interfaces import load
from armsim_ros2.parsing import (
    argument,
    exclusive,
    flag,
    hidden,
    natural_int,
    node_options,
    positive_float,
    Verb,
    yaml_argument,
)
from armsim_ros2.qos import profile_of, qos_options
from armsim_ros2.session import Session
from armsim_ros2.values import fill, parse


def _pub(options: Namespace) -> None:
    kind = load(options.message_type, 'msg', "The passed message type is invalid: '{}'")
    values = parse(sys.stdin.read() if options.stdin else options.values)
    message = kind()
    stamps = fill(message, values, stamps=True)
    times = 1 if options.once else options.times
    needed = options.wait_matching_subscriptions
    if needed is None:
        needed = int(times != 0)
    if needed == 0 and options.max_wait_time_secs is not None:
        raise CliError('--max-wait-time-secs option is only effective with '
                       '--wait-matching-subscriptions, --once or --times')
    with Session(options, options.node_name) as session:
        clock = session.node.get_clock()
        topic = session.absolute(options.topic_name)
        publisher = session.node.create_publisher(kind, topic, profile_of(options))
        _wait(session, publisher, needed, options.spin_time,
              options.max_wait_time_secs or math.inf)
        wait_for_rejection = print_rejections(session, topic, kind)
        print('publisher: beginning loop')
        count = 0

        def publish() -> None:
            nonlocal count
            if times and count >= times:
                return
            now = clock.now().to_msg()
            for set_stamp in stamps:
                set_stamp(now)
            count += 1
            if options.print and count % options.print == 0:
                print(f'publishing #{count}: {message!r}\n')
            publisher.publish(message)

        publish()
        if times != 1:
            session.node.create_timer(1 / options.rate, publish)
            session.spin(lambda: 0 < times <= count)
        wait_for_rejection()
        # What was published last is still on its way.
        time.sleep(options.keep_alive)


def _wait(session: Session, publisher: Any, needed: int, spin_time: float, limit: float) -> None:
    """Wait for subscriptions; report it every second after the time of discovery."""
    def matched() -> bool:
        return bool(publisher.get_subscription_count() >= needed)

    session.spin(matched, spin_time)
    end = time.monotonic() + limit
    while not matched():
        left = end - time.monotonic()
        if left <= 0:
            raise CliError(f'Timed out waiting for subscribers: Expected {needed} subcribers but '
                           f'only got {publisher.get_subscription_count()} subscribers')
        print(f'Waiting for at least {needed} matching subscription(s)...')
        session.spin(matched, min(1.0, left))


PUB = Verb('publish messages', _pub, [
    name_argument('topic'), argument('message_type', help='such as std_msgs/msg/String'),
    yaml_argument('values', 'fields of the message as YAML, such as {data: hello}; header: auto '
                            'and stamp: now are the time of publication'),
    argument('-r', '--rate', type=positive_float, default=1.0, metavar='HZ',
             help='messages per second (default: %(default)s)'),
    argument('-p', '--print', type=int, default=1, metavar='N',
             help='print every N-th message (default: %(default)s)'),
    exclusive(flag('-1', '--once', about='publish one message'),
              argument('-t', '--times', type=natural_int, default=0, metavar='N',
                       help='publish so many messages')),
    argument('-w', '--wait-matching-subscriptions', type=natural_int, metavar='N',
             help='wait for so many subscriptions (default: 1 with --once and --times)'),
    argument('--max-wait-time-secs', type=positive_float, metavar='S',
             help='longest time to wait for them (default: no limit)'),
    argument('--keep-alive', type=positive_float, default=0.1, metavar='S',
             help='time to stay after the last message (default: %(default)s)'),
    argument('-n', '--node-name', help='name of the node'),
    qos_options('default'), hidden('topic'), node_options])
