# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A node whose frequent topics wake no executor: they are read on demand."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
import traceback
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from rclpy.time_source import CLOCK_TOPIC

from armsim_ros.nodes.guarded_node import GuardedNode


class OutsideExecutors(CallbackGroup):
    """The group of entities that no executor waits for."""

    def can_execute(self, entity: Any) -> bool:
        """Return that an executor must leave it alone."""
        return False

    def beginning_execution(self, entity: Any) -> bool:
        """Return that an executor must leave it alone."""
        return False

    def ending_execution(self, entity: Any) -> None:
        """Do nothing: nothing began."""


class PollingNode(GuardedNode):
    """
    A node that reads its frequent topics, ``/clock`` among them, when ``catch_up`` is called.

    rclpy's executors make a wait set of all their entities for every message, which with a
    hundred services costs close to a millisecond. Unread messages stay with the
    middleware, which keeps the newest; a caller of ``catch_up`` before each callback has in each
    of them the state, and the time, of that moment.

    :param name: of the node.
    :param clock_when_asked: follow ``/clock`` only from ``follow_clock`` on.
    :param options: those of ``rclpy.node.Node``.
    """

    def __init__(self, name: str, *, clock_when_asked: bool = False, **options: Any) -> None:
        self._polled: tuple[Subscription, ...] = ()
        self._clock_when_asked = clock_when_asked
        self._subscribe_to_clock: Callable[[], Subscription] | None = None
        self._outside = OutsideExecutors()
        super().__init__(name, **options)

    def poll(
        self,
        kind: Any,
        topic: str,
        receive: Callable[[Any], None],
        profile: QoSProfile | int,
        *,
        raw: bool = False,
    ) -> Subscription:
        """
        Subscribe to a topic that comes often.

        :param receive: called by ``catch_up`` with each message.
        :param profile: its depth is the number of messages that wait at most.
        :param raw: hand over serialized messages.
        """
        subscription = super().create_subscription(
            kind, topic, receive, profile, callback_group=self._outside, raw=raw
        )
        self._polled = (*self._polled, subscription)
        return subscription

    # None is returned for /clock alone, to the node's own time source.
    def create_subscription(  # type: ignore[override] # see above
        self, msg_type: Any, topic: str, callback: Any, qos_profile: Any, **options: Any
    ) -> Subscription | None:
        """Subscribe; to ``/clock``, as the time source does, without waking the executor."""
        if topic == CLOCK_TOPIC:
            self._subscribe_to_clock = partial(
                self.poll, msg_type, topic, callback, qos_profile)
            return None if self._clock_when_asked else self._subscribe_to_clock()
        return super().create_subscription(msg_type, topic, callback, qos_profile, **options)

    def follow_clock(self) -> None:
        """Subscribe to ``/clock`` where that was left for later and time is simulated."""
        if self._clock_when_asked and self._subscribe_to_clock is not None:
            self._clock_when_asked = False
            self._subscribe_to_clock()

    def waiter(self, *subscriptions: Subscription) -> Callable[[float], bool]:
        """
        Return what waits for messages that ``catch_up`` will find.

        It takes the longest time to wait [s], and returns whether there is a message; only from
        the same thread.
        """
        context = self.context.handle
        assert context is not None  # the node was made in it
        with context:
            wait_set = _rclpy.WaitSet(len(subscriptions), 0, 0, 0, 0, 0, context)

        def wait(longest: float) -> bool:
            with ExitStack() as alive:
                wait_set.clear_entities()
                for subscription in subscriptions:
                    alive.enter_context(subscription.handle)
                    wait_set.add_subscription(subscription.handle)
                wait_set.wait(max(0, round(longest * 1e9)))
                return bool(wait_set.get_ready_entities('subscription'))

        return wait

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """Take a subscription away, of either sort."""
        self._polled = tuple(each for each in self._polled if each is not subscription)
        return bool(super().destroy_subscription(subscription))

    @property
    def polled(self) -> tuple[Subscription, ...]:
        """What ``catch_up`` reads."""
        return self._polled

    def catch_up(self, *subscriptions: Subscription) -> None:
        """
        Hand over all messages that have come in; always from the same thread.

        :param subscriptions: those to read; none means all.
        """
        for subscription in subscriptions or self._polled:
            try:
                with subscription.handle:
                    self._take(subscription)
            except InvalidHandle:
                continue  # destroyed by one of the callbacks

    def _take(self, subscription: Subscription) -> None:
        handle, kind, raw = subscription.handle, subscription.msg_type, subscription.raw
        # A publisher that is quicker than we are must not keep us here.
        for _ in range(max(subscription.qos_profile.depth, 1)):
            try:
                taken = handle.take_message(kind, raw)
                if taken is None:
                    return
                subscription.callback(taken[0])
            except Exception:  # noqa: BLE001 - no message may end the program
                self.get_logger().error(
                    f"a message on '{subscription.topic}' failed inside the program; please "
                    f'report this:\n{traceback.format_exc()}'
                )
