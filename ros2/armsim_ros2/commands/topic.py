# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 topic``: the verbs that read the graph, and the table of all."""

from __future__ import annotations

from argparse import Namespace

from armsim_ros2.commands import topic_echo, topic_pub, topic_rates
from armsim_ros2.commands.names import (
    count_option,
    find_verb,
    name_argument,
    print_names,
    SHOW_TYPES,
    type_verb,
)
from armsim_ros2.parsing import flag, hidden
from armsim_ros2.session import graph_verb, Session


def _list(session: Session, options: Namespace) -> None:
    session.settle()
    topics = session.names('topic', options.hidden)
    if options.count or not options.verbose:
        print_names(topics, options)
        return
    node = session.node
    for title, unit, count in (('Published', 'publisher', node.count_publishers),
                               ('Subscribed', 'subscriber', node.count_subscribers)):
        print(f'{title} topics:')
        for name, types in topics.items():
            number = count(name)
            if number:
                print(f' * {name} [{", ".join(types)}] {number} {unit}{"s" if number > 1 else ""}')
        print()


def _info(session: Session, options: Namespace) -> None:
    types = session.types_of('topic', options.topic_name)
    session.settle()
    topic, node = session.absolute(options.topic_name), session.node
    end = '\n\n' if options.verbose else '\n'
    print(f'Type: {types[0] if len(types) == 1 else types}', end=end)
    for title, count, infos in (
            ('Publisher', node.count_publishers, node.get_publishers_info_by_topic),
            ('Subscription', node.count_subscribers, node.get_subscriptions_info_by_topic)):
        print(f'{title} count: {count(topic)}', end=end)
        for info in infos(topic) if options.verbose else ():
            print(info, end=end)


VERBS = {
    'bw': topic_rates.BW,
    'delay': topic_rates.DELAY,
    'echo': topic_echo.ECHO,
    'find': find_verb('topic', 'std_msgs/msg/String'),
    'hz': topic_rates.HZ,
    'info': graph_verb(
        'print the type, publishers and subscriptions of a topic', _info, name_argument('topic'),
        flag('-v', '--verbose', about='print nodes, type hashes and QoS, too'), hidden('topic')),
    'list': graph_verb(
        'print the topics of the graph', _list, SHOW_TYPES, count_option('topic'),
        flag('-v', '--verbose', about='print the numbers of publishers and subscribers, too'),
        hidden('topic')),
    'pub': topic_pub.PUB,
    'type': type_verb('topic'),
}
