# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What rosapi knows of the graph: topics, services, nodes and actions."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress

from rclpy.exceptions import InvalidHandle
from rclpy.node import NodeNameNonExistentError

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.bridge.link import BridgeLink

_ACTION = '/_action/'


class Graph:
    """Questions about the graph; what is not there has an empty answer."""

    def __init__(self, link: BridgeLink) -> None:
        self._link = link
        self._node = link.node

    def topics(self) -> dict[str, str]:
        """Return the topics with a type each; those of actions are hidden."""
        return {name: types[0] for name, types in self._link.topic_types().items()
                if _ACTION not in name}

    def services(self) -> dict[str, str]:
        """Return the services with a type each; those of actions are hidden."""
        return {name: types[0] for name, types in self._link.service_types().items()
                if _ACTION not in name and self._node.count_services(name)}

    def type_of(self, name: str, known: dict[str, list[str]]) -> str:
        """Return the type of what is known by a name, '' where it is not there."""
        with suppress(ArmsimError, KeyError):
            return known[self._link.expand(name)][0]
        return ''

    def nodes(self) -> list[str]:
        """Return the full names of all nodes."""
        found = self._node.get_node_names_and_namespaces()
        return sorted({f'{namespace.rstrip("/")}/{name}' for name, namespace in found})

    def node_details(self, node: str) -> tuple[list[str], list[str], list[str]]:
        """Return what a node subscribes to, publishes and serves."""
        namespace, _, name = node.rpartition('/')
        found: list[list[str]] = []
        for ask in (self._node.get_subscriber_names_and_types_by_node,
                    self._node.get_publisher_names_and_types_by_node,
                    self._node.get_service_names_and_types_by_node):
            names: list[str] = []
            with suppress(NodeNameNonExistentError, ValueError, RuntimeError):
                names = [entry[0] for entry in ask(name, namespace or '/')]
            found.append(names)
        return found[0], found[1], found[2]

    def providers(self, services: Iterable[str]) -> list[str]:
        """Return the nodes that serve one of these services."""
        full = set()
        for name in services:
            with suppress(ArmsimError):
                full.add(self._link.expand(name))
        return [node for node in self.nodes() if full & set(self.node_details(node)[2])]

    def ends(self, topic: str, *, publish: bool) -> list[str]:
        """Return the nodes that publish a topic, or subscribe to it."""
        info = (self._node.get_publishers_info_by_topic if publish
                else self._node.get_subscriptions_info_by_topic)
        try:
            found = info(self._link.expand(topic))
        except (ArmsimError, InvalidHandle):
            return []
        return sorted({f'{end.node_namespace.rstrip("/")}/{end.node_name}' for end in found})
