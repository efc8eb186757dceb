# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""rclpy's client of an action, for use outside of the executor's thread."""

from __future__ import annotations

import threading
from typing import Any

from rclpy.action import ActionClient


class PatientActionClient(ActionClient):
    """
    rclpy's action client, which notes a request before it reads the answer.

    rclpy 7.1 drops an answer that its executor takes before the sending thread has noted the
    request (later versions hold a lock).
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        self._sending = threading.RLock()
        super().__init__(*args, **options)  # type: ignore[no-untyped-call] # rclpy's

    def send_goal_async(self, *args: Any, **options: Any) -> Any:
        """Send a goal."""
        with self._sending:
            return super().send_goal_async(*args, **options)  # type: ignore[no-untyped-call] # rclpy's

    def _cancel_goal_async(self, goal_handle: Any) -> Any:
        with self._sending:
            return super()._cancel_goal_async(goal_handle)  # type: ignore[no-untyped-call] # rclpy's

    def _get_result_async(self, goal_handle: Any) -> Any:
        with self._sending:
            return super()._get_result_async(goal_handle)  # type: ignore[no-untyped-call] # rclpy's

    async def execute(self, taken_data: Any) -> None:
        """Take answers once no request is about to be recorded."""
        with self._sending:
            pass
        await super().execute(taken_data)  # type: ignore[no-untyped-call] # rclpy's
