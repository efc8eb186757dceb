# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 service``."""

from __future__ import annotations

from argparse import Namespace
import sys
import time
from typing import Any

from armsim_ros2.commands.topic_echo import PRINTING
from armsim_ros2.errors import CliError
from armsim_ros2.interfaces import load
from armsim_ros2.parsing import (
    argument,
    flag,
    hidden_services,
    node_options,
    positive_float,
    Verb,
    yaml_argument,
)
from armsim_ros2.session import other_types, Session
from armsim_ros2.values import dump, fill, parse, to_csv, to_plain

_UNKNOWN = "Unknown service '{}'"


def _list(options: Namespace) -> None:
    with Session(options) as session:
        session.settle()
        services = session.services(options.include_hidden_services)
    if options.count_services:
        print(len(services))
        return
    for name, types in services.items():
        print(f'{name} [{", ".join(types)}]' if options.show_types else name)


def _type(options: Namespace) -> None:
    with Session(options) as session:
        print(*session.types_of(options.service_name, session.services, _UNKNOWN), sep='\n')


def _find(options: Namespace) -> None:
    with Session(options) as session:
        session.settle()
        found = [name for name, types
                 in session.services(options.include_hidden_services).items()
                 if options.service_type in types]
    print(len(found) if options.count_services else '\n'.join(found),
          end='\n' if options.count_services or found else '')


def _info(options: Namespace) -> None:
    with Session(options) as session:
        types = session.types_of(options.service_name, session.services, _UNKNOWN)
        session.settle()
        name = session.absolute(options.service_name)
        print(f'Type: {types[0] if len(types) == 1 else types}')
        print(f'Clients count: {session.node.count_clients(name)}')
        print(f'Services count: {session.node.count_services(name)}')


def _call(options: Namespace) -> None:
    kind = load(options.service_type, 'srv', "The passed service type is invalid: '{}'")
    request = kind.Request()
    fill(request, parse(sys.stdin.read() if options.stdin else options.values))
    with Session(options) as session:
        name = session.absolute(options.service_name)
        client = session.node.create_client(kind, name)
        if not client.service_is_ready():
            print('waiting for service to become available...')
            if not session.find(client.service_is_ready):
                _refuse_other_type(session, name, options.service_type)
            while not client.service_is_ready():
                time.sleep(0.02)
        while True:
            print(f'requester: making request: {request!r}\n')
            start = time.monotonic()
            future = client.call_async(request)
            session.spin(future.done)
            print(f'response:\n{future.result()!r}\n')
            if options.rate is None:
                return
            time.sleep(max(0.0, start + 1 / options.rate - time.monotonic()))


def _refuse_other_type(session: Session, name: str, kind: str) -> None:
    """Fail if the service exists with another type; a call would wait for ever."""
    others = other_types(session.services().get(name, []), kind)
    if others:
        raise CliError(f"The passed service type is invalid: '{name}' has the type "
                       f"'{others}', not '{kind}'")


def _echo(options: Namespace) -> None:
    with Session(options) as session:
        kind = options.service_type
        if kind is None:
            types = session.types_of(options.service_name, session.services,
                                     "Cannot find type for '{}'")
            if len(types) > 1:
                raise CliError('More than one type associated with service '
                               f"'{options.service_name}': {', '.join(types)}")
            kind = types[0]
        event = load(kind, 'srv', "The service type '{}' is invalid").Event
        topic = f'{session.absolute(options.service_name)}/_service_event'
        _print_events(session, event, topic, options)


def _print_events(session: Session, event: Any, topic: str, options: Namespace) -> None:
    from rclpy.qos import QoSPresetProfiles

    info = load('service_msgs/ServiceEventInfo', 'msg')
    names = {getattr(info, name): name for name in
             ('REQUEST_SENT', 'REQUEST_RECEIVED', 'RESPONSE_SENT', 'RESPONSE_RECEIVED')}
    most = None if options.full_length else options.truncate_length

    def receive(message: Any) -> None:
        if options.csv:
            print(to_csv(message, most, options.no_arr, options.no_str))
            return
        values = to_plain(message, most, options.no_arr, options.no_str)
        values['info']['event_type'] = names[values['info']['event_type']]
        print(dump(values, options.flow_style) + '---')

    subscription = session.node.create_subscription(
        event, topic, receive, QoSPresetProfiles.get_from_short_key('services_default'))
    if not session.find(lambda: session.node.count_publishers(topic)):
        print(f"No publishers on topic '{topic}'; is service introspection on the client or "
              'server enabled?')
    session.spin()
    session.node.destroy_subscription(subscription)


_service = argument('service_name', help='name of the service')
_count = flag('-c', '--count-services', about='print only the number of services')
_rate = argument('-r', '--rate', type=positive_float, metavar='HZ', help='repeat at this rate')

VERBS = {
    'call': Verb('call a service', _call, [
        _service, argument('service_type', help='such as std_srvs/srv/Trigger'),
        yaml_argument('values', 'fields of the request as YAML, such as {a: 1}'), _rate,
        hidden_services, node_options]),
    'echo': Verb('print the requests and responses of a service with introspection', _echo, [
        _service, argument('service_type', nargs='?', help='such as std_srvs/srv/Trigger'),
        *PRINTING, hidden_services, node_options]),
    'find': Verb('print the services of a type', _find, [
        argument('service_type', help='such as std_srvs/srv/Trigger'),
        _count, hidden_services, node_options]),
    'info': Verb('print the type, clients and servers of a service', _info, [
        _service, hidden_services, node_options]),
    'list': Verb('print the services of the graph', _list, [
        flag('-t', '--show-types', about='print their types, too'), _count, hidden_services,
        node_options]),
    'type': Verb('print the type of a service', _type, [_service, hidden_services, node_options]),
}
