# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The node ``rosapi``: services with which clients explore the graph.

Clients of the bridge use them without the middleware.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Iterable, Iterator, Mapping
from contextlib import suppress
from functools import partial
import inspect
import json
import os
import re
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.task import Future
from rosapi_msgs import srv
from rosapi_msgs.msg import TypeDef
from rosbridge_msgs.msg import ConnectedClients
from std_msgs.msg import Int32

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes import qos
from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.graph_view import GraphView
from armsim_ros.nodes.bridge.incoming import serialized
from armsim_ros.nodes.bridge.interfaces import full_name, installed, load
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.message_fields import fields_of, FieldType, Kind, Shape
from armsim_ros.nodes.bridge.outgoing import values_of
from armsim_ros.nodes.bridge.parameters import Parameters
from armsim_ros.nodes.bridge.permissions import Permissions
from armsim_ros.nodes.bridge.settings import BridgeSettings
from armsim_ros.nodes.json_text import to_json
from armsim_ros.nodes.polling_node import GuardedNode
from armsim_ros.recording.message_definitions import message_definition

#: Names of services that do not follow from their types.
_NAMES = {'GetActionServers': 'action_servers', 'GetROSVersion': 'get_ros_version'}
#: Service type -> the group of the types that it describes, and the part of them.
_DETAILS = {
    'MessageDetails': ('msg', ''), 'ServiceRequestDetails': ('srv', 'Request'),
    'ServiceResponseDetails': ('srv', 'Response'), 'ActionGoalDetails': ('action', 'Goal'),
    'ActionResultDetails': ('action', 'Result'), 'ActionFeedbackDetails': ('action', 'Feedback')}
#: Type of IDL -> its name in definitions of messages.
_BASIC = {'boolean': 'bool', 'octet': 'byte', 'float': 'float32', 'double': 'float64'}
_WORD = re.compile(r'(?<!^)(?=[A-Z])')
#: How long changes of the clients are gathered [s].
_MOMENT = 0.05

Respond = Callable[[Any], Coroutine[Any, Any, Any]]


class RosApi:
    """
    The services, and the topics that show which clients are connected.

    :param link: to the graph; its thread runs the node.
    :param is_shared: whether there are ROS services, too.
    """

    def __init__(self, link: BridgeLink, settings: BridgeSettings, *, is_shared: bool = True
                 ) -> None:
        self._link = link
        permissions = Permissions.of(settings)
        self._graph = GraphView(link, permissions)
        self._parameters = Parameters(link, permissions.parameters)
        self._since: dict[Client, dict[str, int]] = {}
        self.services: dict[str, tuple[type[Any], Respond]] = {}
        for name, answer in self._answers().items():
            kind = getattr(srv, name)
            self.services[f'/rosapi/{service_name(name)}'] = kind, _responder(kind, answer)
        self._publishers: tuple[Any, Any] | None = None
        self._showing: asyncio.TimerHandle | None = None
        if is_shared:
            link.in_thread(self._make)

    def show_clients(self, clients: Iterable[Client]) -> None:
        """Publish which clients are connected; once for all that come and go in a moment."""
        now = self._stamp()
        self._since = {client: self._since.get(client, now) for client in clients}
        if self._publishers is not None and self._showing is None:
            self._showing = self._link.loop.call_later(_MOMENT, self._show, *self._publishers)

    def _show(self, count: Any, list_of_all: Any) -> None:
        self._showing = None
        clients = [{'ip_address': client.address, 'connection_time': since}
                   for client, since in self._since.items()]
        with suppress(InvalidHandle):  # the program ends
            count.publish(serialized(Int32, {'data': len(clients)}, self._link.now))
            list_of_all.publish(serialized(ConnectedClients, {'clients': clients}, self._link.now))

    def _stamp(self) -> dict[str, Any]:
        return dict(zip(('sec', 'nanosec'), self._link.now(), strict=True))

    def _make(self) -> None:
        """Make node and endpoints; in the link's thread."""
        # A launch file renames the node of rosbridge alone.
        node = GuardedNode('rosapi', context=self._link.node.context, enable_rosout=False,
                           use_global_arguments=False)
        group = ReentrantCallbackGroup()
        for name, (kind, respond) in self.services.items():
            node.create_service(kind, name, self._served(respond), callback_group=group)
        self._link.add_node(node)
        make = self._link.node.create_publisher
        self._publishers = (make(Int32, '/client_count', qos.LATCHED),
                            make(ConnectedClients, '/connected_clients', qos.LATCHED))
        self._link.schedule(lambda: self.show_clients(list(self._since)))

    def _served(self, respond: Respond) -> Callable[[Any, Any], Awaitable[Any]]:
        """Return a callback that is answered in the thread of the sockets."""
        async def served(request: Any, response: Any) -> Any:
            waiting = Future()
            answer: Any = asyncio.run_coroutine_threadsafe(respond(request), self._link.loop)
            answer.add_done_callback(lambda done: self._link.settle(waiting, done))
            return (await waiting).result()

        return served

    def _answers(self) -> dict[str, Callable[[Any], Any]]:
        """Return service type -> the fields of its response."""
        graph, parameters = self._graph, self._parameters
        return {
            'Topics': lambda _: dict(zip(('topics', 'types'), _columns(graph.topics()),
                                         strict=True)),
            'TopicsAndRawTypes': self._raw_types,
            'TopicsForType': lambda request: {
                'topics': _of_type(graph.topics(), request.type, 'msg')},
            'TopicType': lambda request: {
                'type': graph.topic_type(request.topic)},
            'Services': lambda _: {'services': list(graph.services())},
            'ServicesForType': lambda request: {
                'services': _of_type(graph.services(), request.type, 'srv')},
            'ServiceType': lambda request: {
                'type': graph.service_type(request.service)},
            'ServiceNode': lambda request: {
                'node': next(iter(graph.providers([request.service])), '')},
            'ServiceProviders': lambda request: {'providers': graph.providers(
                _of_type(graph.services(), request.service, 'srv'))},
            'Nodes': lambda _: {'nodes': graph.nodes()},
            'NodeDetails': lambda request: dict(zip(
                ('subscribing', 'publishing', 'services'), graph.node_details(request.node),
                strict=True)),
            'Publishers': lambda request: {
                'publishers': graph.ends(request.topic, publish=True)},
            'Subscribers': lambda request: {
                'subscribers': graph.ends(request.topic, publish=False)},
            'GetActionServers': lambda _: {'action_servers': list(graph.actions())},
            'ActionType': lambda request: {'type': graph.action_type(request.action)},
            'Interfaces': lambda _: {'interfaces': sorted(
                f'{package}/{name}' for package, names in installed().items()
                for name in names)},
            **{kind: partial(_details, *parts) for kind, parts in _DETAILS.items()},
            'GetParam': self._get_param,
            'SetParam': lambda request: _outcome(parameters.set(request.name, request.value)),
            'DeleteParam': lambda request: _outcome(parameters.delete(request.name)),
            'HasParam': self._has_param,
            'GetParamNames': self._param_names,
            'GetTime': lambda _: {'time': Time(**self._stamp())},
            'GetROSVersion': lambda _: {
                'version': 2, 'distro': os.environ.get('ROS_DISTRO') or 'jazzy'},
        }

    async def _raw_types(self, _: Any) -> dict[str, Any]:
        topics, types = _columns(self._graph.topics())
        texts = await asyncio.to_thread(lambda: {kind: _text(kind) for kind in types})
        return {'topics': topics, 'types': types,
                'typedefs_full_text': [texts[kind] for kind in types]}

    async def _get_param(self, request: Any) -> dict[str, Any]:
        try:
            value = await self._parameters.value(request.name)
        except ArmsimError as error:
            return {'value': to_json(_parsed(request.default_value)), 'reason': str(error)}
        return {'value': to_json(value), 'successful': True}

    async def _has_param(self, request: Any) -> dict[str, Any]:
        with suppress(ArmsimError):
            await self._parameters.value(request.name)
            return {'exists': True}
        return {}

    async def _param_names(self, _: Any) -> dict[str, Any]:
        return {'names': await self._parameters.names()}


def _columns(known: Mapping[str, str]) -> tuple[list[str], list[str]]:
    """Return names, and the type of each."""
    return list(known), list(known.values())


def _of_type(known: Mapping[str, str], type_name: str, group: str) -> list[str]:
    """Return the names of a type in two or three parts."""
    requested = full_name(type_name, group)
    return [name for name, found in known.items() if found == requested]


def service_name(kind: str) -> str:
    """Return the name of the service of a type, in snake case."""
    return _NAMES.get(kind) or _WORD.sub('_', kind).lower()


def _parsed(text: str) -> Any:
    """Return the value of JSON text; other text is a value itself."""
    try:
        return json.loads(text)
    except ValueError:
        return text


async def _outcome(work: Awaitable[None]) -> dict[str, Any]:
    try:
        await work
    except ArmsimError as error:
        return {'reason': str(error)}
    return {'successful': True}


def _responder(kind: type[Any], answer: Callable[[Any], Any]) -> Respond:
    async def respond(request: Any) -> Any:
        found = answer(request)
        return kind.Response(**(await found if inspect.isawaitable(found) else found))

    return respond


def _text(type_name: str) -> str:
    """Return a type's full definition, '' where no file of it is installed."""
    try:
        return message_definition(type_name)
    except (ArmsimError, OSError, ValueError):
        return ''


async def _details(group: str, part: str, request: Any) -> dict[str, Any]:
    """Describe the requested type; an unknown type has an empty answer."""
    try:
        cls = await asyncio.to_thread(load, request.type, group)
    except ArmsimError:
        return {}
    return {'typedefs': typedefs(getattr(cls, part) if part else cls)}


def typedefs(cls: type[Any]) -> list[TypeDef]:
    """Return the description of a class, then those of all types in it, each once."""
    return [_typedef(found) for found in _classes(cls, set())]


def _classes(cls: type[Any], seen: set[type[Any]]) -> Iterator[type[Any]]:
    seen.add(cls)
    yield cls
    for kind in fields_of(cls).values():
        if kind.message is not None and kind.message not in seen:
            yield from _classes(kind.message, seen)


def _typedef(cls: type[Any]) -> TypeDef:
    found = TypeDef(type=_short_name(cls))
    defaults = values_of(cls())
    for name, kind in fields_of(cls).items():
        found.fieldnames.append(name)
        found.fieldtypes.append(_field_name(kind))
        found.fieldarraylen.append(
            {Shape.SINGLE: -1, Shape.SEQUENCE: 0, Shape.FIXED: kind.size}[kind.shape])
        empty = '{}' if kind.kind is Kind.MESSAGE else to_json(defaults[name])
        found.examples.append('[]' if kind.shape is not Shape.SINGLE else empty)
    for name in vars(type(cls)):  # constants are properties of the class's metaclass
        if name.isupper() and not name.startswith('_') and not name.endswith('__DEFAULT'):
            value = getattr(cls, name)
            found.constnames.append(name)
            found.constvalues.append(
                str(value[0]) if isinstance(value, bytes) and value else str(value))
    return found


def _field_name(kind: FieldType) -> str:
    if kind.message is not None:
        return _short_name(kind.message)
    return _BASIC.get(kind.basic, kind.basic) or 'string'


def _short_name(cls: type[Any]) -> str:
    return f'{cls.__module__.partition(".")[0]}/{cls.__name__}'
