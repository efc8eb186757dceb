# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A load: ``python -m benchmarks.listener`` subscribes to every topic of the domain.

Prints one line when it listens, and how many messages it has received when it is terminated.
"""

from __future__ import annotations

from importlib import import_module
import time

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile

#: The graph counts as known when nothing new has come for so long [s].
QUIET_TIME = 1.0
SETTLED = 'listening to'
RECEIVED = 'received'


class Listener(Node):
    """A node that takes whatever is published and counts it."""

    def __init__(self) -> None:
        super().__init__(f'listener_{time.monotonic_ns()}')
        self.received = 0
        topics = self._all_topics()
        for topic, kinds in topics.items():
            latched = topic.endswith('tf_static') or 'description' in topic
            durability = (
                QoSDurabilityPolicy.TRANSIENT_LOCAL if latched else QoSDurabilityPolicy.VOLATILE)
            self.create_subscription(
                message_type(kinds[0]), topic, self._receive,
                QoSProfile(depth=10, durability=durability),
            )
        print(f'{SETTLED} {len(topics)} topics', flush=True)

    def _all_topics(self) -> dict[str, list[str]]:
        known: dict[str, list[str]] = {}
        changed = time.monotonic()
        while not known or time.monotonic() - changed < QUIET_TIME:
            time.sleep(0.1)
            now = {
                topic: kinds for topic, kinds in self.get_topic_names_and_types()
                if '/msg/' in kinds[0]}
            if now.keys() != known.keys():
                known, changed = now, time.monotonic()
        return known

    def _receive(self, _message: object) -> None:
        self.received += 1


def message_type(name: str) -> type:
    """Return the class of a message type such as ``sensor_msgs/msg/JointState``."""
    package, _, kind = name.split('/')
    found: type = getattr(import_module(f'{package}.msg'), kind)
    return found


def listen() -> None:
    """Listen until a signal comes."""
    rclpy.init()
    node = Listener()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        executor.spin()
    except ExternalShutdownException:
        print(f'{RECEIVED} {node.received}', flush=True)


if __name__ == '__main__':
    listen()
