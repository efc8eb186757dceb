# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What clients of Foxglove publish and call."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from functools import partial
import json
from typing import Any

import foxglove
from rclpy.serialization import deserialize_message, serialize_message

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.bridge.conversion.incoming import serialized
from armsim_ros.nodes.bridge.foxglove.schemas import service_schema
from armsim_ros.nodes.bridge.interfaces import load
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.permissions import Permissions
from armsim_ros.nodes.bridge.publishers import profile

#: The longest wait for a service [s].
_PATIENCE = 60.0

Key = tuple[int, int]


class Commands:
    """Publishers of clients, and the services of the graph."""

    def __init__(self, link: BridgeLink, permissions: Permissions) -> None:
        self._link, self._permissions = link, permissions
        self._publishers: dict[Key, tuple[type[Any], str, Any]] = {}
        self._services: dict[str, str] = {}

    def close(self) -> None:
        """Take all publishers away."""
        for key in list(self._publishers):
            self.unadvertise(key)

    def advertise(self, key: Key, topic: str, type_name: str, encoding: str) -> None:
        """Make the publisher of a client's channel."""
        try:
            kind, name = load(type_name, 'msg'), self._link.expand(topic)
            self._permissions.check('publish', 'topic', name)
        except ArmsimError as error:
            self._link.node.get_logger().warning(f'foxglove: {topic}: {error}')
            return
        publisher = self._link.node.create_publisher(kind, name, profile())
        self._publishers[key] = kind, encoding, publisher

    def unadvertise(self, key: Key) -> None:
        """Take the publisher of a client's channel away."""
        found = self._publishers.pop(key, None)
        if found is not None:
            self._link.in_thread(lambda: self._link.node.destroy_publisher(found[2]))

    def publish(self, key: Key, data: bytes) -> None:
        """Publish what a client has sent; what does not fit is logged."""
        found = self._publishers.get(key)
        if found is None:
            return
        kind, encoding, publisher = found
        try:
            publisher.publish(
                serialized(kind, json.loads(data), self._link.now) if encoding == 'json'
                else deserialize_message(data, kind))
        except Exception as error:  # noqa: BLE001 - no message may end the server
            self._link.node.get_logger().warning(f'foxglove: {publisher.topic_name}: {error}')

    def renew(self, server: Any, services: Mapping[str, str]) -> None:
        """Let the services of the server be those of the graph."""
        gone = [name for name, kind in self._services.items() if services.get(name) != kind]
        if gone:
            server.remove_services(gone)
        for name in gone:
            del self._services[name]
        new = []
        for name, kind in services.items():
            if name not in self._services and (schema := service_schema(kind)) is not None:
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
