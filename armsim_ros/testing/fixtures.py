# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Fixtures for pytest; a conftest.py imports those that its folder needs."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.testing.program import private_domain


@pytest.fixture(scope='module')
def ros_domain() -> Iterator[int]:
    """Lease a ROS domain for a module of tests."""
    with private_domain() as domain:
        yield domain


@pytest.fixture(scope='module')
def client(ros_domain: int) -> Iterator[ClientNode]:
    """Give a node on the module's domain."""
    with ClientNode(ros_domain) as node:
        yield node
