# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A node of a client in the graph, and out of it."""

import time

from control_msgs.action import FollowJointTrajectory

from armsim_ros.clients.node import SpinningNode
from armsim_ros.testing.program import private_domain


def test_a_closed_node_with_an_action_is_gone_though_the_action_is_still_held():
    """Otherwise its participant stayed in the domain until the action is garbage."""
    with private_domain() as domain, SpinningNode('watcher', domain=domain) as watcher:
        client = SpinningNode('leaver', domain=domain)
        held = client.action(FollowJointTrajectory, 'follow')
        deadline = time.monotonic() + 20.0

        def is_there():
            assert time.monotonic() < deadline
            return 'leaver' in watcher.node.get_node_names()

        while not is_there():
            watcher.in_thread(lambda: None).result()
        client.close()
        while is_there():
            watcher.in_thread(lambda: None).result()
        del held
