# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 node``."""

from __future__ import annotations

from argparse import Namespace
import sys

from armsim_ros2.commands.names import count_option
from armsim_ros2.parsing import argument, flag
from armsim_ros2.session import graph_verb, Session, visible


def _list(session: Session, options: Namespace) -> None:
    session.settle()
    names = session.nodes(options.all)
    if options.count:
        print(len(names))
        return
    if len(set(names)) < len(names):
        print('WARNING: Be aware that there are nodes in the graph that share an exact name, '
              'which can have unintended side effects.', file=sys.stderr)
    for name in names:
        print(name)


def _info(session: Session, options: Namespace) -> None:
    from rclpy import action

    node, hidden = session.node, options.include_hidden
    full = session.require_node(options.node_name, hidden, message="Unable to find node '{}'")
    session.settle()
    count = session.nodes(hidden).count(full)
    if count > 1:
        print(f'There are {count} nodes in the graph with the exact name "{full}". '
              'You are seeing information about only one of them.', file=sys.stderr)
    print(full)
    namespace, _, name = full.rpartition('/')
    where = (name, namespace or '/')
    for title, found in (
            ('Subscribers', node.get_subscriber_names_and_types_by_node(*where)),
            ('Publishers', node.get_publisher_names_and_types_by_node(*where)),
            ('Service Servers', node.get_service_names_and_types_by_node(*where)),
            ('Service Clients', node.get_client_names_and_types_by_node(*where)),
            ('Action Servers', action.get_action_server_names_and_types_by_node(node, *where)),
            ('Action Clients', action.get_action_client_names_and_types_by_node(node, *where))):
        rows = [f'    {topic}: {", ".join(types)}'
                for topic, types in visible(found, hidden).items()]
        print(f'  {title}:', '\n'.join(rows), sep='\n')


ALL = flag('-a', '--all', about='include hidden nodes')

VERBS = {
    'info': graph_verb('print the topics, services and actions of a node', _info,
                       argument('node_name', help='full name of the node'),
                       flag('--include-hidden', about='include hidden names')),
    'list': graph_verb('print the nodes of the graph', _list, ALL, count_option('node')),
}
