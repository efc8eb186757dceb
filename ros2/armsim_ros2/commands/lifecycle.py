# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 lifecycle``."""

from __future__ import annotations

from argparse import Namespace
import sys
from typing import Any

from armsim_ros2.errors import CliError, hint
from armsim_ros2.parsing import argument, flag, node_options, Verb
from armsim_ros2.session import Session

_GET_STATE = 'lifecycle_msgs/srv/GetState'


def _lifecycle_nodes(session: Session, hidden: bool) -> list[str]:
    services = session.services()
    return sorted({node for node in session.nodes(hidden)
                   if _GET_STATE in services.get(f'{node}/get_state', ())})


def _require(session: Session, options: Namespace) -> str:
    name = options.node_name
    full = name if name.startswith('/') else f'/{name}'
    hidden = options.include_hidden_nodes
    if not session.find(lambda: full in _lifecycle_nodes(session, hidden)):
        raise CliError(f"Node not found: '{name}'"
                       f'{hint(full, _lifecycle_nodes(session, hidden))}')
    return full


def _nodes(options: Namespace) -> None:
    with Session(options) as session:
        session.settle()
        names = _lifecycle_nodes(session, options.all)
    if options.count_nodes:
        print(len(names))
        return
    for name in names:
        print(name)


def _get(options: Namespace) -> None:
    with Session(options) as session:
        if options.node_name:
            names = [_require(session, options)]
        else:
            session.settle()
            names = _lifecycle_nodes(session, options.include_hidden_nodes)
        for name in names:
            state = session.call(_GET_STATE, f'{name}/get_state').current_state
            print(f'{"" if options.node_name else f"{name}: "}{state.label} [{state.id}]')


def _transitions(session: Session, name: str, service: str = 'get_available_transitions'
                 ) -> list[Any]:
    response = session.call('lifecycle_msgs/srv/GetAvailableTransitions', f'{name}/{service}')
    return list(response.available_transitions)


def _list(options: Namespace) -> None:
    with Session(options) as session:
        name = _require(session, options)
        service = 'get_transition_graph' if options.all else 'get_available_transitions'
        for entry in _transitions(session, name, service):
            print(f'- {entry.transition.label} [{entry.transition.id}]\n'
                  f'\tStart: {entry.start_state.label}\n\tGoal: {entry.goal_state.label}')


def _set(options: Namespace) -> None:
    with Session(options) as session:
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


_name = argument('node_name', help='name of the node')
_hidden = flag('--include-hidden-nodes', about='include hidden nodes')

VERBS = {
    'get': Verb('print the states of lifecycle nodes', _get, [
        argument('node_name', nargs='?', help='name of the node; all nodes by default'),
        _hidden, node_options]),
    'list': Verb('print the transitions that are available', _list, [
        _name, flag('-a', '--all', about='print all transitions'), _hidden, node_options]),
    'nodes': Verb('print the lifecycle nodes', _nodes, [
        flag('-a', '--all', about='include hidden nodes'),
        flag('-c', '--count-nodes', about='print only the number of nodes'), node_options]),
    'set': Verb('trigger a transition', _set, [
        _name, argument('transition', help='label or number of the transition'), _hidden,
        node_options]),
}
