# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 lifecycle``."""

from __future__ import annotations

from argparse import Namespace
import sys
from typing import Any

from armsim_ros2.commands.names import count_option, name_argument
from armsim_ros2.commands.node import ALL
from armsim_ros2.errors import CliError
from armsim_ros2.parsing import argument, flag, hidden
from armsim_ros2.session import graph_verb, Session

_GET_STATE = 'lifecycle_msgs/srv/GetState'


def _lifecycle_nodes(session: Session, hidden: bool) -> list[str]:
    services = session.names('service')
    return sorted({node for node in session.nodes(hidden)
                   if _GET_STATE in services.get(f'{node}/get_state', ())})


def _require(session: Session, options: Namespace) -> str:
    return session.require_node(options.node_name, options.hidden,
                                known=lambda hidden: _lifecycle_nodes(session, hidden))


def _nodes(session: Session, options: Namespace) -> None:
    session.settle()
    names = _lifecycle_nodes(session, options.all)
    if options.count:
        print(len(names))
        return
    for name in names:
        print(name)


def _get(session: Session, options: Namespace) -> None:
    if options.node_name:
        names = [_require(session, options)]
    else:
        session.settle()
        names = _lifecycle_nodes(session, options.hidden)
    for name in names:
        state = session.call(_GET_STATE, f'{name}/get_state').current_state
        print(f'{"" if options.node_name else f"{name}: "}{state.label} [{state.id}]')


def _transitions(session: Session, name: str, service: str = 'get_available_transitions'
                 ) -> list[Any]:
    response = session.call('lifecycle_msgs/srv/GetAvailableTransitions', f'{name}/{service}')
    return list(response.available_transitions)


def _list(session: Session, options: Namespace) -> None:
    name = _require(session, options)
    service = 'get_transition_graph' if options.all else 'get_available_transitions'
    for entry in _transitions(session, name, service):
        print(f'- {entry.transition.label} [{entry.transition.id}]\n'
              f'\tStart: {entry.start_state.label}\n\tGoal: {entry.goal_state.label}')


def _set(session: Session, options: Namespace) -> None:
    name = _require(session, options)
    known = [entry.transition for entry in _transitions(session, name)]
    found = ([entry for entry in known if entry.label == options.transition]
             or [entry for entry in known if str(entry.id) == options.transition])
    if not found:
        raise CliError('Unknown transition requested, available ones are:'
                       + ''.join(f'\n- {entry.label} [{entry.id}]' for entry in known))
    response = session.call('lifecycle_msgs/srv/ChangeState', f'{name}/change_state',
                            limit=60.0, transition=found[0])
    if response.success:
        print('Transitioning successful')
    else:
        print('Transitioning failed', file=sys.stderr)


_name, _hidden = name_argument('node'), hidden('node')

VERBS = {
    'get': graph_verb(
        'print the states of lifecycle nodes', _get,
        argument('node_name', nargs='?', help='name of the node; all nodes by default'), _hidden),
    'list': graph_verb('print the transitions that are available', _list, _name,
                       flag('-a', '--all', about='print all transitions'), _hidden),
    'nodes': graph_verb('print the lifecycle nodes', _nodes, ALL, count_option('node')),
    'set': graph_verb(
        'trigger a transition', _set, _name,
        argument('transition', help='label or number of the transition'), _hidden),
}
