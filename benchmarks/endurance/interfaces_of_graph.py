# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the graph shows that takes messages, with the classes of its messages."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from rclpy.node import Node

#: Part of an action's name in the graph -> class within the action's own.
PARTS = {
    'SendGoal': 'Impl.SendGoalService', 'GetResult': 'Impl.GetResultService',
    'FeedbackMessage': 'Impl.FeedbackMessage', 'Goal': 'Goal', 'Result': 'Result',
    'Feedback': 'Feedback',
}


@dataclass(frozen=True)
class Endpoint:
    """
    Something of another node's that takes messages.

    :param node: full name of the node; of a topic, of the first that subscribes.
    :param is_service: whether it answers.
    :param name: full name of the service or topic; an action is three services.
    :param kind: class of the service or message.
    """

    node: str
    is_service: bool
    name: str
    kind: Any


def endpoints(node: Node, left_out: Container[str] = ()) -> list[Endpoint]:
    """
    Return the services and subscriptions of all nodes, sorted by name.

    :param node: that looks at the graph.
    :param left_out: names of nodes.
    """
    found: dict[tuple[bool, str], Endpoint] = {}
    for name, namespace in sorted(set(node.get_node_names_and_namespaces())):
        if name in left_out:
            continue
        served = node.get_service_names_and_types_by_node(name, namespace)
        heard = node.get_subscriber_names_and_types_by_node(name, namespace)
        full = f'{namespace.rstrip("/")}/{name}'
        for is_service, offers in ((True, served), (False, heard)):
            for endpoint, kinds in offers:
                found.setdefault(
                    (is_service, endpoint),
                    Endpoint(full, is_service, endpoint, interface(*kinds[0].split('/'))),
                )
    return [found[key] for key in sorted(found)]


def interface(package: str, section: str, name: str) -> Any:
    """Return the class of ``package/section/Name``, also of the parts of an action."""
    whole, _, part = name.partition('_')
    if part not in PARTS:
        return getattr(import_module(f'{package}.{section}'), name)
    made = getattr(import_module(f'{package}.action'), whole)
    for step in PARTS[part].split('.'):
        made = getattr(made, step)
    return made
