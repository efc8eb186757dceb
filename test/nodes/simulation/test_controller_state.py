# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``~/controller_state``."""

from __future__ import annotations

from armsim_ros.nodes.simulation.controllers.state_topics import ControllerStatePublisher
from armsim_ros.stack import ArmSim


class Node:
    """Stands for a node with one subscriber, and for its publisher."""

    def __init__(self) -> None:
        self.published = 0

    def create_publisher(self, _kind: object, _topic: str, _profile: object) -> Node:
        return self

    def get_subscription_count(self) -> int:
        return 1

    def publish(self, _message: object) -> None:
        self.published += 1


def test_the_state_of_an_update_is_published_once() -> None:
    """While no update is made there is nothing to publish, whatever the time."""
    sim, node = ArmSim('sunday'), Node()
    publisher = ControllerStatePublisher(node, sim.manager.controllers['arm_joint_controller'])
    for second, updates in ((1, 20), (2, 0), (3, 0), (4, 20)):
        sim.step(updates)
        publisher.publish_if_due(second * 1_000_000_000)
    assert node.published == 2
