# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The bringup program: simulation, move_group and what is asked for, under one supervisor."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
import os
from pathlib import Path
import sys

from armsim_ros.cli.arguments import parse_arguments, ProgramArguments
from armsim_ros.cli.environment import program_command
from armsim_ros.errors import ResourceError
from armsim_ros.nodes.bridge import main as bridge
from armsim_ros.nodes.bringup.domain_lock import lock_domain
from armsim_ros.nodes.bringup.supervisor import Supervisor
from armsim_ros.nodes.web.main import MISSING, missing_package
from armsim_ros.resources import find_robot

#: In starting order: the simulation first, everyone waits for its joint states.
STARTED_PROGRAMS = ('simulation', 'move_group')
#: Started on request.
SERVO = 'servo_node'
#: Not needed to move the robot.
PAGE, CAMERA, BRIDGE = 'web', 'camera', 'bridge'


def main(argv: Sequence[str] | None = None) -> int:
    """
    Start the stack and stay until it ends.

    :param argv: the words after the program's name; those of this process where None.
    :returns: the exit status, see :meth:`Supervisor.run`.
    :raises UsageError: for an argument that is not known.
    :raises DomainTakenError: where another stack runs in the same ROS domain.
    """
    given = list(sys.argv[1:] if argv is None else argv)
    arguments = parse_arguments(given, xacro=True)
    if not _names_page(given) and sys.stdout.isatty() and not missing_package():
        arguments = replace(arguments, web=True)
    _check_robot(arguments)
    lock = lock_domain(arguments.ros_args)
    words = replace(arguments, web=False, bridge=False, host='').to_argv()
    try:
        programs = (*STARTED_PROGRAMS, *([SERVO] if arguments.servo else []),
                    *([CAMERA] if arguments.camera else []))
        commands = {program: program_command(program, words) for program in programs}
        if arguments.web:
            commands.update(page_command(arguments))
        if arguments.bridge:
            commands.update(bridge_command(arguments))
        report(f"loading {arguments.robot}; starting {', '.join(commands)}")
        status = Supervisor(commands, spare=(PAGE, CAMERA, BRIDGE)).run()
        if status == 0:
            report('all has stopped')
        return status
    finally:
        lock.release()


def _names_page(words: Sequence[str]) -> bool:
    """Return whether the command line decides about the page."""
    return any(word.lstrip('-').partition('=')[0].rstrip(':') == 'web' for word in words)


def _check_robot(arguments: ProgramArguments) -> None:
    """
    Refuse a robot that is not there, before anything starts.

    :raises ConfigError: there is no such robot.
    """
    try:
        find_robot(arguments.robot)
    except ResourceError:
        # Slow to import, and needed for names of packages alone.
        from armsim_ros.config.robot_folder import robot_folder
        from armsim_ros.packages import Packages, split_path

        robot_folder(arguments.robot, Packages(split_path(arguments.packages_path)))


def page_command(arguments: ProgramArguments) -> dict[str, list[str]]:
    """
    Return the page's command; none, and a message, where it cannot be served.

    :raises ConfigError: where the robot's files, which the page shows meshes of, are wrong.
    """
    missing = missing_package()
    if missing:
        report(f'no page: {MISSING.format(missing)}')
        return {}
    words = mesh_words(arguments)
    if arguments.host:
        words.append(f'host:={arguments.host}')
    return {PAGE: program_command(PAGE, [*words, *arguments.ros_args])}


def bridge_command(arguments: ProgramArguments) -> dict[str, list[str]]:
    """
    Return the bridge's command; none, and a message, where it cannot run.

    :raises ConfigError: where the robot's files, which it serves meshes of, are wrong.
    """
    missing = bridge.missing_package()
    if missing:
        report(f'no bridge: {bridge.MISSING.format(missing)}')
        return {}
    time = f'use_sim_time:={str(arguments.use_sim_time).lower()}'
    return {BRIDGE: program_command(
        BRIDGE, [*mesh_words(arguments), '--ros-args', '-p', time, '--', *arguments.ros_args])}


def mesh_words(arguments: ProgramArguments) -> list[str]:
    """Return the arguments with which a program finds the packages of meshes."""
    near = os.pathsep.join(map(str, places_near(arguments)))
    words = [f'near:={near}'] if near else []
    if arguments.packages_path:
        words.append(f'packages_path:={arguments.packages_path}')
    return words


def places_near(arguments: ProgramArguments) -> list[Path]:
    """
    Return the files and folders around which the robots' packages lie.

    :raises ConfigError: where the robot's files are wrong.
    """
    # Slow to import: a stack without a page comes up sooner, and its programs read the files.
    from armsim_ros.cli.settings import cell_of
    from armsim_ros.model.loading import packages_of

    cell, _ = cell_of(arguments)
    return list(dict.fromkeys(
        path for robot in cell.robots for path in packages_of(robot.settings).near))


def report(text: str) -> None:
    """Print a line of bringup's own."""
    with suppress(BrokenPipeError):
        print(f'[bringup] {text}', flush=True)
