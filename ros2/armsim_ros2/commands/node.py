# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 node``."""

from __future__ import annotations

from argparse import Namespace
import sys

from armsim_ros2.parsing import argument, flag, node_options, Verb
from armsim_ros2.session import Session, visible


def _list(options: Namespace) -> None:
    with Session(options) as session:
        session.settle()
        names = session.nodes(options.all)
    if options.count_nodes:
        print(len(names))
        return
    if len(set(names)) < len(names):
        print('WARNING: Be aware that there are nodes in the graph that share an exact name, '
              'which can have unintended side effects.', file=sys.stderr)
    for name in names:
        print(name)


def _info(options: Namespace) -> None:
    from rclpy import action

    with Session(options) as session:
        full = session.require_node(options.node_name, options.include_hidden,
                                    message="Unable to find node '{}'")
        session.settle()
        count = session.nodes(options.include_hidden).count(full)
        if count > 1:
            print(f'There are {count} nodes in the graph with the exact name "{full}". '
                  'You are seeing information about only one of them.', file=sys.stderr)
        print(full)
        node = session.node
        namespace, _, name = full.rpartition('/')
        where = (name, namespace or '/')
        for title, found in (
                ('Subscribers', node.get_subscriber_names_and_types_by_node(*where)),
                ('Publishers', node.get_publisher_names_and_types_by_node(*where)),
                ('Service Servers', node.get_service_names_and_types_by_node(*where)),
                ('Service Clients', node.get_client_names_and_types_by_node(*where)),
                ('Action Servers',
                 action.get_action_server_names_and_types_by_node(node, *where)),
                ('Action Clients',
                 action.get_action_client_names_and_types_by_node(node, *where))):
            print(f'  {title}:')
            rows = [f'    {topic}: {", ".join(types)}'
                    for topic, types in visible(found, options.include_hidden).items()]
            print('\n'.join(rows))


VERBS = {
    'info': Verb('print the topics, services and actions of a node', _info, [
        argument('node_name', help='full name of the node'),
        flag('--include-hidden', about='include hidden names'), node_options]),
    'list': Verb('print the nodes of the graph', _list, [
        flag('-a', '--all', about='include hidden nodes'),
        flag('-c', '--count-nodes', about='print only the number of nodes'), node_options]),
}
