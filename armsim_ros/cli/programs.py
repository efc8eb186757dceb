# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The programs of the package; the one list that the command line and setup.py read.

Name of a program -> what it does, as one line. Its ``main(argv) -> exit status`` lies in the
module that ``module_of`` names, and ``armsim_ros.cli.main`` has an entry point of its name.
"""

from __future__ import annotations

#: Those that run a robot; they share ``armsim_ros.cli.arguments``.
ROBOT_PROGRAMS = {
    'bringup': 'start simulation and move_group, watch them, stop them together',
    'simulation': 'physics, controllers, controller_manager, joint states, /clock',
    'move_group': 'planning scene, kinematics, planning, trajectory execution',
}
#: Those that talk to a running robot; each has arguments of its own.
CLIENT_PROGRAMS = {
    'spawner': 'load, configure and activate controllers',
    'unspawner': 'deactivate and unload controllers',
}
#: Those that read and write files and start nothing; each has arguments of its own.
FILE_PROGRAMS = {
    'check_config': "read a robot's files, tell every mistake and what each key does here",
    'migrate': "write a robot's files in the layout of ROS 2",
    'generate_config': 'write a first set of files for a robot that has only a URDF',
}
PROGRAMS = {**ROBOT_PROGRAMS, **CLIENT_PROGRAMS, **FILE_PROGRAMS}


def module_of(program: str) -> str:
    """Return the module with a program's ``main``."""
    folder = 'tools' if program in FILE_PROGRAMS else 'nodes'
    return f'armsim_ros.{folder}.{program}.main'
