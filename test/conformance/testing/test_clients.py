# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The clients for tests."""

from arm_user import until

from armsim_ros.clients.client_node import ClientNode


def test_a_closed_client_leaves_its_domain(ros_domain_id):
    """Others see it go, although the test still refers to it."""
    with ClientNode(ros_domain_id, 'watcher') as watcher:
        names = watcher.node.get_node_names
        with ClientNode(ros_domain_id, 'leaving') as leaving:
            until(lambda: 'leaving' in names(), 'the client is there')
        until(lambda: 'leaving' not in names(), 'the client is gone')
        del leaving
