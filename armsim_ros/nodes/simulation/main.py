# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulation program."""

from __future__ import annotations

from collections.abc import Sequence
import os

from armsim_ros.nodes.robot_program import serve


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run the simulation until SIGINT or SIGTERM.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 after a signal, 2 after a user's error, 1 after a failure.
    """
    # Nothing is drawn here: MuJoCo need not search for a renderer, nor reject any.
    os.environ['MUJOCO_GL'] = 'disable'
    return serve('armsim_ros.nodes.simulation.program', 'SimulationProgram', argv)
