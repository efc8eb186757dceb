# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A running arm in the launch description of a test, for launch_testing and launch_pytest.

It needs ROS' package ``launch``, or a launch file that ``armsim launch`` runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
import sys
from typing import Any

from armsim_ros.testing.program import private_domain

READY = b'You can start planning now!'


def bringup(*arguments: str, on_ready: Sequence[Any] = (), domain: int | None = None) -> Any:
    """
    Return a launch description that brings an arm up, and does something when it is ready.

    Everything that is launched after it gets its ROS domain, and so does the test itself, whose
    nodes find the arm. The end of bringup ends the launch, so that a test does not wait in vain.

    :param arguments: of bringup, such as ``robot:=sunday``.
    :param on_ready: actions, such as ``[launch_testing.actions.ReadyToTest()]``.
    :param domain: ROS domain; by default leased from this machine's tests until bringup has ended.
    :raises RuntimeError: all such domains are in use.
    """
    from launch import EventHandler, LaunchDescription
    from launch.actions import (
        ExecuteProcess,
        RegisterEventHandler,
        SetEnvironmentVariable,
        Shutdown,
    )
    from launch.event_handlers import OnProcessExit
    from launch.events.process import ProcessIO

    lease = ExitStack()
    if domain is None:
        domain = lease.enter_context(private_domain())
    program = ExecuteProcess(
        cmd=[sys.executable, '-m', 'armsim_ros', 'bringup', *arguments],
        name='bringup', output='screen')
    printed = bytearray()

    def is_ready(event: Any) -> bool:
        if not isinstance(event, ProcessIO) or event.action is not program:
            return False
        printed.extend(event.text)  # the line may come in parts
        found = READY in printed
        del printed[:-len(READY)]
        return found

    def ended(*_: Any) -> list[Any]:
        lease.close()
        return [Shutdown(reason='bringup has ended')]

    return LaunchDescription([
        SetEnvironmentVariable('ROS_DOMAIN_ID', str(domain)),
        SetEnvironmentVariable('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST'),
        SetEnvironmentVariable('PYTHONUNBUFFERED', '1'),
        # launch_testing and launch_pytest find a ReadyToTest only among known entities.
        RegisterEventHandler(
            EventHandler(matcher=is_ready, entities=list(on_ready), handle_once=True)),
        RegisterEventHandler(OnProcessExit(target_action=program, on_exit=ended)), program])
