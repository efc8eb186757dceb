# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arm under test with an empty world, and servers that stand alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, ExitStack
from pathlib import Path
import sys
import threading
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from lone_server import LoneServer
from move_group_bench import ArmBench, CANCELED
from planners import set_planner
from wire import box, thing

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.testing.program import Program


def pytest_configure(config: pytest.Config) -> None:
    """Register the marks."""
    config.addinivalue_line('markers', 'statement(*names): the statements that a test checks')


@pytest.fixture(scope='module')
def running(server: Any, shared_in_folder: Callable[..., ArmBench]) -> ArmBench:
    """Give the arm of the server under test."""
    return shared_in_folder(lambda: arm_of(server), Path(__file__).parent, 'arm')


@contextmanager
def arm_of(server: Any) -> Iterator[ArmBench]:
    """Give the arm of a server; its client leaves the domain before that is leased again."""
    with ClientNode(server.domain, 'conformance') as client:
        bench = ArmBench(client, server.namespace, joint_states_topic(client))
        bench.start = bench.positions()
        bench.rules = bench.scene()
        yield bench


@pytest.fixture
def own_arm(own_server: Any) -> Iterator[ArmBench]:
    """Give the arm of a server that no other test uses."""
    with arm_of(own_server) as arm:
        yield arm


def joint_states_topic(client: ClientNode) -> str:
    """Return the first topic on which somebody publishes joint states."""
    pause = threading.Event()
    for _ in range(500):
        for name, kinds in client.node.get_topic_names_and_types():
            if kinds == ['sensor_msgs/msg/JointState'] and client.node.count_publishers(name):
                return name
        pause.wait(0.02)
    raise AssertionError('nobody publishes joint states')


@pytest.fixture
def rules(running: ArmBench) -> Any:
    """Give the scene that the server starts with."""
    return running.rules


@pytest.fixture
def arm(running: ArmBench, rules: Any) -> ArmBench:
    """Give the arm in an empty world."""
    running.clear(rules)
    return running


@pytest.fixture
def log(server: Any) -> Program:
    """Give the server's output."""
    if server.program is None:
        pytest.skip('the output of a server that ran before cannot be read')
    return server.program


@pytest.fixture
def lone(pytestconfig: pytest.Config) -> Iterator[Callable[..., LoneServer]]:
    """Give a function that starts move_group alone; the test plays the rest of the robot."""
    command = pytestconfig.getoption('server_command', None)
    if command is not None and not command.endswith('armsim_ros bringup'):
        pytest.skip('needs a server of its own with parameters of its own')
    with ExitStack() as stack:
        yield lambda *words, **options: stack.enter_context(LoneServer(*words, **options))


@pytest.fixture
def home(arm: Any) -> Any:
    """Give the arm at rest in its first named state."""
    assert arm.move(next(iter(arm.states))).code == 'SUCCESS'
    return arm


@pytest.fixture
def long_search(arm: Any) -> Iterator[dict[str, Any]]:
    """Give a goal round a wall, and the request's fields that make a plan last its minute."""
    set_planner(arm, 'RRTstar', anytime='true')
    assert arm.move(next(iter(arm.states))).code == 'SUCCESS'
    between = arm.pose(arm.near(0.4))
    wall = thing('wall', between.header.frame_id, [box(0.02, 0.02, 0.02)], pose=between.pose)
    assert arm.add(wall)
    yield {'goal': arm.near(0.8), 'planner_id': 'RRTstar', 'allowed_planning_time': 60.0}
    set_planner(arm, 'RRTstar', anytime='false')


@pytest.fixture
def long_plan(arm: Any, long_search: dict[str, Any]) -> Iterator[Any]:
    """Have a plan made that takes all of its minute, round a wall; cancel it afterwards."""
    handle = arm.send_move(plan_only=True, **long_search)
    yield handle
    arm.cancel(handle)
    assert arm.ended(handle, timeout=20.0).status == CANCELED
