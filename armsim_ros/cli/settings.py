# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a program's arguments to the robot's settings; the same for every program."""

from __future__ import annotations

from pathlib import Path

from armsim_ros.cli.arguments import ProgramArguments
from armsim_ros.config.loading import load_robot_settings
from armsim_ros.config.robot_settings import RobotSettings


def settings_of(arguments: ProgramArguments) -> RobotSettings:
    """
    Return the settings that a command line asks for.

    :param arguments: the command line; an empty text leaves the choice to the robot's files.
    :raises ConfigError: with every mistake of all files.
    :raises ResourceError: where the robot, its world or a named file is not there.
    """
    return load_robot_settings(
        arguments.robot,
        config=_path(arguments.config),
        urdf=_path(arguments.urdf),
        srdf=_path(arguments.srdf),
        world=arguments.world or None,
        namespace=arguments.namespace or None,
        overrides={'simulation.paused': True} if arguments.paused else None,
    )


def _path(text: str) -> Path | None:
    return Path(text).expanduser() if text else None
