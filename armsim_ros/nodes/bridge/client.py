# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Connected clients: what they receive, in which order, and what ends with them."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from rclpy.serialization import serialize_message

from armsim_ros.nodes.bridge.frames import Fragments, Part, text_frames, to_frame
from armsim_ros.nodes.bridge.incoming import aside
from armsim_ros.nodes.bridge.interfaces import Level
from armsim_ros.nodes.bridge.outgoing import cbor_values, json_values, Packed, to_cbor

#: Messages of a topic that wait for a client: of pictures, of others.
MOST_LARGE, MOST_SMALL = 2, 100
#: From this size on a message counts as a picture [bytes].
LARGE = 100_000
#: From this size on it is encoded in a thread, so that other clients do not wait [bytes].
_ASIDE = 1 << 14
_ENCODER = ThreadPoolExecutor(1, 'encoding')


class Sample:
    """
    A message of a topic, encoded when a client takes it, and once for all clients.

    :param kind: its class.
    :param raw: its serialized form (CDR).
    :param stamp: seconds and nanoseconds of the ROS clock.
    """

    __slots__ = ('_frames', '_kind', 'raw', 'stamp')

    def __init__(self, kind: type[Any], raw: bytes | memoryview, stamp: tuple[int, int]) -> None:
        self._kind, self.raw, self.stamp = kind, raw, stamp
        self._frames: dict[tuple[str, str, int], list[Part]] = {}

    def frames(self, topic: str, compression: str, fragment_size: int) -> list[Part]:
        """Return the frames that bring it to a client."""
        key = topic, compression, fragment_size
        found = self._frames.get(key)
        if found is None:
            found = self._frames[key] = self._encode(*key)
        return found

    def _encode(self, topic: str, compression: str, fragment_size: int) -> list[Part]:
        if compression == 'cbor-raw':
            seconds, nanoseconds = self.stamp
            return to_frame(*to_cbor({'op': 'publish', 'topic': topic, 'msg': {
                'secs': seconds, 'nsecs': nanoseconds, 'bytes': Packed(memoryview(self.raw))}}),
                binary=True)
        if compression == 'cbor':
            return to_frame(*to_cbor({'op': 'publish', 'topic': topic,
                                     'msg': cbor_values(self._kind)(self.raw)}), binary=True)
        return text_frames({'op': 'publish', 'topic': topic,
                            'msg': json_values(self._kind)(self.raw)}, fragment_size, compression)


class Waiting:
    """A sample in an outbox; it is empty once it was dropped."""

    __slots__ = ('listener', 'sample')

    def __init__(self, listener: Any, sample: Sample) -> None:
        self.listener = listener
        self.sample: Sample | None = sample


class Outbox:
    """
    What waits for a client: answers first, then samples in the order of their arrival.

    A slow client loses the oldest samples of a topic, never an answer.

    :param most_bytes: of all that waits.
    """

    def __init__(self, most_bytes: int) -> None:
        self._most_bytes = most_bytes
        self._answers: deque[list[Part]] = deque()
        self._answer_bytes = 0
        self._samples: deque[Waiting] = deque()
        self._of: dict[Any, deque[Waiting]] = {}
        self._sample_bytes = 0
        self._news = asyncio.Event()
        self.overflows = False
        """Whether an answer was added to others that exceed the limit: nothing is read."""

    def add_answer(self, frames: list[Part]) -> None:
        """Queue frames that must arrive."""
        self.overflows = self._answer_bytes > self._most_bytes
        self._answers.append(frames)
        self._answer_bytes += sum(map(len, frames))
        self._news.set()

    def add_sample(self, listener: Any, sample: Sample, most: int = 0) -> None:
        """
        Queue a sample for a listener, which has ``frames(sample)``.

        :param most: how many of its samples may wait; 0 for the usual number.
        """
        limit = MOST_LARGE if len(sample.raw) >= LARGE else MOST_SMALL
        own = self._of.setdefault(listener, deque())
        while len(own) >= (min(most, limit) if most else limit):
            self._drop(own[0])
        entry = Waiting(listener, sample)
        own.append(entry)
        self._samples.append(entry)
        self._sample_bytes += len(sample.raw)
        while self._sample_bytes > self._most_bytes and self._samples[0] is not entry:
            self._drop(self._samples[0])
        self._news.set()

    def forget(self, listener: Any) -> None:
        """Drop all samples of a listener."""
        for entry in list(self._of.get(listener, ())):
            self._drop(entry)

    async def wait(self) -> None:
        """Wait until there is something to take."""
        await self._news.wait()

    async def take(self) -> list[Part]:
        """Return the frames of the next message, none where it was dropped meanwhile."""
        if self._answers:
            frames = self._answers.popleft()
            self._answer_bytes -= sum(map(len, frames))
            return frames
        if not self._samples:
            self._news.clear()
            return []
        entry, sample = self._samples[0], self._samples[0].sample
        assert sample is not None  # what was dropped does not stay in front
        self._drop(entry)
        if len(sample.raw) < _ASIDE:
            return entry.listener.frames(sample)  # type: ignore[no-any-return] # of a listener
        return await asyncio.get_running_loop().run_in_executor(
            _ENCODER, entry.listener.frames, sample)

    def _drop(self, entry: Waiting) -> None:
        """Take an entry out; in the middle of the queue an empty entry stays."""
        if entry.sample is not None:
            self._sample_bytes -= len(entry.sample.raw)
            entry.sample = None
            own = self._of[entry.listener]
            own.remove(entry)
            if not own:
                del self._of[entry.listener]
        while self._samples and self._samples[0].sample is None:
            self._samples.popleft()


class Client:
    """
    A client as the parts of the bridge see it.

    :param address: where it is.
    :param most_bytes: of what waits for it.
    :param fragment_timeout: [s].
    :param overflow: called where it does not read its answers.
    """

    def __init__(self, address: str, most_bytes: int, fragment_timeout: float,
                 overflow: Callable[[], None]) -> None:
        self.address = address
        self.level = Level.ERROR
        self.is_open = True
        self.outbox = Outbox(most_bytes)
        self.fragments = Fragments(fragment_timeout)
        self._overflow = overflow
        self._tasks: set[asyncio.Task[Any]] = set()

    def send(self, message: dict[str, Any], key: Any = None) -> None:
        """Send an answer, which is never dropped, with the id of its request where it has one."""
        if self.is_open:
            self._queue(text_frames(message if key is None else {**message, 'id': key}))

    async def answer(
        self, request: Mapping[str, Any], found: dict[str, Any], message: Any, *,
        compression: str = 'none', adapt: Callable[[dict[str, Any]], Any] = lambda values: values,
    ) -> None:
        """
        Send an answer whose values are a message; a large one is encoded beside other work.

        :param adapt: changes the values.
        """
        raw, key = serialize_message(message), request.get('id')

        def encode() -> list[Part]:
            values = adapt(json_values(type(message))(raw))
            return text_frames({**found, 'values': values, **({} if key is None else {'id': key})},
                               request.get('fragment_size') or 0, compression)

        self._queue(await aside(len(raw), encode))

    def report(self, level: Level, text: str, key: Any = None) -> None:
        """Send a status message, where the client wants those of this level."""
        if level <= self.level:
            self.send({'op': 'status', 'level': level.name.lower(), 'msg': text}, key)

    def start(self, work: Coroutine[Any, Any, None]) -> None:
        """Do something beside the client's next requests; it ends with the client."""
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _queue(self, frames: list[Part]) -> None:
        if not self.is_open:
            return
        self.outbox.add_answer(frames)
        if self.outbox.overflows:
            self._overflow()

    def close(self) -> None:
        """End what was started for it."""
        self.is_open = False
        for task in self._tasks:
            task.cancel()


#: Serves an operation; an ArmsimError that it raises is reported to the client.
Handler = Callable[[Client, dict[str, Any]], Awaitable[None]]
