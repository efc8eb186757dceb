# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The logger of scripts that plan."""

from __future__ import annotations

from typing import Any

from rclpy.logging import get_logger

_reported: set[str] = set()


def logger() -> Any:
    """Return the logger."""
    return get_logger('moveit_py')


def warn_once(text: str) -> None:
    """Log a warning once per process."""
    if text not in _reported:
        _reported.add(text)
        logger().warning(text)
