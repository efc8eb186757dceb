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

#: Module -> the public names that are imported when they are first asked for.
_LAZY = {
    'armsim_ros.clients.client_node': ('ClientNode',),
    'armsim_ros.clients.controller_manager': ('ControllerManagerClient', 'ParameterClient'),
    'armsim_ros.clients.move_group': ('MoveGroupClient',),
    'armsim_ros.testing.relay': ('ClockRelay', 'ServiceRelay', 'TopicRelay'),
    'armsim_ros.testing.robot_user': ('RobotUser', 'running_robot'),
    'armsim_ros.clients.trajectory': ('TrajectoryClient', 'trajectory_message'),
    'armsim_ros.testing.program': ('private_domain', 'Program', 'start_program'),
}

__all__ = [
    'assert_holds', 'assert_no_collision', 'assert_no_contact', 'assert_reached',
    'assert_rejected']


def __getattr__(name: str) -> Any:
    for module, names in _LAZY.items():
        if name in names:
            return getattr(import_module(module), name)
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
