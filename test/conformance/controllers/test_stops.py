# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""An arm that is stopped by a service, and cleared by another."""

from __future__ import annotations

from collections.abc import Iterator
import json
from typing import Any

from controller_bench import Bench, TrajectoryController
from industrial_msgs.msg import RobotStatus
import pytest
from std_msgs.msg import String
from std_srvs.srv import SetBool, Trigger

from armsim_ros.clients.client_node import LATCHED
from armsim_ros.clients.trajectory import ABORTED, SUCCEEDED

statement = pytest.mark.statement


@pytest.fixture
def safety(bench: Bench) -> Iterator[Any]:
    """Give what collects the states of the safety; afterwards no stop is left."""
    collector = bench.client.collect(bench.name('safety'), String, LATCHED)
    yield collector
    press(bench, 'emergency_stop', False)
    bench.client.call(bench.name('clear_stop'), Trigger)
    collector.close()


def press(bench: Bench, name: str, pressed: bool) -> Any:
    """Press or release a button; return the answer."""
    return bench.client.call(bench.name(name), SetBool, SetBool.Request(data=pressed))


def wait_for(safety: Any, value: str) -> dict[str, Any]:
    """Return the state in which the safety has a value."""
    message = safety.wait_for(lambda message: json.loads(message.data)['safety'] == value)
    return dict(json.loads(message.data))


@statement('HW-B3', 'HW-B6')
def test_a_protective_stop_ends_goals_until_it_is_cleared(
    bench: Bench, arm: TrajectoryController, safety: Any
) -> None:
    """The goal is aborted with the reason, others are rejected, and the topic has the state."""
    goal = arm.goal(arm.to([1.0, 1.0], 2.0))
    goal.wait_for_feedback(2)
    assert press(bench, 'protective_stop', True).success
    outcome = goal.result()
    assert outcome.status == ABORTED
    assert outcome.error_string == 'protective stop: injected'
    assert wait_for(safety, 'PROTECTIVE_STOP')['cause'] == 'injected'
    assert not arm.goal(arm.to([0.0, 0.0])).accepted()
    assert bench.client.call(bench.name('clear_stop'), Trigger).success
    wait_for(safety, 'NORMAL')
    assert arm.run(arm.to([0.0, 0.0], 1.0)).status == SUCCEEDED


@statement('HW-B6')
def test_robot_status_follows_a_stop(bench: Bench, safety: Any) -> None:
    """As drivers of ROS-Industrial publish it: why the arm cannot move, and since when it can."""
    status = bench.client.collect(bench.name('robot_status'), RobotStatus, 1)
    message = status.wait_for(lambda message: message.motion_possible.val == 1)
    assert (message.drives_powered.val, message.mode.val, list(message.error_codes)) == (1, 2, [])
    assert press(bench, 'protective_stop', True).success
    message = status.wait_for(lambda message: message.in_error.val == 1)
    assert (message.e_stopped.val, message.motion_possible.val) == (0, 0)
    assert list(message.error_codes) == [1]
    assert press(bench, 'emergency_stop', True).success
    status.wait_for(lambda message: (message.e_stopped.val, list(message.error_codes)) == (1, [6]))
    assert press(bench, 'emergency_stop', False).success
    assert bench.client.call(bench.name('clear_stop'), Trigger).success
    status.wait_for(lambda message: message.motion_possible.val == 1)
    assert bench.client.call(bench.name('power_off'), Trigger).success
    status.wait_for(lambda message: message.drives_powered.val == 0)
    assert bench.client.call(bench.name('power_on'), Trigger).success
    status.wait_for(lambda message: message.motion_possible.val == 1)
    status.close()


@statement('HW-B4', 'HW-B6')
def test_an_emergency_stop_is_not_cleared_while_it_is_pressed(
    bench: Bench, arm: TrajectoryController, safety: Any
) -> None:
    """clear_stop fails with a reason until the button is released."""
    assert press(bench, 'emergency_stop', True).success
    wait_for(safety, 'EMERGENCY_STOP')
    response = bench.client.call(bench.name('clear_stop'), Trigger)
    assert not response.success
    assert 'release it first' in response.message
    assert press(bench, 'emergency_stop', False).success
    assert bench.client.call(bench.name('clear_stop'), Trigger).success
    assert arm.run(arm.to([0.0, 0.0], 1.0)).status == SUCCEEDED
