# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What tests with pymoveit2 wait for and measure."""

from __future__ import annotations

from collections.abc import Callable
import math
import threading
import time
from typing import Any

from rclpy.action import ActionClient

TIMEOUT = 20.0


class PatientActionClient(ActionClient):
    """
    rclpy's action client, which notes a request before it looks at the answer.

    rclpy 7.1 drops an answer that its executor takes before the sending thread has noted the
    request (later versions hold a lock).
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        """Make the lock, then the client."""
        self._sending = threading.RLock()
        super().__init__(*args, **options)

    def send_goal_async(self, *args: Any, **options: Any) -> Any:
        """Send a goal."""
        with self._sending:
            return super().send_goal_async(*args, **options)

    def _cancel_goal_async(self, goal_handle: Any) -> Any:
        with self._sending:
            return super()._cancel_goal_async(goal_handle)

    def _get_result_async(self, goal_handle: Any) -> Any:
        with self._sending:
            return super()._get_result_async(goal_handle)

    async def execute(self, taken_data: Any) -> None:
        """Take answers once nobody is about to note a request."""
        with self._sending:
            pass
        await super().execute(taken_data)


def until(condition: Callable[[], Any], what: str, timeout: float = 10.0) -> Any:
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
