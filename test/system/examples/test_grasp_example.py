# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The example that looks, grasps and puts down, against a running stack."""

import os
from pathlib import Path
import subprocess
import sys

import pytest

from armsim_ros.testing.program import private_domain, ros_environment, start_program

EXAMPLE = Path(__file__).parents[3] / 'examples' / 'grasp.py'
#: Of a machine that draws only when nothing else wants the processor [s].
PATIENCE = 300.0


def test_the_cube_is_found_and_put_where_it_belongs(drawing):
    """Camera, planner that sees the world, and suction cup work together."""
    pytest.importorskip('pymoveit2', reason='pymoveit2 is not installed')
    with private_domain() as domain, start_program(
        'bringup', domain, 'world:=feeding_place', 'camera:=true'
    ) as program:
        program.wait_for_line('You can start planning now!', 60.0)
        program.wait_for_line('cameras: camera; drawn by', PATIENCE)
        run = subprocess.run(
            [sys.executable, str(EXAMPLE)], env={**os.environ, **ros_environment(domain)},
            capture_output=True, text=True, timeout=PATIENCE)
    assert run.returncode == 0, run.stdout + run.stderr
    assert '1 of 1 runs put the cube at its target' in run.stdout
