# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where the arms of tests come from: built in this process, or as programs on a leased domain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import json
from typing import Any, TYPE_CHECKING

import pytest

from armsim_ros.testing.plugin.marker import ArmRequest, requested
from armsim_ros.testing.program import domain_range, private_domain

if TYPE_CHECKING:
    from armsim_ros.clients.client_node import ClientNode
    from armsim_ros.config.robot_settings import RobotSettings
    from armsim_ros.model.cell import Cell
    from armsim_ros.testing.arms.arm import Arm
    from armsim_ros.testing.robot_user import RobotUser
    from armsim_ros.testing.started_stack import SharedStack


_cells: dict[tuple[str, str | None, str], Cell] = {}


def built_cell(robot: str, world: str | None, overrides: Mapping[str, Any]) -> Cell:
    """Return the checked files of a robot; each is read once a process."""
    from armsim_ros.model.cell_loading import load_cell

    key = (robot, world, repr(sorted(overrides.items())))
    if key not in _cells:
        _cells[key] = load_cell(robot, world=world, overrides=overrides)
    return _cells[key]


@contextmanager
def arm_in_process(desired: ArmRequest) -> Iterator[Arm]:
    """Give an arm that the test steps, built from files that are read once a process."""
    from armsim_ros.testing.arms.in_process import InProcessArm

    overrides = dict(desired.overrides)
    if desired.faults:
        overrides['simulation.fault_injection'] = True
    cell = built_cell(desired.robot, desired.world, overrides)
    yield InProcessArm(
        cell, seed=desired.seed, faults=desired.faults, time_limit=desired.time_limit)


@contextmanager
def arm_of_stack(request: pytest.FixtureRequest, desired: ArmRequest) -> Iterator[Arm]:
    """Give an arm of programs that the tests of a module share, as it is after their start."""
    shared: SharedStack = request.getfixturevalue('armsim_shared_stack')
    key = (desired.build_key, bool(desired.faults))
    robot = shared.at_start(key, _arguments(desired), lambda: _settings(desired).namespace)
    from armsim_ros.testing.arms.ros_arm import RosArm

    with _faulty(robot, desired):
        yield RosArm(robot, _settings(desired), faults=bool(desired.faults))


@pytest.fixture(scope='module')
def armsim_shared_stack(ros_domain: int) -> Iterator[SharedStack]:
    """Keep the programs of a module's tests, which are put back to their start in between."""
    from armsim_ros.testing.started_stack import SharedStack

    shared = SharedStack(ros_domain)
    yield shared
    shared.close()


@pytest.fixture(scope='module')
def ros_domain(request: pytest.FixtureRequest) -> Iterator[int]:
    """Lease a ROS domain that no other test on this machine has, for a module of tests."""
    with private_domain(_domains(request)) as domain:
        yield domain


@pytest.fixture(scope='module')
def armsim_stack(request: pytest.FixtureRequest) -> Iterator[RobotUser]:
    """Run the programs of the module's marker ``armsim`` for a module of tests."""
    with _running(request, requested(request.node, mode='process', seed=0)) as robot:
        yield robot


@pytest.fixture
def armsim_node(ros_domain: int) -> Iterator[ClientNode]:
    """Give a node that spins on the leased domain."""
    from armsim_ros.clients.client_node import ClientNode

    with ClientNode(ros_domain) as node:
        yield node


@contextmanager
def _running(request: pytest.FixtureRequest, desired: ArmRequest) -> Iterator[RobotUser]:
    from armsim_ros.testing.robot_user import running_robot

    namespace = _settings(desired).namespace
    domain = request.getfixturevalue('ros_domain')
    with (
        running_robot(*_arguments(desired), domain=domain, namespace=namespace) as robot,
        _faulty(robot, desired),
    ):
        yield robot


def _settings(desired: ArmRequest) -> RobotSettings:
    """Return the checked files of the robot."""
    return built_cell(desired.robot, desired.world, desired.overrides).settings


def _arguments(desired: ArmRequest) -> list[str]:
    """Return the arguments of bringup."""
    arguments = [f'robot:={desired.robot}']
    if desired.world is not None:
        arguments.append(f'world:={desired.world}')
    overrides: dict[str, Any] = dict(desired.overrides)
    if desired.faults:
        overrides['simulation.fault_injection'] = True
    if overrides:
        arguments.append(f'overrides:={json.dumps(overrides)}')
    return arguments


@contextmanager
def _faulty(robot: RobotUser, desired: ArmRequest) -> Iterator[None]:
    """Have joints fail for the time of the context."""
    for joint, fault in desired.faults.items():
        robot.fault(joint, **fault)
    yield
    for joint, fault in desired.faults.items():
        robot.fault(joint, **{kind: type(value)() for kind, value in fault.items()})


def _domains(request: pytest.FixtureRequest) -> range | None:
    given = request.config.getoption('armsim_domains') or request.config.getini('armsim_domains')
    return domain_range(given) if given else None
