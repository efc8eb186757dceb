# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What tests with installed clients start, wait for and measure."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import math
import shlex
import sys
import threading
import time
from typing import Any

from faster import FASTER_BUT_CALM
import pytest

from armsim_ros.clients.action_client import PatientActionClient
from armsim_ros.testing.program import private_domain, Program, ros_environment

TIMEOUT = 20.0
READY = 'You can start planning now!'


@contextmanager
def default_arm(config: pytest.Config) -> Iterator[int]:
    """Run the default arm for a client; gives its domain. Skip where another server is tested."""
    command = config.getoption('server_command', None)
    if command is not None and not command.endswith('armsim_ros bringup'):
        pytest.skip('needs the default arm')
    words = f'{shlex.quote(sys.executable)} -m armsim_ros bringup {shlex.quote(FASTER_BUT_CALM)}'
    with (
        private_domain() as domain,
        Program(shlex.split(words), environment=ros_environment(domain)) as program,
    ):
        program.wait_for_line(READY, 60.0)
        yield domain


@contextmanager
def no_answer_lost(*clients: str) -> Iterator[None]:
    """
    Give the modules of a client an ActionClient that loses no answer.

    That of rclpy 7.1 drops an answer that arrives before its request is noted; later versions
    hold a lock.

    :param clients: dotted names of their ``ActionClient``.
    """
    with pytest.MonkeyPatch.context() as patch:
        for name in clients:
            patch.setattr(name, PatientActionClient)
        yield


def until(condition: Callable[[], Any], what: str, timeout: float = 30.0) -> Any:
    """Return what the condition says as soon as it is true of it."""
    deadline = time.monotonic() + timeout
    pause = threading.Event()
    while not (value := condition()):
        assert time.monotonic() < deadline, f'not in {timeout} s: {what}'
        pause.wait(0.01)
    return value


def positions(arm: Any) -> dict[str, float]:
    """Return joint positions of a message that comes from now on [rad or m]."""
    arm.reset_new_joint_state_checker()
    until(lambda: arm.new_joint_state_available, 'a joint state')
    return dict(zip(arm.joint_state.name, arm.joint_state.position, strict=True))


def distance(arm: Any, target: list[float]) -> float:
    """Return the largest distance of a joint from its target [rad or m]."""
    now = positions(arm)
    return max(abs(now[n] - v) for n, v in zip(arm.joint_names, target, strict=True))


def reached(arm: Any, wanted: Any, position: float, orientation: float) -> None:
    """Assert that the end effector is at a pose within [m] and [rad]."""
    positions(arm)
    pose = arm.compute_fk().pose
    assert math.dist(xyz(pose.position), xyz(wanted.pose.position)) < position
    assert angle(pose.orientation, wanted.pose.orientation) < orientation


def xyz(point: Any) -> tuple[float, float, float]:
    """Return a point as numbers [m]."""
    return point.x, point.y, point.z


def angle(a: Any, b: Any) -> float:
    """Return the angle between two orientations [rad]."""
    dot = abs(a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w)
    return 2.0 * math.acos(min(1.0, dot))
