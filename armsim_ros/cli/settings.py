# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a program's arguments to the robots that it serves; the same for every program."""

from __future__ import annotations

from dataclasses import replace
import math
from pathlib import Path

from armsim_ros.cli.arguments import ProgramArguments, UsageError
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import Severity
from armsim_ros.model.cell import Cell
from armsim_ros.model.cell_loading import survey_cell


def cell_of(arguments: ProgramArguments) -> tuple[Cell, list[str]]:
    """
    Read the robot, or the cell of several, that the arguments name, all of its files.

    :returns: the cell, and what a user should know of it.
    :raises ConfigError: with every mistake of all files.
    :raises ResourceError: where the robot, its world or a named file is not there.
    """
    survey = survey_cell(
        arguments.robot,
        config=_path(arguments.config),
        urdf=_path(arguments.urdf),
        srdf=_path(arguments.srdf),
        world=arguments.world or None,
        namespace=arguments.namespace or None,
        overrides=_overrides(arguments),
    )
    cell = survey.checked()
    warnings = [str(one) for one in survey.problems if one.severity is Severity.WARNING]
    moved = {axis: _number(axis, getattr(arguments, axis))
             for axis in 'xyz' if getattr(arguments, axis)}
    if moved:
        cell = replace(cell, settings=_placed(cell.settings, moved))
    return cell, list(dict.fromkeys(warnings))


def _overrides(arguments: ProgramArguments) -> dict[str, object]:
    overrides: dict[str, object] = {
        path: True
        for path, wanted in (
            ('simulation.paused', arguments.paused),
            ('planning_parameters.scene_from_world', arguments.scene_from_world),
        )
        if wanted
    }
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
