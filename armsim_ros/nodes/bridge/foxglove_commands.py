# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What clients of Foxglove publish and call, and the parameters that they see."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from functools import cache, partial
import json
import re
from typing import Any

import foxglove
from rcl_interfaces.msg import ParameterEvent
from rclpy.serialization import deserialize_message, serialize_message

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.bridge.incoming import serialized
from armsim_ros.nodes.bridge.interfaces import load, RefusalError
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.parameters import Parameters, plain_value
from armsim_ros.nodes.bridge.permissions import Permissions
from armsim_ros.nodes.bridge.publishers import profile
from armsim_ros.recording.message_definitions import text_definition
from armsim_ros.resources import share_folder

#: The longest wait for a service [s].
_PATIENCE = 60.0
#: Changes of parameters that may wait.
_DEPTH = 100
#: Of schemas, which are the full text of definitions.
ENCODING = 'ros2msg'
#: Of what clients publish.
ENCODINGS = ('cdr', 'json')

Key = tuple[int, int]


class Commands:
    """
    Publishers of clients, and the services of the graph.

    :param report: shows clients why something was not done.
    """

    def __init__(self, link: BridgeLink, permissions: Permissions,
                 report: Callable[[str], None]) -> None:
        self._link, self._permissions, self._report = link, permissions, report
        self._publishers: dict[Key, tuple[type[Any], str, Any]] = {}
        self._services: dict[str, str] = {}

    def close(self) -> None:
        """Take all publishers away."""
        for key in list(self._publishers):
            self.unadvertise(key)

    def advertise(self, key: Key, topic: str, type_name: str, encoding: str) -> None:
        """Make the publisher of a client's channel; why there is none is reported."""
        try:
            if encoding not in ENCODINGS:
                raise RefusalError(f"unknown encoding '{encoding[:200]}'; allowed: "
                                   f'{", ".join(ENCODINGS)}')
            kind, name = load(type_name, 'msg'), self._link.expand(topic)
            self._permissions.check('publish', 'client_topic', name)
        except ArmsimError as error:
            self._report(f'{topic[:200]} is not published: {error}')
            return
        publisher = self._link.node.create_publisher(kind, name, profile())
        self._publishers[key] = kind, encoding, publisher

    def unadvertise(self, key: Key) -> None:
        """Take the publisher of a client's channel away."""
        found = self._publishers.pop(key, None)
        if found is not None:
            self._link.in_thread(lambda: self._link.node.destroy_publisher(found[2]))

    def publish(self, key: Key, data: bytes) -> None:
        """Publish what a client has sent; what does not fit is reported."""
        found = self._publishers.get(key)
        if found is None:
            return
        kind, encoding, publisher = found
        try:
            publisher.publish(
                serialized(kind, json.loads(data), self._link.now) if encoding == 'json'
                else deserialize_message(data, kind))
        except Exception as error:  # noqa: BLE001 - no message may end the server
            self._report(f'{publisher.topic_name}: a message is dropped: {error}')

    def renew(self, server: Any, services: Mapping[str, str]) -> None:
        """Let the services of the server be those of the graph."""
        gone = [name for name, kind in self._services.items() if services.get(name) != kind]
        if gone:
            server.remove_services(gone)
        for name in gone:
            del self._services[name]
        new = []
        for name, kind in services.items():
            if name not in self._services and (schema := _schema(kind)) is not None:
                self._services[name] = kind
                new.append(foxglove.Service(name, schema=schema,
                                            handler=partial(self._handle, name, kind)))
        if new:
            server.add_services(new)

    def _handle(self, name: str, type_name: str, request: Any) -> bytes:
        """Call a service; in a thread of the SDK, which reports what is raised."""
        kind = load(type_name, 'srv')
        message = deserialize_message(request.payload, kind.Request)
        response = asyncio.run_coroutine_threadsafe(
            self._link.call_when_ready(kind, name, message), self._link.loop).result(_PATIENCE)
        return bytes(serialize_message(response))


class SharedParameters:
    """
    The parameters that clients see, as ``node.name``; ``node:name`` is understood, too.

    :param parameters: of all nodes.
    :param publish: sends values to the clients that follow them.
    :param report: shows clients why a value was not set.
    """

    def __init__(self, link: BridgeLink, parameters: Parameters,
                 publish: Callable[[list[Any]], None], report: Callable[[str], None]) -> None:
        self._link, self._parameters = link, parameters
        self._publish, self._report = publish, report
        self._followed: set[str] = set()
        self._events: Any = None

    async def read(self, names: list[str]) -> list[Any]:
        """Return parameters, all where no names are given."""
        if names:
            found = await self._parameters.values(map(_with_colon, names))
            named = {name: found[plain] for name in names if (plain := _with_colon(name)) in found}
        else:
            named = {name.replace(':', '.', 1): value
                     for name, value in (await self._parameters.all_values()).items()}
        return [foxglove.Parameter(name, value=value) for name, value in named.items()]

    async def write(self, changed: list[Any]) -> None:
        """Set parameters; what a node does not take is reported."""
        for parameter in changed:
            try:
                await self._parameters.set_value(
                    _with_colon(parameter.name), parameter.get_value())
            except ArmsimError as error:
                self._report(f'{parameter.name}: {error}')

    def follow(self, names: list[str]) -> None:
        """Publish these, too, as they change, as far as they may be used."""
        self._followed.update(
            name for name in names if self._parameters.allows(_with_colon(name)))
        if self._events is None and self._followed:
            self._events = self._link.in_thread(lambda: self._link.node.create_subscription(
                ParameterEvent, '/parameter_events', self._changed, _DEPTH))

    def forget(self, names: list[str]) -> None:
        """Publish these no more."""
        self._followed.difference_update(names)
        if self._events is not None and not self._followed:
            events, self._events = self._events, None
            self._link.in_thread(lambda: self._link.node.destroy_subscription(events.result()))

    def _changed(self, event: ParameterEvent) -> None:
        values = [foxglove.Parameter(name, value=plain_value(parameter.value))
                  for parameter in (*event.new_parameters, *event.changed_parameters)
                  for name in (f'{event.node}.{parameter.name}', f'{event.node}:{parameter.name}')
                  if name in self._followed]
        if values:
            self._publish(values)


def _with_colon(name: str) -> str:
    """Return a parameter's name as ``node:name``; the name itself may have dots and colons."""
    return re.sub('[.:]', ':', name, count=1)


@cache
def _schema(type_name: str) -> foxglove.ServiceSchema | None:
    """Return the schemas of request and response, None where they are not installed."""
    package, _, name = type_name.split('/')
    try:
        text = (share_folder(package) / 'srv' / f'{name}.srv').read_text('utf-8')
        request, _, response = text.partition('\n---')
        if text.startswith('---'):
            request, response = '', text[3:]
        parts = [foxglove.MessageSchema(encoding='cdr', schema=foxglove.Schema(
            name=f'{type_name}_{part}', encoding=ENCODING,
            data=text_definition(package, content).encode()))
            for part, content in (('Request', request), ('Response', response))]
    except (ArmsimError, OSError, ValueError):
        return None
    return foxglove.ServiceSchema(type_name, request=parts[0], response=parts[1])
