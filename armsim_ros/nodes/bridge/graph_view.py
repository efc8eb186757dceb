# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The part of the graph that clients see."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress

from armsim_ros.nodes.bridge.interfaces import RefusalError
from armsim_ros.nodes.bridge.link import BridgeLink, Types
from armsim_ros.nodes.bridge.permissions import Permissions


class GraphView:
    """
    Names that are not hidden and match the patterns of the arguments.

    Actions are not hidden, though the names of their topics and services are.

    :param include_hidden: hidden names, too.
    """

    def __init__(self, link: BridgeLink, permissions: Permissions, *,
                 include_hidden: bool = False) -> None:
        self._link, self._permissions = link, permissions
        self._include_hidden = include_hidden

    def topics(self) -> dict[str, str]:
        """Return the topics with a type each."""
        return {name: types[0] for name, types in self._link.topic_types().items()
                if self._shows('topic', name)}

    def services(self) -> dict[str, str]:
        """Return the services that are served, with a type each."""
        return {name: kind for name, kind in self._link.served_services().items()
                if self._shows('service', name)}

    def actions(self) -> dict[str, str]:
        """Return the actions that are served, with a type each."""
        return {name: kind for name, kind in self._link.actions().items()
                if self._shows('action', name)}

    def topic_type(self, name: str) -> str:
        """Return the type of a topic, '' where it is not there."""
        return self._type_of('topic', name, self._link.topic_types())

    def service_type(self, name: str) -> str:
        """Return the type of a service, '' where it is not there."""
        return self._type_of('service', name, self._link.service_types())

    def action_type(self, name: str) -> str:
        """Return the type of an action, '' where it is not served."""
        return self._type_of('action', name, {
            action: [kind] for action, kind in self._link.actions().items()})

    def nodes(self) -> list[str]:
        """Return the full names of the nodes."""
        return [node for node in self._link.nodes() if self._is_visible(node)]

    def node_details(self, node: str) -> list[list[str]]:
        """Return what a node subscribes to, what it publishes, and what it serves."""
        if not self._is_visible(node):
            return [[], [], []]
        return [[name for name in names if self._shows(kind, name)]
                for kind, names in zip(('topic', 'topic', 'service'),
                                       self._link.node_details(node), strict=True)]

    def providers(self, services: Iterable[str]) -> list[str]:
        """Return the nodes that serve one of these services."""
        full = self._shown('service', services)
        return [node for node in self._link.providers(full) if self._is_visible(node)]

    def ends(self, topic: str, *, publish: bool) -> list[str]:
        """Return the nodes that publish a topic, or subscribe to it."""
        return [node for name in self._shown('topic', [topic])
                for node in self._link.ends(name, publish=publish) if self._is_visible(node)]

    def _shows(self, kind: str, name: str) -> bool:
        return self._permissions.matches(kind, name) and (
            kind == 'action' or self._is_visible(name))

    def _is_visible(self, name: str) -> bool:
        return self._include_hidden or not is_hidden(name)

    def _shown(self, kind: str, names: Iterable[str]) -> list[str]:
        """Return the full names of those that clients see."""
        found = []
        for name in names:
            with suppress(RefusalError):
                found.append(self._link.expand(name))
        return [name for name in found if self._shows(kind, name)]

    def _type_of(self, kind: str, name: str, known: Types) -> str:
        return next((known[full][0] for full in self._shown(kind, [name]) if full in known), '')


def is_hidden(name: str) -> bool:
    """Return whether a part of a name begins with an underscore."""
    return any(part.startswith('_') for part in name.split('/'))
