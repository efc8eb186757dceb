# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One domain, the stacks that are started in it one after the other, and their client."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from stacks_to_kill import Arm, Stack, Stacks

from armsim_ros.cli.environment import FASTDDS_PROFILES
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.testing.program import private_domain


@pytest.fixture(scope='module')
def domain() -> Iterator[int]:
    """
    Lease a domain for all stacks of a module: each follows at once upon the last.

    They have the package's own settings of Fast DDS, with the lease that users have. This process
    keeps those of the tests: Fast DDS reads them once, when the first client is made.
    """
    with private_domain() as number, pytest.MonkeyPatch.context() as environment:
        with ClientNode(number, 'reads_settings'):
            environment.delenv(FASTDDS_PROFILES[0])
        yield number


@pytest.fixture(scope='module')
def arm(domain: int) -> Iterator[Arm]:
    """Give a client that stays while stacks come and go."""
    with ClientNode(domain, 'kill_matrix') as client:
        yield Arm(client)


@pytest.fixture(scope='module')
def stacks(domain: int, arm: Arm) -> Iterator[Stacks]:
    """Give the stacks of a module, one after the other."""
    made = Stacks(domain, arm)
    yield made
    made.close()


@pytest.fixture
def stack(stacks: Stacks) -> Stack:
    """Give the last stack if it still runs, else a new one."""
    return stacks.running()
