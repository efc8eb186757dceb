# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim echo``: print the messages of a topic."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
import json
import queue
from typing import Any

from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
import yaml

from armsim_ros.errors import ArmsimError, nearest
from armsim_ros.nodes.client.ros_client import RosClient
from armsim_ros.nodes.verbs.terminal import parser, plain_message, read, until


def main(argv: Sequence[str] | None = None) -> int:
    """
    Print messages until the count is reached or Ctrl-C.

    :returns: 0.
    :raises ArmsimError: nobody publishes the topic, or its type is not installed.
    """
    words = parser('echo', 'print the messages of a topic, as YAML or one JSON object a line')
    words.add_argument('topic')
    words.add_argument('-n', '--count', type=int, default=0, metavar='COUNT',
                       help='end after so many messages')
    words.add_argument('--once', action='store_const', const=1, dest='count',
                       help='end after one message')
    asked, ros = read(words, argv)
    topic = asked.topic if asked.topic.startswith('/') else f'/{asked.topic}'
    with RosClient('armsim_echo', ros) as client:
        kind, profile = find_topic(client, topic, asked.timeout)
        messages: queue.Queue[Any] = queue.Queue(1000)

        def receive(message: Any) -> None:
            if not messages.full():
                messages.put(message)

        client.subscribe(kind, topic, profile, receive)
        seen = 0
        while not asked.count or seen < asked.count:
            try:
                message = messages.get(timeout=0.2)
            except queue.Empty:
                continue
            seen += 1
            value = plain_message(message)
            if asked.json:
                print(json.dumps(value), flush=True)
            else:
                print(yaml.safe_dump(value, sort_keys=False, default_flow_style=None) + '---',
                      flush=True)
    return 0


def find_topic(client: RosClient, topic: str, patience: float) -> tuple[type, QoSProfile]:
    """
    Return a topic's type and a profile that hears what its publishers offer.

    :raises ArmsimError: nobody publishes it in time, or its type is not installed.
    """
    try:
        publishers = until(lambda: client.node.get_publishers_info_by_topic(topic) or None,
                           patience, f'topic {topic}')
    except ArmsimError as error:
        known = [name for name, _ in client.node.get_topic_names_and_types()]
        hint = nearest(topic, known)
        raise ArmsimError(f'{error} {hint}' if hint else str(error)) from None
    return message_type(publishers[0].topic_type), offered_profile(publishers)


def message_type(name: str) -> type:
    """
    Return the class of a message type such as ``std_msgs/msg/String``.

    :raises ArmsimError: its package is not installed.
    """
    package, _, kind = name.partition('/msg/')
    try:
        return getattr(import_module(f'{package}.msg'), kind)  # type: ignore[no-any-return]
    except (ImportError, AttributeError):
        raise ArmsimError(f"the message type '{name}' is not installed here") from None


def offered_profile(publishers: Sequence[Any]) -> QoSProfile:
    """Return the profile of a subscription that every one of the publishers matches."""
    reliable = all(one.qos_profile.reliability == QoSReliabilityPolicy.RELIABLE
                   for one in publishers)
    latched = all(one.qos_profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL
                  for one in publishers)
    return QoSProfile(
        depth=100,
        reliability=(QoSReliabilityPolicy.RELIABLE if reliable
                     else QoSReliabilityPolicy.BEST_EFFORT),
        durability=(QoSDurabilityPolicy.TRANSIENT_LOCAL if latched
                    else QoSDurabilityPolicy.VOLATILE))
