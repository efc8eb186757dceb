# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Filters that collect messages of several topics."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import product
import threading
from typing import Any

from rclpy.clock import ROSClock
from rclpy.duration import Duration
import rclpy.logging
from rclpy.node import Node
from rclpy.time import Time


class SimpleFilter:
    """Base of filters: calls those that have registered."""

    def __init__(self) -> None:
        self.callbacks: dict[int, tuple[Callable[..., Any], tuple[Any, ...]]] = {}

    def registerCallback(self, cb: Callable[..., Any], *args: Any) -> int:
        """
        Register a function for what comes out of the filter.

        :param args: given to the function after the messages.
        :returns: the number of the registration.
        """
        number = len(self.callbacks)
        self.callbacks[number] = (cb, args)
        return number

    def signalMessage(self, *msg: Any) -> None:
        """Call all registered functions."""
        for callback, arguments in list(self.callbacks.values()):
            callback(*msg, *arguments)


class Subscriber(SimpleFilter):
    """
    The messages of a topic; attributes of the subscription are also this object's.

    :param kwargs: as of Node.create_subscription (default: qos_profile of 10).
    """

    def __init__(self, node: Node, msg_type: Any, topic: str, **kwargs: Any) -> None:
        super().__init__()
        self.node, self.topic = node, topic
        kwargs.setdefault('qos_profile', 10)
        self.sub = node.create_subscription(msg_type, topic, self.callback, **kwargs)

    def callback(self, msg: Any) -> None:
        """Pass a message on."""
        self.signalMessage(msg)

    def getTopic(self) -> str:
        """Return the topic's name."""
        return self.topic

    def __getattr__(self, key: str) -> Any:
        """Return an attribute of the subscription."""
        if key == 'sub':
            raise AttributeError(key)
        return getattr(self.sub, key)


class Cache(SimpleFilter):
    """
    The last messages of a filter.

    :param f: the filter.
    :param cache_size: how many messages are kept.
    :param allow_headerless: take messages without a header, at the time when they come.
    """

    def __init__(self, f: SimpleFilter, cache_size: int = 1,
                 allow_headerless: bool = False) -> None:
        super().__init__()
        self.cache_size, self.allow_headerless = cache_size, allow_headerless
        self.cache_msgs: list[Any] = []
        self.cache_times: list[Time] = []
        self.connectInput(f)

    def connectInput(self, f: SimpleFilter) -> None:
        """Take the messages of a filter."""
        self.incoming_connection = f.registerCallback(self.add)

    def add(self, msg: Any) -> None:
        """Keep a message and pass it on."""
        stamp = _stamp(msg, self.allow_headerless)
        if stamp is None:
            return
        self.cache_msgs.append(msg)
        self.cache_times.append(stamp)
        del self.cache_msgs[:-self.cache_size], self.cache_times[:-self.cache_size]
        self.signalMessage(msg)

    def getInterval(self, from_stamp: Time, to_stamp: Time) -> list[Any]:
        """Return the messages between two times."""
        assert from_stamp <= to_stamp
        return [msg for msg, time in self._all() if from_stamp <= time <= to_stamp]

    def getElemAfterTime(self, stamp: Time) -> Any:
        """Return the first message at a time or later, None without one."""
        return next((msg for msg, time in self._all() if time >= stamp), None)

    def getElemBeforeTime(self, stamp: Time) -> Any:
        """Return the last message at a time or earlier, None without one."""
        return next((msg for msg, time in reversed(list(self._all())) if time <= stamp), None)

    def getLatestTime(self) -> Time | None:
        """Return the stamp of the message that came last."""
        return self.cache_times[-1] if self.cache_times else None

    def getLastestTime(self) -> Time | None:
        """Return the same as getLatestTime: upstream's spelling in Jazzy."""
        return self.getLatestTime()

    def getOldestTime(self) -> Time | None:
        """Return the stamp of the message that came first."""
        return self.cache_times[0] if self.cache_times else None

    def getLast(self) -> Any:
        """Return the message with the last stamp, None without messages."""
        latest = self.getLatestTime()
        return None if latest is None else self.getElemAfterTime(latest)

    def _all(self) -> Iterator[tuple[Any, Time]]:
        return zip(list(self.cache_msgs), list(self.cache_times), strict=True)


class TimeSynchronizer(SimpleFilter):
    """
    Sets of messages with the same stamp, one of each filter.

    :param fs: the filters.
    :param queue_size: how many messages of each filter wait for the others.
    """

    def __init__(self, fs: Sequence[SimpleFilter], queue_size: int) -> None:
        super().__init__()
        self.queue_size = queue_size
        self.lock = threading.RLock()
        self.connectInput(fs)

    def connectInput(self, fs: Sequence[SimpleFilter]) -> None:
        """Take the messages of filters."""
        #: Of each filter the messages by stamp [ns].
        self.queues: list[dict[int, Any]] = [{} for _ in fs]
        self.input_connections = [
            each.registerCallback(self.add, queue, index)
            for index, (each, queue) in enumerate(zip(fs, self.queues, strict=True))]

    def add(self, msg: Any, my_queue: dict[int, Any], my_queue_index: int | None = None) -> None:
        """Keep a message; pass on what it completes."""
        with self.lock:
            self._keep(Time.from_msg(msg.header.stamp).nanoseconds, msg, my_queue)
            for stamp in sorted(set(self.queues[0]).intersection(*self.queues[1:])):
                self._emit([stamp] * len(self.queues))

    def _keep(self, stamp: int, msg: Any, queue: dict[int, Any]) -> None:
        queue[stamp] = msg
        while len(queue) > self.queue_size:
            del queue[min(queue)]

    def _emit(self, stamps: Sequence[int]) -> None:
        self.signalMessage(
            *(queue.pop(stamp) for queue, stamp in zip(self.queues, stamps, strict=True)))


class ApproximateTimeSynchronizer(TimeSynchronizer):
    """
    Sets of messages with nearly the same stamp, one of each filter.

    :param fs: the filters.
    :param queue_size: how many messages of each filter wait for the others.
    :param slop: by how much the stamps of a set may differ [s].
    :param allow_headerless: take messages without a header, at the time when they come.
    """

    def __init__(self, fs: Sequence[SimpleFilter], queue_size: int, slop: float,
                 allow_headerless: bool = False) -> None:
        super().__init__(fs, queue_size)
        self.slop = Duration(seconds=slop)
        self.allow_headerless = allow_headerless

    def add(self, msg: Any, my_queue: dict[int, Any], my_queue_index: int | None = None) -> None:
        """Keep a message; pass on the nearest set that it completes."""
        time = _stamp(msg, self.allow_headerless)
        if time is None:
            return
        stamp, slop = time.nanoseconds, self.slop.nanoseconds
        with self.lock:
            self._keep(stamp, msg, my_queue)
            if stamp not in my_queue:
                return
            near = [[stamp] if queue is my_queue else sorted(
                (other for other in queue if abs(other - stamp) <= slop),
                key=lambda other: abs(other - stamp)) for queue in self.queues]
            for stamps in product(*near):
                if max(stamps) - min(stamps) < slop:
                    self._emit(stamps)
                    break


def _stamp(msg: Any, allow_headerless: bool) -> Time | None:
    """Return a message's time; log why there is none."""
    stamp = getattr(getattr(msg, 'header', None), 'stamp', None)
    if stamp is not None:
        return stamp if isinstance(stamp, Time) else Time.from_msg(stamp)
    if allow_headerless:
        return ROSClock().now()
    rclpy.logging.get_logger('message_filters').warning(
        f'{type(msg).__name__} has no header with a stamp and is ignored; '
        'allow_headerless=True takes such messages at the time when they come')
    return None
