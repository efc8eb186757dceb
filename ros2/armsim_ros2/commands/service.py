# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 service``."""

from __future__ import annotations

from argparse import Namespace
import sys
import time
from typing import Any

from armsim_ros2.commands.names import find_verb, list_verb, name_argument, type_verb
from armsim_ros2.commands.rejections import print_rejections
from armsim_ros2.commands.topic_echo import PRINTING, style_of
from armsim_ros2.errors import CliError
from armsim_ros2.interfaces import load
from armsim_ros2.parsing import argument, hidden, node_options, positive_float, Verb, yaml_argument
from armsim_ros2.session import graph_verb, refuse_other_type, Session
from armsim_ros2.values import dump, fill, parse, to_csv, to_plain


def _info(session: Session, options: Namespace) -> None:
    types = session.types_of('service', options.service_name)
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
                refuse_other_type(session, 'service', name, options.service_type)
            while not client.service_is_ready():
                time.sleep(0.02)
        wait_for_rejection = print_rejections(session, name, kind)
        while True:
            print(f'requester: making request: {request!r}\n')
            start = time.monotonic()
            future = client.call_async(request)
            session.spin(future.done)
            print(f'response:\n{future.result()!r}\n')
            if not getattr(future.result(), 'success', True):
                wait_for_rejection()
            if options.rate is None:
                return
            time.sleep(max(0.0, start + 1 / options.rate - time.monotonic()))


def _echo(session: Session, options: Namespace) -> None:
    from rclpy.qos import QoSPresetProfiles

    types = [options.service_type] if options.service_type else session.types_of(
        'service', options.service_name, "Cannot find type for '{1}'")
    if len(types) > 1:
        raise CliError('More than one type associated with service '
                       f"'{options.service_name}': {', '.join(types)}")
    event = load(types[0], 'srv', "The service type '{}' is invalid").Event
    topic = f'{session.absolute(options.service_name)}/_service_event'
    info = load('service_msgs/ServiceEventInfo', 'msg')
    names = {getattr(info, name): name for name in
             ('REQUEST_SENT', 'REQUEST_RECEIVED', 'RESPONSE_SENT', 'RESPONSE_RECEIVED')}
    style = style_of(options)

    def receive(message: Any) -> None:
        if options.csv:
            print(to_csv(message, style))
            return
        values = to_plain(message, style)
        values['info']['event_type'] = names[values['info']['event_type']]
        print(dump(values, options.flow_style) + '---')

    session.node.create_subscription(
        event, topic, receive, QoSPresetProfiles.get_from_short_key('services_default'))
    if not session.find(lambda: session.node.count_publishers(topic)):
        print(f"No publishers on topic '{topic}'; is service introspection on the client or "
              'server enabled?')
    session.spin()


_service = name_argument('service')

VERBS = {
    'call': Verb('call a service', _call, [
        _service, argument('service_type', help='such as std_srvs/srv/Trigger'),
        yaml_argument('values', 'fields of the request as YAML, such as {a: 1}'),
        argument('-r', '--rate', type=positive_float, metavar='HZ', help='repeat at this rate'),
        hidden('service'), node_options]),
    'echo': graph_verb(
        'print the requests and responses of a service with introspection', _echo, _service,
        argument('service_type', nargs='?', help='such as std_srvs/srv/Trigger'), *PRINTING,
        hidden('service')),
    'find': find_verb('service', 'std_srvs/srv/Trigger'),
    'info': graph_verb('print the type, clients and servers of a service', _info, _service,
                       hidden('service')),
    'list': list_verb('service'),
    'type': type_verb('service'),
}
