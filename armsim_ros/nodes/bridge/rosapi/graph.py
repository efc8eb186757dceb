# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What rosapi knows of the graph: topics, services, nodes and actions."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from rclpy.exceptions import InvalidHandle
from rclpy.node import NodeNameNonExistentError

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.bridge.interfaces import full_name
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

    def topics_of(self, type_name: str) -> list[str]:
        """Return the topics of a type in two or three parts."""
        requested = full_name(type_name, 'msg')
        return [name for name, found in self.topics().items() if found == requested]

    def services_of(self, type_name: str) -> list[str]:
        """Return the services of a type in two or three parts."""
        requested = full_name(type_name, 'srv')
        return [name for name, found in self.services().items() if found == requested]

    def topic_type(self, topic: str) -> str:
        """Return a topic's type, '' where it is not there."""
        return self._first(self._link.topic_types(), topic)

    def service_type(self, service: str) -> str:
        """Return a service's type, '' where it is not there."""
        return self._first(self._link.service_types(), service)

    def action_type(self, action: str) -> str:
        """Return an action's type, '' where it is not there."""
        found = self._first(self._link.service_types(), f'{action}/_action/send_goal')
        return found.removesuffix('_SendGoal')

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

    def publishers(self, topic: str) -> list[str]:
        """Return the nodes that publish a topic."""
        return self._ends(self._node.get_publishers_info_by_topic, topic)

    def subscribers(self, topic: str) -> list[str]:
        """Return the nodes that subscribe to a topic."""
        return self._ends(self._node.get_subscriptions_info_by_topic, topic)

    def providers(self, service: str) -> list[str]:
        """Return the nodes that serve a service."""
        full = self._expanded(service)
        return [node for node in self.nodes() if full in self.node_details(node)[2]]

    def providers_of(self, type_name: str) -> list[str]:
        """Return the nodes that serve a service type."""
        names = set(self.services_of(type_name))
        return [node for node in self.nodes() if names & set(self.node_details(node)[2])]

    def _ends(self, info: Any, topic: str) -> list[str]:
        try:
            found = info(self._link.expand(topic))
        except (ArmsimError, InvalidHandle):
            return []
        return sorted({f'{end.node_namespace.rstrip("/")}/{end.node_name}' for end in found})

    def _first(self, known: dict[str, list[str]], name: str) -> str:
        types = known.get(self._expanded(name))
        return types[0] if types else ''

    def _expanded(self, name: str) -> str:
        try:
            return self._link.expand(name)
        except ArmsimError:
            return ''
