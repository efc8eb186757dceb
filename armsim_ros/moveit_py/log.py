# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The logger of scripts that plan."""

from __future__ import annotations

from collections.abc import Collection, Iterable
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


def warn_unused(names: Iterable[str], prefix: str, used: Collection[str]) -> None:
    """Log once which of the parameters below a prefix are not used, and those that are known."""
    below = (name.removeprefix(prefix) for name in names if name.startswith(prefix))
    unused = [name for name in below if name not in used]
    if unused:
        warn_once(f"parameters {prefix}*: {', '.join(unused)} not used; "
                  f"known: {', '.join(used)}")
