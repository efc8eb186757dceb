# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The launch program: ``armsim launch PACKAGE FILE [name:=value ...]``."""

from __future__ import annotations

from collections.abc import MutableMapping, Sequence
import os
from pathlib import Path
import sys

from armsim_ros.errors import ArmsimError, USAGE_STATUS
from armsim_ros.launch.evaluation import Launch, parse_words, USAGE
from armsim_ros.launch.overlay import environment_with, overlay_folder, write_overlay
from armsim_ros.packages import MARKERS, sourced_prefixes

#: What a sourced installation of Jazzy sets.
ROS_VARIABLES = {'ROS_DISTRO': 'jazzy', 'ROS_VERSION': '2', 'ROS_PYTHON_VERSION': '3'}


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run a launch file, or show what it would start.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 after Ctrl-C or a good end, 1 when a required process failed, 2 for errors
        before the start.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    if not words or {'-h', '--help'} & set(words):
        print(USAGE)
        return 0 if words else USAGE_STATUS
    try:
        requested = parse_words(words)
    except ArmsimError as error:
        print(f'launch: {error}', file=sys.stderr)
        return USAGE_STATUS
    _complete_environment(os.environ)
    launch = Launch(requested)
    if requested.show_arguments:
        return launch.show_arguments()
    if requested.print_description:
        return launch.print_description()
    if requested.dry:
        return launch.dry_run()
    real = _real_ros2()
    if real:
        # Where the real launch is installed, it runs the file; the overlay gives it our programs.
        folder = write_overlay(overlay_folder())
        os.execve(real, [real, 'launch', *words], environment_with(folder))
    return launch.run()


def _complete_environment(environment: MutableMapping[str, str]) -> None:
    """Set what sourcing a ROS installation sets; launch files and their programs rely on it."""
    for name, value in ROS_VARIABLES.items():
        environment.setdefault(name, value)
    programs = str(Path(sys.executable).parent)
    paths = environment.get('PATH', os.defpath).split(os.pathsep)
    if programs not in paths:
        # The environment need not be active for its xacro and ros2 to be found.
        environment['PATH'] = os.pathsep.join([*paths, programs])


def _real_ros2() -> str:
    """Return ``ros2`` of a sourced ROS installation with launch, '' if there is none."""
    for prefix in sourced_prefixes():
        program = prefix / 'bin' / 'ros2'
        if (prefix / MARKERS / 'ros2launch').is_file() and os.access(program, os.X_OK):
            return str(program)
    return ''
