# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Hands over to a real ros2 further down PATH."""

from __future__ import annotations

from collections.abc import Sequence
import os
from pathlib import Path
import sys

from armsim_ros2.packages import is_program, package_prefixes

#: In every copy of this command; another environment's copy is not the real ros2.
_OWN_MARK = b'armsim_ros2'


def hand_over(argv: Sequence[str]) -> None:
    """
    Become the real ros2 if there is one on PATH; return otherwise.

    :param argv: the arguments after ``ros2``.
    """
    real = find_real_ros2(os.environ.get('PATH', ''))
    if real is not None:
        os.execve(real, [str(real), *argv], environment_for_real_ros2())


def find_real_ros2(search_path: str) -> Path | None:
    """
    Return the first ros2 on the search path that is not a copy of this command.

    :param search_path: folders, as in PATH.
    """
    for entry in search_path.split(os.pathsep):
        candidate = Path(entry or '.', 'ros2')
        if not is_program(candidate):
            continue
        with open(candidate, 'rb') as stream:
            if _OWN_MARK not in stream.read(4096):
                return candidate
    return None


def environment_for_real_ros2() -> dict[str, str]:
    """Return the environment in which another Python finds its own libraries and our packages."""
    environment = dict(os.environ)
    # The start-up hook of the rclpy wheels sets both for this environment's Python alone.
    if environment.pop('_ROS_WHEELS_BOOTSTRAP_COMPLETE', None):
        paths = environment.pop('LD_LIBRARY_PATH', '').split(os.pathsep)
        others = [path for path in paths if path and not path.startswith(sys.prefix + os.sep)]
        if others:
            environment['LD_LIBRARY_PATH'] = os.pathsep.join(others)
    environment['AMENT_PREFIX_PATH'] = os.pathsep.join(map(str, package_prefixes()))
    return environment
