# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A client of the real programs, on the private domain that the plugin leases."""

import pytest

from armsim_ros.clients.client_node import ClientNode


@pytest.fixture(scope='module')
def client(ros_domain):
    """Give a node on the module's domain."""
    with ClientNode(ros_domain) as node:
        yield node
