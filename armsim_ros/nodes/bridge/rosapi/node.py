# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The node ``rosapi`` and its services; clients of the bridge use them without the middleware."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Iterable, Mapping
import inspect
import os
import re
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.task import Future
from rosapi_msgs import srv
from rosbridge_msgs.msg import ConnectedClient, ConnectedClients
from std_msgs.msg import Int32

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes import qos
from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.interfaces import full_name, installed, load
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.rosapi.graph import Graph
from armsim_ros.nodes.bridge.rosapi.parameters import Parameters
from armsim_ros.nodes.bridge.rosapi.typedefs import typedefs
from armsim_ros.nodes.bridge.settings import BridgeSettings
from armsim_ros.nodes.polling_node import GuardedNode
from armsim_ros.recording.message_definitions import message_definition

#: Names of services that do not follow from their types.
_NAMES = {'GetActionServers': 'action_servers', 'GetROSVersion': 'get_ros_version'}
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
        self._graph = Graph(link)
        self._parameters = Parameters(link, settings.params_glob)
        self._since: dict[Client, Time] = {}
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
        now = self._time()
        self._since = {client: self._since.get(client, now) for client in clients}
        if self._publishers is not None and self._showing is None:
            self._showing = self._link.loop.call_later(_MOMENT, self._show, *self._publishers)

    def _show(self, count: Any, list_of_all: Any) -> None:
        self._showing = None
        shown = [ConnectedClient(ip_address=client.address, connection_time=since)
                 for client, since in self._since.items()]
        count.publish(Int32(data=len(shown)))
        list_of_all.publish(ConnectedClients(clients=shown))

    def _time(self) -> Time:
        seconds, nanoseconds = self._link.now()
        return Time(sec=seconds, nanosec=nanoseconds)

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
            'Topics': lambda _: {'topics': list(graph.topics()),
                                 'types': list(graph.topics().values())},
            'TopicsAndRawTypes': self._raw_types,
            'TopicsForType': lambda request: {
                'topics': _of_type(graph.topics(), request.type, 'msg')},
            'TopicType': lambda request: {
                'type': graph.type_of(request.topic, self._link.topic_types())},
            'Services': lambda _: {'services': list(graph.services())},
            'ServicesForType': lambda request: {
                'services': _of_type(graph.services(), request.type, 'srv')},
            'ServiceType': lambda request: {
                'type': graph.type_of(request.service, self._link.service_types())},
            'ServiceNode': lambda request: {
                'node': next(iter(graph.providers([request.service])), '')},
            'ServiceProviders': lambda request: {
                'providers': graph.providers(
                    _of_type(graph.services(), request.service, 'srv'))},
            'Nodes': lambda _: {'nodes': graph.nodes()},
            'NodeDetails': lambda request: dict(zip(
                ('subscribing', 'publishing', 'services'), graph.node_details(request.node),
                strict=True)),
            'Publishers': lambda request: {
                'publishers': graph.ends(request.topic, publish=True)},
            'Subscribers': lambda request: {
                'subscribers': graph.ends(request.topic, publish=False)},
            'GetActionServers': lambda _: {'action_servers': self._link.action_names()},
            'ActionType': lambda request: {'type': graph.type_of(
                f'{request.action}/_action/send_goal', self._link.service_types()
                ).removesuffix('_SendGoal')},
            'Interfaces': lambda _: {'interfaces': sorted(
                f'{package}/{name}' for package, names in installed().items()
                for name in names)},
            'MessageDetails': lambda request: self._details(request.type, 'msg'),
            'ServiceRequestDetails': lambda request: self._details(request.type, 'srv', 'Request'),
            'ServiceResponseDetails': lambda request: self._details(
                request.type, 'srv', 'Response'),
            'ActionGoalDetails': lambda request: self._details(request.type, 'action', 'Goal'),
            'ActionResultDetails': lambda request: self._details(request.type, 'action', 'Result'),
            'ActionFeedbackDetails': lambda request: self._details(
                request.type, 'action', 'Feedback'),
            'GetParam': self._get_param,
            'SetParam': lambda request: _outcome(parameters.set(request.name, request.value)),
            'DeleteParam': lambda request: _outcome(parameters.delete(request.name)),
            'HasParam': self._has_param,
            'GetParamNames': self._param_names,
            'GetTime': lambda _: {'time': self._time()},
            'GetROSVersion': lambda _: {
                'version': 2, 'distro': os.environ.get('ROS_DISTRO') or 'jazzy'},
        }

    async def _details(self, type_name: str, group: str, part: str = '') -> dict[str, Any]:
        try:
            cls = await asyncio.to_thread(load, type_name, group)
        except ArmsimError:
            return {}
        return {'typedefs': typedefs(getattr(cls, part) if part else cls)}

    async def _raw_types(self, _: Any) -> dict[str, Any]:
        topics = self._graph.topics()
        texts = await asyncio.to_thread(lambda: {kind: _text(kind) for kind in topics.values()})
        return {'topics': list(topics), 'types': list(topics.values()),
                'typedefs_full_text': [texts[kind] for kind in topics.values()]}

    async def _get_param(self, request: Any) -> dict[str, Any]:
        try:
            return {'value': await self._parameters.get(request.name), 'successful': True}
        except ArmsimError as error:
            return {'value': request.default_value or '""', 'reason': str(error)}

    async def _has_param(self, request: Any) -> dict[str, Any]:
        return {'exists': await self._parameters.exists(request.name)}

    async def _param_names(self, _: Any) -> dict[str, Any]:
        return {'names': await self._parameters.names()}


def _of_type(known: Mapping[str, str], type_name: str, group: str) -> list[str]:
    """Return the names of a type in two or three parts."""
    requested = full_name(type_name, group)
    return [name for name, found in known.items() if found == requested]


def service_name(kind: str) -> str:
    """Return the name of the service of a type, in snake case."""
    return _NAMES.get(kind) or _WORD.sub('_', kind).lower()


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
