# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 topic echo``."""

from __future__ import annotations

from argparse import Namespace
from contextlib import suppress
import math
import sys
import time
from typing import Any

from armsim_ros2.commands.names import name_argument
from armsim_ros2.errors import CliError, hint
from armsim_ros2.interfaces import load
from armsim_ros2.parsing import argument, Arguments, flag, hidden, natural_int, positive_float
from armsim_ros2.qos import compatible_profile, qos_options
from armsim_ros2.session import graph_verb, Session
from armsim_ros2.values import dump, field_of, predicate, Style, to_csv, to_yaml

#: Without a message for this time it is checked whether simulated time passes [s].
_SILENCE = 3.0
#: Options of how messages are printed; ``service echo`` has them, too.
PRINTING: list[Arguments] = [
    flag('--csv', about='print the values separated by commas'),
    flag('-f', '--full-length', about='print arrays and texts in full'),
    argument('-l', '--truncate-length', type=natural_int, default=128, metavar='N',
             help='cut arrays and texts to this length (default: %(default)s)'),
    flag('--no-arr', about='print the types and lengths of arrays instead of their elements'),
    flag('--no-str', about='print the lengths of texts instead of the texts'),
    flag('--flow-style', about='print each list in one line'),
]


def style_of(options: Namespace) -> Style:
    """Return how much of a message the options show."""
    return Style(None if options.full_length else options.truncate_length, options.no_arr,
                 options.no_str)


def topic_class(session: Session, topic: str) -> Any | None:
    """
    Return the class of a topic's messages, None if it is not in the graph.

    :raises CliError: it has several types, or its type is not installed.
    """
    types = session.names('topic').get(session.absolute(topic))
    if types and len(types) > 1:
        raise CliError(f"Cannot echo topic '{topic}', as it contains more than one type: "
                       f'[{", ".join(types)}]')
    return load(types[0], 'msg', "The message type '{}' is invalid") if types else None


class _Echo:
    """
    Prints messages as they arrive.

    :param options: of the command line.
    """

    def __init__(self, options: Namespace) -> None:
        self._options = options
        self._style = style_of(options)
        self._field = field_of(options.field) if options.field is not None else None
        self._filter = predicate(options.filter_expr) if options.filter_expr else None
        self.done = False
        self.received = False

    def receive(self, message: Any, info: dict[str, Any]) -> None:
        """Print a message."""
        self.received = True
        if self.done:
            return
        options = self._options
        value = self._field(message) if self._field else message
        if self._filter is not None and not self._filter(value):
            return
        self.done = options.once
        before = ''
        if not hasattr(value, 'SLOT_TYPES'):
            if options.include_message_info:
                before = f'---Got new message, message info:---\n{info}\n---Message data:---\n'
            print(f'{before}{value}\n---')
        elif options.csv:
            if options.include_message_info:
                before = f'{",".join(map(str, info.values()))},'
            print(before + to_csv(value, self._style))
        else:
            if options.include_message_info:
                before = f'{dump(dict(sorted(info.items())))}---\n'
            print(before + to_yaml(value, self._style, options.flow_style) + '---')


def _lost(status: Any) -> None:
    print(f'A message was lost!!!\n\ttotal count change:{status.total_count_change}\n'
          f'\ttotal count: {status.total_count}', end='---\n')


def _echo(session: Session, options: Namespace) -> None:
    from rclpy.event_handler import SubscriptionEventCallbacks, UnsupportedEventTypeError

    echo = _Echo(options)
    topic = session.absolute(options.topic_name)
    kind = (load(options.message_type, 'msg', "The passed message type is invalid: '{}'")
            if options.message_type else session.find(lambda: topic_class(session, topic)))
    if kind is None:
        print(f'WARNING: topic [{options.topic_name}] does not appear to be published yet')
        raise CliError(f"Could not determine the type for the passed topic: '{topic}'"
                       f'{hint(topic, session.names("topic"))}')
    session.settle()
    profile = compatible_profile(options, session.node.get_publishers_info_by_topic(topic))

    def receive(message: Any, info: dict[str, Any]) -> None:
        echo.receive(message, info)

    def subscribe(events: SubscriptionEventCallbacks | None) -> None:
        session.node.create_subscription(
            kind, topic, receive,  # type: ignore[arg-type] # rclpy annotates no info
            profile, event_callbacks=events, raw=options.raw)

    try:
        subscribe(None if options.no_lost_messages
                  else SubscriptionEventCallbacks(message_lost=_lost))
    except UnsupportedEventTypeError:
        subscribe(None)
    end = time.monotonic() + (options.timeout or math.inf)
    if not session.spin(lambda: echo.done or echo.received,
                        min(_SILENCE, end - time.monotonic())):
        _report_silence(session, topic)
    session.spin(lambda: echo.done, end - time.monotonic())


def _report_silence(session: Session, topic: str) -> None:
    """Print why no message comes: nothing publishes, or simulated time does not pass."""
    if not session.node.count_publishers(topic):
        published = [name for name in session.names('topic') if name != topic
                     and session.node.count_publishers(name)]
        same = [name for name in published if name.endswith(topic)]
        print(f"no message: nothing publishes '{topic}'{hint(topic, same or published)}",
              file=sys.stderr)
        return
    name, paused = '/get_simulation_state', 2
    if name not in session.names('service') or not session.node.count_publishers('/clock'):
        return
    with suppress(CliError):
        answer = session.call('simulation_interfaces/srv/GetSimulationState', name, limit=1.0)
        if answer.state.state == paused:
            print('no message: simulated time does not pass (paused or in lockstep)',
                  file=sys.stderr)


ECHO = graph_verb(
    'print the messages of a topic', _echo, name_argument('topic'),
    argument('message_type', nargs='?', help='such as std_msgs/msg/String; by default the '
                                             "publishers'"),
    flag('--once', about='end after the first message'),
    argument('--field', help='print only this part, such as pose.position or points[0]'),
    argument('--filter', dest='filter_expr', metavar='EXPR',
             help='print only messages for which this Python expression of m is true'),
    argument('--timeout', type=positive_float, metavar='S', help='end after this time'),
    *PRINTING,
    flag('--raw', about='print the serialized bytes'),
    flag('--no-lost-messages', about='do not report lost messages'),
    flag('-i', '--include-message-info', about='print time stamps of the transport, too'),
    qos_options('sensor_data'), hidden('topic'))
