# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the simulation program loads, which decides how soon it starts."""

import subprocess
import sys


def test_the_simulation_loads_no_library_of_planning():
    """Pinocchio, coal, OMPL and toppra belong to move_group alone."""
    code = ('import sys, armsim_ros.nodes.simulation.program\n'
            "print(*{'pinocchio', 'coal', 'ompl', 'toppra'} & set(sys.modules))")
    loaded = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=True).stdout
    assert loaded.strip() == ''
