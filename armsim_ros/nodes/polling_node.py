# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Nodes whose callbacks cannot end a program, and that read frequent topics on demand.

What rclpy would keep for ever of entities and goals is let go.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
import inspect
import sys
import traceback
from typing import Any, TYPE_CHECKING
import weakref

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.callback_groups import CallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.task import Future
from rclpy.time_source import CLOCK_TOPIC
from type_description_interfaces.srv import GetTypeDescription

from armsim_ros.nodes import qos

if TYPE_CHECKING:  # half of what a program without actions would import
    from rclpy.action import ActionServer
    from rclpy.action.server import ServerGoalHandle

#: Packages of the services that rclpy serves itself.
_RCLPYS = ('rcl_interfaces', 'type_description_interfaces')

Answer = Callable[[Any, Any], Any]


class LiveReferences(set[Any]):
    """The entities of a callback group, which rclpy would refer to for ever."""

    def add(self, reference: Any) -> None:
        """Keep a weak reference until its entity is gone."""
        super().add(weakref.ref(reference(), self.discard))


def keep_live(group: CallbackGroup) -> CallbackGroup:
    """Let a group whose entities come and go forget those that have gone; return it."""
    if type(group.entities) is set:
        group.entities = LiveReferences(group.entities)
    return group


class KeptResults:
    """
    The results of an action server: of the goals that ended last, and of no others.

    A client that requests a result that is no longer kept is answered that the goal is not known.

    :param server: whose ``result_timeout`` is in the node's time, as fast as that may run.
    :param most: how many are kept.
    """

    def __init__(self, server: ActionServer, most: int) -> None:
        self._server, self._most = server, most
        self._ended: deque[ServerGoalHandle] = deque()

    def add(self, goal: ServerGoalHandle) -> None:
        """Keep the result of a goal that ends now; of those before, the requests no longer."""
        if self._ended:
            self._ended[-1]._goal_request = None
        self._ended.append(goal)
        while len(self._ended) > self._most:
            self._forget(self._ended.popleft())

    def _forget(self, goal: ServerGoalHandle) -> None:
        """Let go of the messages of a goal whose result was sent long ago; rclpy never does."""
        server, key = self._server, bytes(goal.goal_id.uuid)
        if key not in server._result_futures:
            return  # its time was up
        forgotten = Future()
        # A response without values has the status of an unknown goal.
        forgotten.set_result(server._action_type.Impl.GetResultService.Response())
        server.remove_future(server._result_futures[key])
        server._result_futures[key] = forgotten
        server.add_future(forgotten)


def destroy_actions(node: Node) -> None:
    """
    Destroy a node's clients and servers of actions, in the thread of its executor.

    ``Node.destroy_node`` leaves them; their handles keep the participant in the domain until they
    are garbage.
    """
    if actions := sys.modules.get('rclpy.action'):
        for waitable in list(node.waitables):
            if isinstance(waitable, (actions.ActionServer, actions.ActionClient)):
                waitable.destroy()


class GuardedNode(Node):
    """
    A node that answers a request even where the code that should has failed.

    rclpy's own services of parameters and types raise at some requests that others may well
    make, such as a parameter of an unknown type; their clients would wait for ever. They get a
    response in which nothing was done, and where it has room for that, why.

    :param options: those of ``rclpy.node.Node``.
    """

    def __init__(self, name: str, **options: Any) -> None:
        super().__init__(name, **options)
        keep_live(self.default_callback_group)
        for service in self.services:
            if service.srv_type is GetTypeDescription:  # made past create_service
                service.callback = self._guarded(service.srv_type, service.callback)

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Answer, **options: Any
    ) -> Service:
        """Serve, a burst of requests too; a callback that fails is logged and answered for."""
        options.setdefault('qos_profile', qos.SERVICES)
        return super().create_service(
            srv_type, srv_name, self._guarded(srv_type, callback), **options)

    def destroy_node(self) -> None:
        """Take all endpoints down; those of actions, too, which rclpy leaves to their makers."""
        destroy_actions(self)
        super().destroy_node()  # type: ignore[no-untyped-call] # rclpy's

    def _guarded(self, kind: Any, callback: Answer) -> Answer:
        if inspect.iscoroutinefunction(callback):

            async def later(request: Any, response: Any) -> Any:
                try:
                    return await callback(request, response)
                except Exception as error:  # noqa: BLE001 - the client waits
                    return self._failed(kind, request, error)

            return later

        def now(request: Any, response: Any) -> Any:
            try:
                return callback(request, response)
            except Exception as error:  # noqa: BLE001 - the client waits
                return self._failed(kind, request, error)

        return now

    def _failed(self, kind: Any, request: Any, error: Exception) -> Any:
        """Return an answer that reports that nothing was done, and log why."""
        text = f'{type(error).__name__}: {error}'
        if kind.__module__.startswith(_RCLPYS):
            self.get_logger().warning(f'a request of type {kind.__name__} was not served: {text}')
        else:
            self.get_logger().error(
                f'a request of type {kind.__name__} failed inside the program; please report '
                f'this:\n{traceback.format_exc()}')
        refused = SetParametersResult(successful=False, reason=text)
        if kind is SetParameters:
            return kind.Response(results=[refused] * len(request.parameters))
        if kind is SetParametersAtomically:
            return kind.Response(result=refused)
        return kind.Response()


class OutsideExecutors(CallbackGroup):
    """The group of entities that no executor waits for."""

    def __init__(self) -> None:
        super().__init__()
        keep_live(self)

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

    Executors fill a wait set with all their entities for every message, which with a hundred
    services costs more than to read it. Unread messages stay with the
    middleware, which keeps the newest; a caller of ``catch_up`` before each callback has in each
    of them the state, and the time, of that moment.

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
        self, kind: Any, topic: str, receive: Callable[[Any], None], profile: QoSProfile | int, *,
        raw: bool = False
    ) -> Subscription:
        """
        Subscribe to a topic that comes often.

        :param receive: called by ``catch_up`` with each message.
        :param profile: its depth is the number of messages that wait at most.
        :param raw: hand over serialized messages.
        """
        subscription = super().create_subscription(
            kind, topic, receive, profile, callback_group=self._outside, raw=raw)
        self._polled = (*self._polled, subscription)
        return subscription

    # None is returned for /clock alone, to the node's own time source.
    def create_subscription(  # type: ignore[override] # see above
        self, msg_type: Any, topic: str, callback: Any, qos_profile: Any, **options: Any
    ) -> Subscription | None:
        """Subscribe; to ``/clock``, as the time source does, without waking the executor."""
        if topic == CLOCK_TOPIC:
            self._subscribe_to_clock = partial(self.poll, msg_type, topic, callback, qos_profile)
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
        Hand over all messages that have come in; of a subscription, in one thread at a time.

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
                    f'report this:\n{traceback.format_exc()}')
