# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 action``."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
import sys
from typing import Any

from armsim_ros2.commands.names import list_verb, name_argument, SHOW_TYPES, type_verb
from armsim_ros2.errors import CliError, hint
from armsim_ros2.interfaces import load
from armsim_ros2.parsing import argument, flag, node_options, Verb, yaml_argument
from armsim_ros2.session import graph_verb, refuse_other_type, Session
from armsim_ros2.values import fill, parse, to_yaml

#: A reason that is published arrives sooner [s].
_REASON = 1.0
#: After this time an answer to a cancel is taken for lost [s].
_AGAIN = 2.0
_STATUSES = ('UNKNOWN', 'ACCEPTED', 'EXECUTING', 'CANCELING', 'SUCCEEDED', 'CANCELED', 'ABORTED')


def _info(session: Session, options: Namespace) -> None:
    from rclpy import action

    name = session.absolute(options.action_name)
    session.find(lambda: session.names('action').get(name))
    session.settle()
    print(f'Action: {options.action_name}')
    for title, names_and_types in (
            ('clients', action.get_action_client_names_and_types_by_node),
            ('servers', action.get_action_server_names_and_types_by_node)):
        found = _endpoints(session, name, names_and_types)
        print(f'Action {title}: {len(found)}')
        for node, types in () if options.count else found:
            print(f'    {node} [{", ".join(types)}]' if options.show_types else f'    {node}')
    known = session.names('action')
    if name not in known:
        print(f"'{name}' is not in the graph{hint(name, known)}", file=sys.stderr)


def _endpoints(session: Session, action: str, names_and_types: Callable[..., Any]
               ) -> list[tuple[str, list[str]]]:
    return [(f'{namespace.rstrip("/")}/{name}', types)
            for name, namespace in session.node.get_node_names_and_namespaces()
            for found, types in names_and_types(session.node, name, namespace) if found == action]


def _send_goal(options: Namespace) -> None:
    from rclpy.action import ActionClient

    kind = load(options.action_type, 'action', "The passed action type is invalid: '{}'")
    goal = kind.Goal()
    fill(goal, parse(sys.stdin.read() if options.stdin else options.goal),
         prefix='Failed to populate message fields')

    def print_feedback(feedback: Any) -> None:
        print(f'Feedback:\n    {to_yaml(feedback.feedback)}')

    with Session(options) as session:
        name = session.absolute(options.action_name)
        client = ActionClient(session.node, kind, name)
        print('Waiting for an action server to become available...')
        if not session.find(client.server_is_ready):
            refuse_other_type(session, 'action', name, options.action_type)
            known = set(session.names('action')) - {name}
            print(f"waiting for '{name}'{hint(name, known)}", file=sys.stderr)
            session.spin(client.server_is_ready)
        print(f'Sending goal:\n     {to_yaml(goal)}')
        accepted = client.send_goal_async(goal, print_feedback if options.feedback else None)
        try:
            session.spin(accepted.done)
            handle = accepted.result()
            if not handle.accepted:
                print('Goal was rejected.', flush=True)
                _print_reason(session, name)
                return
            print(f'Goal accepted with ID: {bytes(handle.goal_id.uuid).hex()}\n')
            result = handle.get_result_async()
            session.spin(result.done)
        except (BrokenPipeError, KeyboardInterrupt, SystemExit):
            _cancel(session, accepted)
            raise
        finally:
            client.destroy()  # it keeps the node in the graph
        _print_result(result.result())


def _print_reason(session: Session, action: str) -> None:
    """Print why a controller rejected a goal, where it publishes that beside its action."""
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import String

    topic = f'{action.rpartition("/")[0]}/rejected_goals'
    if not session.node.count_publishers(topic):
        return
    reasons: list[str] = []

    def receive(message: Any) -> None:
        reasons.append(message.data)

    session.node.create_subscription(
        String, topic, receive,
        QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    if session.spin(lambda: bool(reasons), _REASON):
        print(f'reason: {reasons[-1]}', file=sys.stderr)


def _cancel(session: Session, accepted: Any) -> None:
    """Cancel a goal and wait for its result; a lost answer is asked for again."""
    if not session.spin(accepted.done, 2.0) or not accepted.result().accepted:
        return
    handle = accepted.result()
    print('Canceling goal...')
    result = handle.get_result_async()
    asked = [handle.cancel_goal_async()]
    while not session.spin(lambda: result.done() or asked[-1].done(), _AGAIN):
        asked.append(handle.cancel_goal_async())
    answer = asked[-1].result()
    ended = result.done() or answer.return_code == answer.ERROR_GOAL_TERMINATED
    if not ended and not answer.goals_canceling:
        raise CliError('Failed to cancel goal')
    print('Goal canceled.')
    if session.spin(result.done, 10.0):
        _print_result(result.result())


def _print_result(response: Any) -> None:
    print(f'Result:\n    {to_yaml(response.result)}')
    print(f'Goal finished with status: {_STATUSES[response.status]}')


_action = name_argument('action')

VERBS = {
    'info': graph_verb('print the clients and servers of an action', _info, _action, SHOW_TYPES,
                       flag('-c', '--count', about='print only the numbers')),
    'list': list_verb('action'),
    'send_goal': Verb('send a goal and wait for its result; Ctrl-C cancels it', _send_goal, [
        _action, argument('action_type', help='such as control_msgs/action/GripperCommand'),
        yaml_argument('goal', 'fields of the goal as YAML'),
        flag('-f', '--feedback', about='print feedback'), node_options]),
    'type': type_verb('action'),
}
