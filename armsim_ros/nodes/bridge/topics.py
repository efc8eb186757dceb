# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics from ROS to clients: ``subscribe`` and its end."""

from __future__ import annotations

import asyncio
from collections import deque
from dataclasses import dataclass
from typing import Any

from rclpy.qos import QoSDurabilityPolicy, QoSProfile

from armsim_ros.nodes.bridge.client import Client, Sample
from armsim_ros.nodes.bridge.frames import Part
from armsim_ros.nodes.bridge.interfaces import full_name, Level, RefusalError
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.publications import Publications
from armsim_ros.nodes.bridge.topic_reader import Batch, Received, TopicReader

#: From the strongest on: where several are requested, the first of them is used.
COMPRESSIONS = ('cbor-raw', 'cbor', 'png', 'none')
#: How often changes of the publishers are noticed [s].
_RENEWAL = 0.5


@dataclass(frozen=True)
class Options:
    """What a client requested with an id of a subscription; the rate is in seconds."""

    throttle: float = 0.0
    queue_length: int = 0
    fragment_size: int = 0
    compression: str = 'none'


class Listener:
    """
    A client's subscription to a topic, whatever ids it has.

    :param topic: the name that the client uses.
    """

    def __init__(self, client: Client, topic: str) -> None:
        self.topic = topic
        self.options: dict[Any, Options] = {}
        self._client = client
        self._merged = Options()
        self._held: deque[Sample] = deque()
        self._next = 0.0
        self._timer: asyncio.TimerHandle | None = None

    def change(self, key: Any, options: Options | None) -> None:
        """Add, change or (None) take away an id; then choose what serves all of them."""
        self.options.pop(key, None)
        if options is not None:
            self.options[key] = options
        every = self.options.values()
        if every:
            fragments = [each.fragment_size for each in every if each.fragment_size]
            compressions = [each.compression for each in every]
            self._merged = Options(
                min(each.throttle for each in every), max(each.queue_length for each in every),
                min(fragments, default=0),
                next(name for name in COMPRESSIONS if name in compressions))

    def offer(self, sample: Sample, now: float) -> None:
        """
        Queue a sample, hold it back, or drop it.

        :param now: time of the event loop [s].
        """
        throttle, most = self._merged.throttle, self._merged.queue_length
        if not throttle:
            self._client.outbox.add_sample(self, sample, most)
        elif now >= self._next and not self._held:
            self._next = now + throttle
            self._client.outbox.add_sample(self, sample, most)
        elif most:
            while len(self._held) >= most:
                self._held.popleft()
            self._held.append(sample)
            if self._timer is None:
                self._timer = asyncio.get_running_loop().call_at(self._next, self._release)

    def frames(self, sample: Sample) -> list[Part]:
        """Return the frames that bring a sample to the client."""
        return sample.frames(self.topic, self._merged.compression, self._merged.fragment_size)

    def close(self) -> None:
        """Drop what waits."""
        if self._timer is not None:
            self._timer.cancel()
        self._held.clear()
        self._client.outbox.forget(self)

    def _release(self) -> None:
        self._timer = None
        loop = asyncio.get_running_loop()
        if self._held:
            self._client.outbox.add_sample(self, self._held.popleft(), self._merged.queue_length)
            self._next = loop.time() + self._merged.throttle
        if self._held:
            self._timer = loop.call_at(self._next, self._release)


class Stream:
    """A topic that is subscribed to in ROS, and its listeners."""

    def __init__(self, topic: str, type_name: str, kind: type[Any], profile: QoSProfile) -> None:
        self.topic, self.type_name, self.kind = topic, type_name, kind
        self.profile = profile
        self.listeners: dict[Listener, None] = {}
        self.publications = Publications[Sample]()

    def offer(self, message: Received, stamp: tuple[int, int], now: float) -> None:
        """
        Offer a message to all listeners, unless a new subscription has received it again.

        :param stamp: seconds and nanoseconds of the ROS clock.
        :param now: time of the event loop [s].
        """
        sample = Sample(self.kind, message.raw, stamp)
        if _is_latched(self.profile):
            self.publications.latch(message, sample)
        if self.publications.is_new(message):
            for listener in self.listeners:
                listener.offer(sample, now)

    def offer_latched(self, listener: Listener, now: float) -> None:
        """
        Offer a listener the newest message of each publisher of a latched topic.

        :param now: time of the event loop [s].
        """
        for sample in self.publications.latched():
            listener.offer(sample, now)

    def renew(self, profile: QoSProfile) -> None:
        """Note that the subscription is made anew; what was received before counts on."""
        self.profile = profile
        if not _is_latched(profile):
            self.publications.drop_latched()


class Topics:
    """All subscriptions of all clients; in ROS there is one for each topic."""

    def __init__(self, link: BridgeLink) -> None:
        self._link = link
        self._streams: dict[str, Stream] = {}
        self._making: dict[str, asyncio.Task[Stream]] = {}
        self._of: dict[Client, dict[str, tuple[Stream, Listener]]] = {}
        self._renewal: asyncio.Task[None] | None = None
        self._reader = TopicReader(link, self._deliver)

    def close(self) -> None:
        """Unsubscribe from all."""
        if self._renewal is not None:
            self._renewal.cancel()
        self._reader.close()

    async def subscribe(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``subscribe``."""
        options = _options(message)
        topic, type_name = message['topic'], message.get('type') or ''
        name = self._link.expand(topic)
        type_name = full_name(type_name, 'msg')
        own = self._of.setdefault(client, {})
        if topic in own:
            stream, listener = own[topic]
            _check_type(stream.type_name, type_name)
        else:
            stream = await self._stream(name, type_name)
            listener = Listener(client, topic)
            stream.listeners[listener] = None
            own[topic] = stream, listener
        listener.change(message.get('id'), options)
        stream.offer_latched(listener, asyncio.get_running_loop().time())

    async def unsubscribe(self, client: Client, message: dict[str, Any]) -> None:
        """Serve ``unsubscribe``; without an id, of all ids."""
        topic, key = message['topic'], message.get('id')
        found = self._of.get(client, {}).get(topic)
        if found is None:
            raise RefusalError('there is no such subscription', Level.WARNING)
        stream, listener = found
        if key is not None and key not in listener.options:
            raise RefusalError(f'no subscription with id {key!r}', Level.WARNING)
        if key is not None:
            listener.change(key, None)
        if key is None or not listener.options:
            del self._of[client][topic]
            self._end(stream, listener)

    def drop(self, client: Client) -> None:
        """End all subscriptions of a client."""
        for stream, listener in self._of.pop(client, {}).values():
            self._end(stream, listener)

    def _end(self, stream: Stream, listener: Listener) -> None:
        listener.close()
        stream.listeners.pop(listener, None)
        if not stream.listeners and self._streams.get(stream.topic) is stream:
            del self._streams[stream.topic]
            self._reader.remove(stream.topic)

    async def _stream(self, name: str, type_name: str) -> Stream:
        """Return a topic's stream, made now where there is none; others may wait for the same."""
        while (stream := self._streams.get(name)) is None:
            task = self._making.get(name)
            if task is None:
                task = asyncio.get_running_loop().create_task(self._make(name, type_name))
                self._making[name] = task
                task.add_done_callback(lambda _: self._making.pop(name, None))
            await asyncio.shield(task)
        _check_type(stream.type_name, type_name)
        return stream

    async def _make(self, name: str, type_name: str) -> Stream:
        present = self._link.topic_types().get(name)
        if not type_name:
            type_name = present[0] if present else await self._link.topic_type(name)
        kind = await self._link.load(type_name, 'msg')
        if present:
            _check_type(', '.join(present), type_name)
        stream = Stream(name, type_name, kind, self._link.matching_profile(name))
        self._streams[name] = stream
        await asyncio.wrap_future(self._reader.add(name, kind, name, stream.profile))
        if self._renewal is None or self._renewal.done():
            self._renewal = asyncio.get_running_loop().create_task(self._renew())
        return stream

    async def _renew(self) -> None:
        """Follow the publishers' choices as long as there are subscriptions."""
        while self._streams:
            await asyncio.sleep(_RENEWAL)
            for stream in list(self._streams.values()):
                profile = self._link.matching_profile(stream.topic)
                publishers = self._link.publishers(stream.topic)
                stream.publications.forget_others(publishers)
                if profile != stream.profile and publishers:
                    stream.renew(profile)
                    self._reader.add(stream.topic, stream.kind, stream.topic, profile)

    def _deliver(self, batch: Batch) -> None:
        now, stamp = asyncio.get_running_loop().time(), self._link.now()
        for key, message in batch:
            stream = self._streams.get(key)
            if stream is not None:
                stream.offer(message, stamp, now)


def _is_latched(profile: QoSProfile) -> bool:
    return bool(profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL)


def _options(message: dict[str, Any]) -> Options:
    compression = message.get('compression') or 'none'
    if compression not in COMPRESSIONS:
        raise RefusalError(f"compression is '{compression[:100]}'; allowed: "
                           f'{", ".join(reversed(COMPRESSIONS))}')
    return Options(
        throttle=max(0.0, float(message.get('throttle_rate') or 0.0) / 1000.0),
        queue_length=max(0, message.get('queue_length') or 0),
        fragment_size=message.get('fragment_size') or 0, compression=compression)


def _check_type(present: str, requested: str) -> None:
    if requested and requested not in present.split(', '):
        raise RefusalError(f'the topic has type {present}, not {requested}')
