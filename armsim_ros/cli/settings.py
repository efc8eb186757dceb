# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a program's arguments to the robot's settings; the same for every program."""

from __future__ import annotations

import math
from pathlib import Path

from armsim_ros.cli.arguments import ProgramArguments, UsageError
from armsim_ros.config.loading import survey_robot_settings
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import ConfigError, Severity
from armsim_ros.model.loading import survey_robot_model
from armsim_ros.model.robot_model import RobotModel


def robot_of(arguments: ProgramArguments) -> tuple[RobotSettings, RobotModel, list[str]]:
    """
    Read the robot that the arguments name, all of its files.

    :returns: the settings, the model that fits them, and what a user should know of them.
    :raises ConfigError: with every mistake of all files.
    :raises ResourceError: where the robot, its world or a named file is not there.
    """
    settings = _settings_of(arguments)
    found = list(settings.remarks)
    mistaken = any(one.severity is Severity.ERROR for one in found)
    model, of_model = survey_robot_model(settings, partial=mistaken)
    found += of_model
    mistakes = [one for one in found if one.severity is Severity.ERROR]
    if mistakes or model is None:
        raise ConfigError(mistakes)
    warnings = [str(one) for one in found if one.severity is Severity.WARNING]
    return settings, model, list(dict.fromkeys(warnings))


def _settings_of(arguments: ProgramArguments) -> RobotSettings:
    settings = survey_robot_settings(
        arguments.robot,
        config=_path(arguments.config),
        urdf=_path(arguments.urdf),
        srdf=_path(arguments.srdf),
        world=arguments.world or None,
        namespace=arguments.namespace or None,
        overrides=_overrides(arguments),
    )
    moved = {axis: _number(axis, getattr(arguments, axis))
             for axis in 'xyz' if getattr(arguments, axis)}
    return _placed(settings, moved) if moved else settings


def _overrides(arguments: ProgramArguments) -> dict[str, object]:
    overrides: dict[str, object] = {'simulation.paused': True} if arguments.paused else {}
    for pair in filter(None, arguments.initial_positions.split(',')):
        joint, sign, value = pair.partition('=')
        if not sign or not joint.strip():
            raise UsageError(f"cannot read '{pair}' of initial_positions; allowed: "
                             'JOINT=VALUE,JOINT=VALUE')
        overrides[f'simulation.initial_positions.{joint.strip()}'] = _number(
            f'initial_positions of {joint.strip()}', value)
    return overrides


def _placed(settings: RobotSettings, moved: dict[str, float]) -> RobotSettings:
    """Return the settings with the robot elsewhere; axes that are not given stay."""
    placement = settings.simulation.placement
    xyz = tuple(moved.get(axis, value) for axis, value in zip('xyz', placement.xyz, strict=True))
    simulation = settings.simulation.model_copy(
        update={'placement': placement.model_copy(update={'xyz': xyz})})
    return settings.model_copy(update={'simulation': simulation})


def _number(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(f"{name} is '{text}'; allowed: a finite number")
    return value


def _path(text: str) -> Path | None:
    return Path(text).expanduser() if text else None
