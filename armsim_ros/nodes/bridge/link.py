# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The bridge's node, and what it knows of the graph: topics, services, actions and nodes."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future
from contextlib import suppress
from functools import lru_cache
from typing import Any, TypeVar

from rclpy.exceptions import InvalidHandle, InvalidServiceNameException, InvalidTopicNameException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.node import NodeNameNonExistentError
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.task import Future as RosFuture
from rclpy.validate_full_topic_name import validate_full_topic_name

from armsim_ros.clients.ros_client import RosClient
from armsim_ros.errors import nearest
from armsim_ros.nodes.bridge.interfaces import load, RefusalError
from armsim_ros.nodes.polling_node import PollingNode

#: How long an endpoint that is not in the graph yet is waited for, and how often [s].
DISCOVERY, _PAUSE = 1.0, 0.02
_DEPTH = 100
#: Names that are remembered with their full names.
_MOST_NAMES = 1000
_SEND_GOAL = '/_action/send_goal'

T = TypeVar('T')
Types = dict[str, list[str]]


class BridgeLink(RosClient):
    """
    The node in its thread, seen from the thread of the sockets.

    :param name: of the node where nothing renames it.
    :param ros_args: ``--ros-args`` sections.
    :param loop: of the sockets.
    """

    def __init__(self, name: str, ros_args: Sequence[str], loop: asyncio.AbstractEventLoop
                 ) -> None:
        super().__init__(name, ros_args, kind=PollingNode, start_parameter_services=True)
        self.loop = loop
        #: Has the subscriptions to topics of large messages.
        self.large = RosClient(f'_{name}_large', ros_args, domain=self.context.get_domain_id(),
                               use_global_arguments=False)
        # Asked for each message that is published.
        self._expanded = lru_cache(maxsize=_MOST_NAMES)(self._expand)
        self._answers: dict[Callable[[], Types], Types] = {}
        self._explaining = asyncio.Lock()

    def close(self) -> None:
        """Leave the graph."""
        self.large.close()
        super().close()

    async def run(self, work: Callable[[], T]) -> T:
        """Do something in the node's thread."""
        found: T = await asyncio.wrap_future(self.in_thread(work))
        return found

    def schedule(self, work: Callable[[], None]) -> None:
        """Do something in the thread of the sockets; from any thread."""
        if not self.loop.is_closed():
            self.loop.call_soon_threadsafe(work)

    def settle(self, waiting: RosFuture, value: Any) -> None:
        """Let a callback in the node's thread go on with a value."""
        self.in_thread(lambda: waiting.done() or waiting.set_result(value))

    def now(self) -> tuple[int, int]:
        """Return seconds and nanoseconds of the ROS clock."""
        if isinstance(self.node, PollingNode) and self.node.polled:
            self.node.catch_up(*self.node.polled)
        return self.node.get_clock().now().seconds_nanoseconds()

    def expand(self, name: str, *, service: bool = False) -> str:
        """
        Return the full name of a topic, service or action.

        :raises RefusalError: it is not a name.
        """
        return self._expanded(name, service)

    def _expand(self, name: str, service: bool) -> str:
        try:
            full: str = expand_topic_name(name, self.node.get_name(), self.node.get_namespace())
            validate_full_topic_name(full, is_service=service)
        except (InvalidTopicNameException, InvalidServiceNameException, ValueError) as error:
            reason = str(error).splitlines()[0]
            raise RefusalError(f"'{name[:200]}' is not a name of ROS: {reason}") from None
        return full

    def topic_types(self) -> Types:
        """Return all topics, hidden ones too, with their types."""
        return dict(self.node.get_topic_names_and_types())

    def service_types(self) -> Types:
        """Return all services with their types."""
        return dict(self.node.get_service_names_and_types())

    async def topic_type(self, name: str) -> str:
        """
        Return the type of a topic, which may be about to appear.

        :raises RefusalError: it is not there; names the nearest.
        """
        types = await self._discover(lambda: self._recent(self.topic_types).get(name),
                                     'no such topic', name, self.topic_types)
        return types[0]

    async def service_type(self, name: str) -> str:
        """
        Return the type of a service, which may be about to appear.

        :raises RefusalError: it is not served; names the nearest.
        """
        types = await self._discover(lambda: self._served(name), 'no such service', name,
                                     self.served_services)
        return types[0]

    async def _discover(self, find: Callable[[], T | None], what: str, name: str,
                        known: Callable[[], Iterable[str]]) -> T:
        """Return what is found within a moment; otherwise the refusal names the nearest."""
        for _ in range(round(DISCOVERY / _PAUSE)):
            found = find()
            if found:
                return found
            await asyncio.sleep(_PAUSE)
        async with self._explaining:  # takes a while: once in a pass of the event loop
            await asyncio.sleep(0)
            hint = nearest(name, tuple(known()))
        raise RefusalError(f'{what}{"; " + hint if hint else ""}')

    def _recent(self, ask: Callable[[], Types]) -> Types:
        """Return an answer of the graph, which all share who ask in the same moment."""
        if ask not in self._answers:
            self._answers[ask] = ask()
            self.loop.call_later(_PAUSE / 2, self._answers.pop, ask)
        return self._answers[ask]

    def _served(self, name: str) -> list[str] | None:
        """Return the types of a service, None where it has no server."""
        types = self._recent(self.service_types).get(name)
        return types if types and self.node.count_services(name) else None

    async def load(self, name: str, group: str) -> type[Any]:
        """
        Return the class of a type; its first import blocks no other client.

        :raises RefusalError: there is no such type.
        """
        return await asyncio.to_thread(load, name, group)

    async def call_when_ready(self, kind: type[Any], name: str, request: Any) -> Any:
        """
        Call a service and return its response.

        :raises RefusalError: it is not there, or leaves while it is waited for.
        """
        await self._wait_for(kind, name, action=False)
        answer: Future[Any] = self.call(kind, name, request)
        waiting = asyncio.wrap_future(answer)
        try:
            while True:
                done, _ = await asyncio.wait([waiting], timeout=DISCOVERY)
                if done:
                    return waiting.result()
                if not self.serves(kind, name):
                    raise RefusalError('the server has gone without an answer')
        finally:
            waiting.cancel()

    async def wait_for_action(self, kind: type[Any], name: str) -> None:
        """
        Wait for an action server.

        :raises RefusalError: there is none.
        """
        await self._discover(lambda: self._served(f'{name}{_SEND_GOAL}'),
                             'no such action is served', name, self.actions)
        await self._wait_for(kind, name, action=True)

    async def _wait_for(self, kind: type[Any], name: str, *, action: bool) -> None:
        if not self.serves(kind, name, action=action):
            self.prepare(kind, name, action=action)
            await self._discover(
                lambda: self.serves(kind, name, action=action),
                f'no {"action" if action else "service"} of this type is served', '', tuple)

    def served_services(self) -> dict[str, str]:
        """Return the services that have a server, not only clients, with a type each."""
        return {name: types[0] for name, types in self.service_types().items()
                if self.node.count_services(name)}

    def actions(self) -> dict[str, str]:
        """Return all actions that are served, with a type each."""
        return {name.removesuffix(_SEND_GOAL): kind.removesuffix('_SendGoal')
                for name, kind in self.served_services().items() if name.endswith(_SEND_GOAL)}

    def nodes(self) -> list[str]:
        """Return the full names of all nodes."""
        found = self.node.get_node_names_and_namespaces()
        return sorted({f'{namespace.rstrip("/")}/{name}' for name, namespace in found})

    def node_details(self, node: str) -> list[list[str]]:
        """Return what a node subscribes to, what it publishes, and what it serves."""
        namespace, _, name = node.rpartition('/')
        found: list[list[str]] = []
        for ask in (self.node.get_subscriber_names_and_types_by_node,
                    self.node.get_publisher_names_and_types_by_node,
                    self.node.get_service_names_and_types_by_node):
            found.append([])
            with suppress(NodeNameNonExistentError, ValueError, RuntimeError):
                found[-1] = [entry[0] for entry in ask(name, namespace or '/')]
        return found

    def providers(self, services: Iterable[str]) -> list[str]:
        """Return the nodes that serve one of these services."""
        full = set()
        for name in services:
            with suppress(RefusalError):
                full.add(self.expand(name))
        return [node for node in self.nodes() if full & set(self.node_details(node)[2])]

    def ends(self, topic: str, *, publish: bool) -> list[str]:
        """Return the nodes that publish a topic, or subscribe to it."""
        info = (self.node.get_publishers_info_by_topic if publish
                else self.node.get_subscriptions_info_by_topic)
        try:
            found = info(self.expand(topic))
        except (RefusalError, InvalidHandle):
            return []
        return sorted({f'{end.node_namespace.rstrip("/")}/{end.node_name}' for end in found})

    def publishers(self, topic: str) -> set[bytes]:
        """Return the GIDs of a topic's publishers."""
        return {bytes(info.endpoint_gid)
                for info in self.node.get_publishers_info_by_topic(topic)}

    def matching_profile(self, topic: str) -> QoSProfile:
        """Return what a subscription may ask for so that every publisher of a topic matches."""
        offered = [info.qos_profile for info in self.node.get_publishers_info_by_topic(topic)]
        reliable = bool(offered) and all(
            profile.reliability == QoSReliabilityPolicy.RELIABLE for profile in offered)
        latched = bool(offered) and all(
            profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL for profile in offered)
        return QoSProfile(
            depth=_DEPTH, history=QoSHistoryPolicy.KEEP_LAST,
            reliability=(QoSReliabilityPolicy.RELIABLE if reliable
                         else QoSReliabilityPolicy.BEST_EFFORT),
            durability=(QoSDurabilityPolicy.TRANSIENT_LOCAL if latched
                        else QoSDurabilityPolicy.VOLATILE))
