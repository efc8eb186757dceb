# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The programs of the package; the list that the command line and setup.py read.

Name of a program -> what it does, as a line. Its ``main(argv) -> exit status`` lies in the
module that ``main_of`` names, and ``armsim_ros.cli.main`` has an entry point of its name.
"""

from __future__ import annotations

#: Those that run a robot; they share ``armsim_ros.cli.arguments``.
ROBOT_PROGRAMS = {
    'bringup': 'start, monitor and stop simulation and move_group',
    'simulation': 'physics, controllers, controller_manager, joint states, /clock',
    'move_group': 'planning scene, kinematics, planning, trajectory execution',
    'camera': 'render the camera images of a simulation started with camera:=true',
    'servo_node': 'streaming: twists, joint jogs and poses to joint commands',
    'servo_node_main': 'servo_node under its name of Humble',
}
#: A page, and the controllers of a running robot; each has arguments of its own.
CLIENT_PROGRAMS = {
    'web': 'serve the page that shows and moves the robot in a browser',
    'bridge': 'rosbridge and rosapi, for browsers and programs without ROS',
    'teleop': 'move a running arm by keyboard, gamepad or leader arm',
    'spawner': 'load, configure and activate controllers',
    'unspawner': 'deactivate and unload controllers',
    'hardware_spawner': 'configure or activate hardware components',
}
#: Small commands to a running robot, for a terminal and for scripts.
VERBS = {
    'go': 'plan and move: armsim go scan_food, armsim go joint_1=30deg',
    'state': 'print joint positions, controllers and named states',
    'stop': 'end every motion, of any client',
    'plot': 'draw a motion: desired, actual, error, tolerance of each joint',
}
#: Those that read and write files and start nothing; each has arguments of its own.
FILE_PROGRAMS = {
    'check_config': "read a robot's files, report every error and how each key is used",
    'migrate': "write a robot's files in the layout of ROS 2",
    'list': 'list the available robots: included, in the workspace, installed',
    'copy': "copy a robot's files into a new folder, to change them",
    'generate_config': 'write the configuration of a robot from its URDF',
    'completion': 'print the completion script of bash, zsh or fish',
}
#: Those that collect and check data for robot learning; without ROS.
LEARNING_PROGRAMS = {
    'collect': 'collect episodes of a task as a LeRobot data set',
    'evaluate': 'run a policy in a task and print how often it succeeds',
    'dataset': 'write recordings of topics as a LeRobot data set',
    'replay': 'run the actions of a data set again and compare',
}
#: Those that run a user's launch files.
LAUNCH_PROGRAMS = {
    'launch': "run a launch file unchanged, with this package's programs in place of upstream's",
    'run': 'start a program of a package, in the workspace or in place of upstream',
    'overlay': "make a ROS installation's ros2 launch start this package's programs",
    'original': "replace a program of ros2_control or MoveIt, with that program's arguments",
}
_SERVERS = {'simulation': 'simulation', 'move_group': 'move_group', 'camera': 'camera',
            'servo_node': 'servo_node', 'servo_node_main': 'servo_node'}
#: Program -> its function, where that is not ``main`` of the module ``main`` in its own folder.
_MAINS = {
    **{program: f'nodes.robot_program:{name}' for program, name in _SERVERS.items()},
    **{verb: f'nodes.verbs.{verb}:main' for verb in VERBS},
    **{name: f'tools.learning:{name}' for name in LEARNING_PROGRAMS},
    'launch': 'launch.main:main', 'run': 'launch.run:main', 'overlay': 'launch.overlay:main',
    'list': 'tools.robots:list_robots', 'copy': 'tools.robots:copy',
    'completion': 'tools.completion:main', 'original': 'nodes.upstream.main:main',
    'spawner': 'nodes.upstream.spawner:main', 'unspawner': 'nodes.upstream.spawner:unspawn',
    'hardware_spawner': 'nodes.upstream.spawner:set_hardware', 'migrate': 'tools.migrate:main',
}
_LISTED = ('topic', 'service', 'action', 'node', 'param')
#: What is looked for here and is a command of ROS 2 -> that command.
ROS2_COMMANDS = {
    **{name: f'ros2 {name}' for name in (*_LISTED, 'control', 'interface', 'bag', 'doctor')},
    **{f'{name}s': f'ros2 {name} list' for name in _LISTED},
    'echo': 'ros2 topic echo', 'pub': 'ros2 topic pub', 'hz': 'ros2 topic hz',
    'call': 'ros2 service call', 'switch': 'ros2 control switch_controllers',
}
PROGRAMS = {**ROBOT_PROGRAMS, **CLIENT_PROGRAMS, **VERBS, **FILE_PROGRAMS, **LEARNING_PROGRAMS,
            **LAUNCH_PROGRAMS}
#: A task -> the programs for it.
PURPOSES = {
    'run a robot': (*ROBOT_PROGRAMS, *LAUNCH_PROGRAMS),
    'see it, move it, query it': (*VERBS, *CLIENT_PROGRAMS),
    "prepare a robot's files": tuple(FILE_PROGRAMS),
    'robot learning': tuple(LEARNING_PROGRAMS),
}


def main_of(program: str) -> str:
    """Return ``module:function`` of a program."""
    folder = 'tools' if program in FILE_PROGRAMS else 'nodes'
    return f'armsim_ros.{_MAINS.get(program, f"{folder}.{program}.main:main")}'
