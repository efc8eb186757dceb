# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The camera program: pictures of a simulation that runs with ``camera:=true``."""

from __future__ import annotations

from collections.abc import Sequence

from armsim_ros.nodes.robot_program import serve


def main(argv: Sequence[str] | None = None) -> int:
    """
    Publish pictures until SIGINT or SIGTERM.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 after a signal, 2 after a user's error.
    """
    # It runs at the lowest priority, so that its waiting is no measure of the load.
    return serve('armsim_ros.nodes.camera.program', 'CameraProgram', argv, watched=False)
