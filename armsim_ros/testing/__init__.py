# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Tests of a robot arm: assertions, a pytest plugin, and small clients of a running stack.

Nothing here sleeps: every wait is for a condition or for simulated time, and has a limit. The
clients need ROS; a name is imported when it is first asked for. ``armsim_ros.testing.launch`` is
for launch_testing and launch_pytest.
"""

from importlib import import_module
from typing import Any

from armsim_ros.testing.assertions import (
    assert_holds,
    assert_no_collision,
    assert_no_contact,
    assert_reached,
    assert_rejected,
)

_CLIENTS = {
    'ClientNode': 'client_node', 'ControllerManagerClient': 'controller_manager_client',
    'MoveGroupClient': 'move_group_client', 'ParameterClient': 'parameter_client',
    'TrajectoryClient': 'trajectory_client', 'trajectory_message': 'trajectory_client',
    'RobotUser': 'robot_user', 'running_robot': 'robot_user', 'Program': 'program',
    'private_domain': 'domain', 'start_program': 'programs',
    'ClockRelay': 'relay', 'ServiceRelay': 'relay', 'TopicRelay': 'relay',
}  # fmt: skip

__all__ = [
    'assert_holds',
    'assert_no_collision',
    'assert_no_contact',
    'assert_reached',
    'assert_rejected',
]


def __getattr__(name: str) -> Any:
    """Return a client; it is imported now."""
    if name not in _CLIENTS:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f'{__name__}.{_CLIENTS[name]}'), name)
