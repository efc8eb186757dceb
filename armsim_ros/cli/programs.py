# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The programs of the package; the one list that the command line and setup.py read."""

from __future__ import annotations

#: Name of a program -> what it does, as one line. Its ``main(argv) -> exit status`` lies in
#: ``armsim_ros.nodes.<name>.main``.
PROGRAMS = {
    'bringup': 'start simulation and move_group, watch them, stop them together',
    'simulation': 'physics, controllers, controller_manager, joint states, /clock',
    'move_group': 'planning scene, kinematics, planning, trajectory execution',
}
