# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Subscriptions in a wait set and a thread of their own, apart from services and actions.

A large message holds others up in two places. rclpy's own function copies it twice while no other
thread runs: for a tenth of a second where it has 50 MB. The same function of rcl, called by
ctypes, lets them run. And the middleware receives all topics of a context in one thread, which
waits until such a copy is made. So another node reads topics whose messages may be so large.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
import ctypes
from functools import cache, partial
import threading
from typing import Any, NamedTuple

import numpy as np
from rclpy.exceptions import InvalidHandle
from rclpy.guard_condition import GuardCondition
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from armsim_ros.nodes.bridge.client import LARGE, MOST_LARGE, MOST_SMALL
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.message_fields import CODES, fields_of, Shape
from armsim_ros.nodes.polling_node import OutsideExecutors

#: How long the thread may take to end [s].
_END = 5.0
#: From this size on a message is copied by numpy, which lets other threads run [bytes].
_COPIED_ASIDE = 1 << 20
_OK, _NOTHING = 0, 401
_Pointer = ctypes.c_void_p
_GID_SIZE = 16


class Received(NamedTuple):
    """
    A message that was received.

    :param raw: its serialized form (CDR).
    :param publisher: the publisher's GID.
    :param number: of the publication; each publisher counts its own.
    """

    raw: bytes | memoryview
    publisher: bytes
    number: int


#: The keys of subscriptions with their messages, in order of reception.
Batch = list[tuple[Any, Received]]


class TopicReader:
    """
    Reads serialized messages and hands them over in batches.

    A topic whose newest message was not small is read beside the others.

    :param link: whose node subscribes.
    :param deliver: gets a batch in the thread of the sockets: keys with messages, in order.
    :param node: that subscribes; None for those of the link.
    """

    def __init__(self, link: BridgeLink, deliver: Callable[[Batch], None],
                 node: Node | None = None) -> None:
        self._link, self._deliver = link, deliver
        self._apart = TopicReader(link, deliver, link.large.node) if node is None else None
        self._node = node = node or link.node
        self._group = OutsideExecutors()
        self._guard = GuardCondition(None, None, node.context)
        self._subscriptions: dict[Any, Subscription] = {}
        self._work: deque[Callable[[], None]] = deque()
        self._lock = threading.Lock()
        self._read: dict[Any, deque[tuple[int, Received]]] = {}
        self._small: set[Any] = set()
        self._busy: set[Any] = set()
        self._aside = ThreadPoolExecutor(2, 'large topics')
        self._count = 0
        self._scheduled = False
        self._closing = False
        self._thread = threading.Thread(target=self._run, name='topics', daemon=True)
        self._thread.start()

    def add(self, key: Any, kind: type[Any], topic: str, profile: QoSProfile) -> Future[None]:
        """Subscribe; what had this key before is gone then."""
        return self._in_thread(partial(self._add, key, kind, topic, profile))

    def remove(self, key: Any) -> Future[None]:
        """Unsubscribe."""
        return self._in_thread(partial(self._remove, key))

    def close(self) -> None:
        """End the thread and all subscriptions."""
        self._closing = True
        self._trigger()
        self._thread.join(_END)
        self._aside.shutdown(wait=False)
        if self._apart is not None:
            self._apart.close()

    def _in_thread(self, work: Callable[[], None]) -> Future[None]:
        done: Future[None] = Future()

        def run() -> None:
            try:
                work()
            except Exception as error:  # noqa: BLE001 - belongs to its waiter
                done.set_exception(error)
            else:
                done.set_result(None)

        self._work.append(run)
        self._trigger()
        return done

    def _trigger(self) -> None:
        self._guard.trigger()

    def _add(self, key: Any, kind: type[Any], topic: str, profile: QoSProfile) -> None:
        self._remove(key)
        if self._apart is not None and _may_be_large(kind):
            self._apart.add(key, kind, self._node.resolve_topic_name(topic), profile).result()
            return
        self._subscriptions[key] = self._node.create_subscription(
            kind, topic, lambda _: None, profile, callback_group=self._group, raw=True)

    def _remove(self, key: Any) -> None:
        self._destroy(key)
        if self._apart is not None:
            self._apart.remove(key)

    def _destroy(self, key: Any) -> None:
        subscription = self._subscriptions.pop(key, None)
        if subscription is not None:
            self._node.destroy_subscription(subscription)
        self._small.discard(key)
        with self._lock:
            self._read.pop(key, None)

    def _run(self) -> None:
        context = self._node.context.handle
        assert context is not None  # the node was made in it
        wait_set, capacity = None, -1
        while not self._closing:
            while self._work:
                self._work.popleft()()
            subscriptions = [(key, found) for key, found in self._subscriptions.items()
                             if key not in self._busy]
            if wait_set is None or len(subscriptions) != capacity:
                capacity = len(subscriptions)
                with context:
                    wait_set = _rclpy.WaitSet(capacity, 1, 0, 0, 0, 0, context)
            try:
                self._wait(wait_set, subscriptions)
            except (InvalidHandle, RuntimeError):  # rclpy's errors are such, too
                if not self._node.context.ok():
                    return
        for key in list(self._subscriptions):
            self._destroy(key)
        self._guard.destroy()

    def _wait(self, wait_set: Any, subscriptions: list[tuple[Any, Subscription]]) -> None:
        with ExitStack() as alive:
            wait_set.clear_entities()
            alive.enter_context(self._guard.handle)
            wait_set.add_guard_condition(self._guard.handle)
            for _, subscription in subscriptions:
                alive.enter_context(subscription.handle)
                wait_set.add_subscription(subscription.handle)
            wait_set.wait(-1)
            ready = set(wait_set.get_ready_entities('subscription'))
            for key, subscription in subscriptions:
                if subscription.handle.pointer in ready and key in self._small:
                    self._take(key, subscription)
                elif subscription.handle.pointer in ready:
                    self._busy.add(key)
                    self._aside.submit(self._take_aside, key, subscription)

    def _take_aside(self, key: Any, subscription: Subscription) -> None:
        """Read what may be large, and takes long, while others are read."""
        try:
            with subscription.handle:
                self._take(key, subscription)
        except (InvalidHandle, RuntimeError):
            pass  # it is gone
        finally:
            self._busy.discard(key)
            self._trigger()

    def _take(self, key: Any, subscription: Subscription) -> None:
        """Read what has come; of what the other thread has not taken, the newest is kept."""
        for _ in range(max(subscription.qos_profile.depth, 1)):
            message = take(subscription.handle)
            if message is None:
                break
            is_large = len(message.raw) >= LARGE
            (self._small.discard if is_large else self._small.add)(key)
            with self._lock:
                waiting = self._read.setdefault(key, deque())
                if len(waiting) >= (MOST_LARGE if is_large else MOST_SMALL):
                    waiting.popleft()
                self._count += 1
                waiting.append((self._count, message))
                schedule, self._scheduled = not self._scheduled, True
            if schedule:
                self._link.schedule(self._hand_over)

    def _hand_over(self) -> None:
        with self._lock:
            read, self._read, self._scheduled = self._read, {}, False
        self._deliver([(key, message) for _, key, message in sorted(
            (count, key, message) for key, waiting in read.items()
            for count, message in waiting)])


def _may_be_large(kind: type[Any]) -> bool:
    """Return whether a message has bytes without a bound, as pictures, clouds and maps have."""
    return any(each.shape is Shape.SEQUENCE and not each.size
               and CODES.get(each.basic) in ('b', 'B') for each in fields_of(kind).values())


class _Allocator(ctypes.Structure):
    """``rcutils_allocator_t``."""

    _fields_ = tuple((name, _Pointer) for name in (
        'allocate', 'deallocate', 'reallocate', 'zero_allocate', 'state'))


class _Bytes(ctypes.Structure):
    """``rcutils_uint8_array_t``."""

    _fields_ = (('buffer', _Pointer), ('length', ctypes.c_size_t), ('capacity', ctypes.c_size_t),
                ('allocator', _Allocator))


class _MessageInfo(ctypes.Structure):
    """``rmw_message_info_t``."""

    _fields_ = (('source_timestamp', ctypes.c_int64), ('received_timestamp', ctypes.c_int64),
                ('publication_sequence_number', ctypes.c_uint64),
                ('reception_sequence_number', ctypes.c_uint64),
                ('implementation_identifier', _Pointer),
                ('publisher_gid', ctypes.c_uint8 * _GID_SIZE),
                ('from_intra_process', ctypes.c_bool))


@cache
def _libraries() -> tuple[Any, Any]:
    """Return rcl and rcutils, which rclpy has loaded."""
    rcl, rcutils = ctypes.CDLL('librcl.so'), ctypes.CDLL('librcutils.so')
    rcl.rcl_take_serialized_message.argtypes = [_Pointer, ctypes.POINTER(_Bytes),
                                                ctypes.POINTER(_MessageInfo), _Pointer]
    rcutils.rcutils_get_default_allocator.restype = _Allocator
    return rcl, rcutils


def take(handle: Any) -> Received | None:
    """
    Return the next message of a subscription, None where there is none.

    :param handle: of the subscription; it stays alive meanwhile.
    :raises RuntimeError: the middleware failed.
    """
    rcl, rcutils = _libraries()
    found, info = _Bytes(allocator=rcutils.rcutils_get_default_allocator()), _MessageInfo()
    status = rcl.rcl_take_serialized_message(
        handle.pointer, ctypes.byref(found), ctypes.byref(info), None)
    try:
        if status == _NOTHING:
            return None
        if status != _OK:
            raise RuntimeError(f'rcl_take_serialized_message failed with {status}')
        return Received(_copied(found), bytes(info.publisher_gid),
                        info.publication_sequence_number)
    finally:
        if status != _OK:
            rcutils.rcutils_reset_error()
        rcutils.rcutils_uint8_array_fini(ctypes.byref(found))


def _copied(found: _Bytes) -> bytes | memoryview:
    if found.length < _COPIED_ASIDE:
        return ctypes.string_at(found.buffer, found.length)
    place = ctypes.cast(found.buffer, ctypes.POINTER(ctypes.c_uint8))
    return np.ctypeslib.as_array(place, (found.length,)).copy().data
