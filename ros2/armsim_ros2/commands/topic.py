# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 topic``: the verbs that read the graph, and the table of all."""

from __future__ import annotations

from argparse import Namespace

from armsim_ros2.commands import topic_echo, topic_pub, topic_rates
from armsim_ros2.parsing import argument, flag, hidden_topics, node_options, Verb
from armsim_ros2.session import Session


def _list(options: Namespace) -> None:
    with Session(options) as session:
        session.settle()
        topics = session.topics(options.include_hidden_topics)
        if options.count_topics:
            print(len(topics))
        elif options.verbose:
            node = session.node
            for title, unit, count in (('Published', 'publisher', node.count_publishers),
                                       ('Subscribed', 'subscriber', node.count_subscribers)):
                print(f'{title} topics:')
                for name, types in topics.items():
                    number = count(name)
                    if number:
                        print(f' * {name} [{", ".join(types)}] {number} {unit}'
                              f'{"s" if number > 1 else ""}')
                print()
        else:
            for name, types in topics.items():
                print(f'{name} [{", ".join(types)}]' if options.show_types else name)


def _info(options: Namespace) -> None:
    with Session(options) as session:
        types = session.types_of(options.topic_name, session.topics, "Unknown topic '{}'")
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


def _type(options: Namespace) -> None:
    with Session(options) as session:
        print(*session.types_of(options.topic_name, session.topics, "Unknown topic '{}'"),
              sep='\n')


def _find(options: Namespace) -> None:
    with Session(options) as session:
        session.settle()
        found = [name for name, types in session.topics(options.include_hidden_topics).items()
                 if options.topic_type in types]
    print(len(found) if options.count_topics else '\n'.join(found),
          end='\n' if options.count_topics or found else '')


_topic = argument('topic_name', help='name of the topic')
_count = flag('-c', '--count-topics', about='print only the number of topics')

VERBS = {
    'bw': topic_rates.BW,
    'delay': topic_rates.DELAY,
    'echo': topic_echo.ECHO,
    'find': Verb('print the topics of a type', _find, [
        argument('topic_type', help='such as std_msgs/msg/String'),
        _count, hidden_topics, node_options]),
    'hz': topic_rates.HZ,
    'info': Verb('print the type, publishers and subscriptions of a topic', _info, [
        _topic, flag('-v', '--verbose', about='print nodes, type hashes and QoS, too'),
        hidden_topics, node_options]),
    'list': Verb('print the topics of the graph', _list, [
        flag('-t', '--show-types', about='print their types, too'), _count,
        flag('-v', '--verbose', about='print the numbers of publishers and subscribers, too'),
        hidden_topics, node_options]),
    'pub': topic_pub.PUB,
    'type': Verb('print the type of a topic', _type, [_topic, hidden_topics, node_options]),
}
