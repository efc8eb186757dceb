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
    :returns: 0 after a signal, 2 after a mistake of the user's.
    """
    # It runs where nobody else wants to, so that it has to wait says nothing of the machine.
    return serve('armsim_ros.nodes.camera.program', 'CameraProgram', argv, watched=False)
