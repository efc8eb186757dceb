# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics from clients to ROS: ``advertise``, ``publish`` and their ends."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import Any

from rclpy.duration import Duration
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy

from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.incoming import serialized_of
from armsim_ros.nodes.bridge.interfaces import full_name, Level, RefusalError
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.message_fields import type_name

#: A subscriber that is found within this time gets what was published before [s].
_LIFESPAN = 1.0
_DEPTH = 100


@dataclass
class Entry:
    """A publisher and its users: client -> the ids with which it was advertised."""

    kind: type[Any]
    publisher: Any
    users: dict[Client, set[Any]] = field(default_factory=dict)


class Publishers:
    """
    All publishers; clients share those that are not latched.

    A client has one publisher for a topic. Once that is latched it stays so, as long as one of its
    ids is advertised; otherwise what was published before would be gone.

    :param linger: how long one stays after its last user [s].
    """

    def __init__(self, link: BridgeLink, linger: float) -> None:
        self._link, self._linger = link, linger
        self._entries: dict[Any, Entry] = {}
        self._making: dict[Any, asyncio.Lock] = {}
        self._of: dict[Client, dict[str, tuple[Any, Entry]]] = {}

    async def advertise(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``advertise``."""
        latch = bool(message.get('latch'))
        await self._advertise(client, message['topic'], full_name(message['type'], 'msg'),
                              message.get('id'), latch)

    async def publish(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``publish``."""
        topic = message['topic']
        own = self._of.get(client, {}).get(topic)
        if own is None:
            name = self._link.expand(topic)
            kind = await self._link.topic_type(name)
            await self._advertise(client, topic, kind, None, bool(message.get('latch')))
            own = self._of[client][topic]
        entry = own[1]
        entry.publisher.publish(
            await serialized_of(entry.kind, message.get('msg', {}), self._link.now))

    async def unadvertise(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``unadvertise``."""
        found = self._of.get(client, {}).get(message['topic'])
        key = message.get('id')
        if found is None or (key is not None and key not in found[1].users[client]):
            raise RefusalError('it is not advertised', Level.WARNING)
        found[1].users[client].discard(key)
        if key is None or not found[1].users[client]:
            del self._of[client][message['topic']]
            self._leave(client, *found)

    def drop(self, client: Client) -> None:
        """End all of a client."""
        for key, entry in self._of.pop(client, {}).values():
            self._leave(client, key, entry)

    async def _advertise(self, client: Client, topic: str, requested: str, key: Any, latch: bool
                         ) -> None:
        name = self._link.expand(topic)
        kind = await self._link.load(requested, 'msg')
        present = self._link.topic_types().get(name)
        if present and requested not in present:
            raise RefusalError(f'the topic has type {", ".join(present)}, not {requested}')
        shared: tuple[str, Client | None] = name, client
        if not latch and shared not in self._entries:
            shared = name, None
        own = self._of.setdefault(client, {})
        async with self._making.setdefault(shared, asyncio.Lock()):
            entry = self._entries.get(shared)
            if entry is not None and type_name(entry.kind) != requested:
                raise RefusalError(f'the topic has type {type_name(entry.kind)}, not {requested}')
            if entry is None:
                publisher = await self._link.run(
                    lambda: self._link.node.create_publisher(kind, name, profile(latch)))
                entry = self._entries[shared] = Entry(kind, publisher)
        keys = entry.users.setdefault(client, set())
        keys.add(key)
        before = own.get(topic)
        own[topic] = shared, entry
        if before is not None and before[1] is not entry:
            keys |= before[1].users[client]
            self._leave(client, *before)

    def _leave(self, client: Client, key: Any, entry: Entry) -> None:
        if any(other is entry for _, other in self._of.get(client, {}).values()):
            return  # under another of its names
        entry.users.pop(client, None)
        if not entry.users:
            asyncio.get_running_loop().call_later(self._linger, self._end, key, entry)

    def _end(self, key: Any, entry: Entry) -> None:
        if not entry.users and self._entries.get(key) is entry:
            del self._entries[key]
            self._making.pop(key, None)
            self._link.in_thread(lambda: self._link.node.destroy_publisher(entry.publisher))


def profile(latch: bool = False) -> QoSProfile:
    """Return what a publisher of a client offers."""
    common = {'reliability': QoSReliabilityPolicy.RELIABLE,
              'durability': QoSDurabilityPolicy.TRANSIENT_LOCAL}
    if latch:
        return QoSProfile(depth=1, **common)
    return QoSProfile(depth=_DEPTH, lifespan=Duration(seconds=_LIFESPAN), **common)
