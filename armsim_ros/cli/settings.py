# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a program's arguments to the robots that it serves; the same for every program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
import math
import os
from pathlib import Path

import yaml

from armsim_ros.cli.arguments import (
    check_xacro_words,
    parse_arguments,
    ProgramArguments,
    shadowed_xacro_words,
    UsageError,
    XACRO,
)
from armsim_ros.config.robot_folder import FileOptions, find_files
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import Severity
from armsim_ros.model.cell import Cell
from armsim_ros.model.cell_loading import survey_cell, SurveyOptions
from armsim_ros.model.description.xacro_text import declared_arguments
from armsim_ros.model.world_objects import with_default_floor
from armsim_ros.packages import split_path

LOCKSTEP = 'lockstep'
MODES = ('realtime', LOCKSTEP)
#: How far back the recording of a run reaches [s].
LONGEST_RECORD = 600.0


def xacro_help(words: Sequence[str]) -> str:
    """
    Return the arguments that the xacro of a robot declares, with their defaults, as text.

    :param words: a command line; '' comes back where it names no robot, or a robot without xacro.
    :raises ArmsimError: where the robot is not there.
    """
    requested = [word for word in words if word not in ('-h', '--help')]
    arguments = parse_arguments(requested, xacro=True)
    if not any(word.startswith(('robot', '--robot', 'urdf', '--urdf')) for word in requested):
        return ''
    given = dict(arguments.xacro)
    files = find_files(arguments.robot, **_sources(arguments, given))
    declared: dict[str, str] = {}
    for file in (files.urdf_file, files.srdf_file):
        if file is not None and not files.is_cell:
            declared = {**declared_arguments(
                file, mappings=files.arguments,
                packages=files.packages.beside(file.resolve())), **declared}
    if not declared:
        return ''
    width = max(map(len, declared))
    rows = [f'  {name + ":=":<{width + 2}}  (default: {value!r})'
            for name, value in declared.items()]
    return '\n'.join([f"arguments of the xacro of '{files.name}':", *rows])


def _sources(arguments: ProgramArguments, xacro: Mapping[str, str]) -> FileOptions:
    """Return where the files of the robot are, as keyword arguments."""
    return {
        'config': _path(arguments.config),
        'urdf': _path(arguments.urdf),
        'srdf': _path(arguments.srdf),
        'controllers': tuple(Path(path).expanduser()
                             for path in arguments.controllers.split(',') if path),
        'arguments': xacro,
        'packages_path': split_path(arguments.packages_path),
    }


def cell_of(arguments: ProgramArguments) -> tuple[Cell, list[str]]:
    """
    Read the robot, or the cell of several, that the arguments name, all of its files.

    :returns: the cell, and what a user should know of it.
    :raises ConfigError: with every error of all files.
    :raises ResourceError: where the robot, its world or a named file is not there.
    """
    survey = survey_cell(arguments.robot, **survey_options(arguments))
    check_xacro_words(arguments, survey.declared)
    cell = survey.checked()
    warnings = [str(problem) for problem in survey.problems
                if problem.severity is Severity.WARNING]
    warnings += shadowed_xacro_words(arguments, survey.declared)
    moved = _moved(arguments)
    if moved:
        settings, remarks = with_default_floor(_placed(cell.settings, moved), cell.model)
        cell = replace(cell, settings=settings)
        warnings += map(str, remarks)
    return cell, list(dict.fromkeys(warnings))


def survey_options(arguments: ProgramArguments) -> SurveyOptions:
    """
    Return what the arguments mean in the robot's settings, but for its name.

    :raises UsageError: where a value cannot be read.
    """
    _moved(arguments)
    return {
        **_sources(arguments, dict(arguments.xacro)),
        'world': arguments.world or None,
        'namespace': arguments.namespace or None,
        'overrides': _overrides(arguments),
    }


def _moved(arguments: ProgramArguments) -> dict[str, float]:
    """Return where the robot is placed [m], of the axes that are given."""
    return {axis: _number(axis, getattr(arguments, axis))
            for axis in 'xyz' if getattr(arguments, axis)}


def _overrides(arguments: ProgramArguments) -> dict[str, object]:
    overrides = {**_mode(arguments), **_given_overrides(arguments.overrides)}
    overrides.update({
        path: True
        for path, requested in (('simulation.paused', arguments.paused),)
        if requested})
    if arguments.octomap:
        overrides['planning_parameters.octomap'] = True
    if arguments.scene_from_world:
        overrides['planning_parameters.scene_from_world'] = arguments.scene_from_world
    for pair in filter(None, arguments.initial_positions.split(',')):
        joint, sign, value = pair.partition('=')
        if not sign or not joint.strip():
            raise UsageError(f"cannot read '{pair}' of initial_positions; allowed: "
                             'JOINT=VALUE,JOINT=VALUE')
        overrides[f'simulation.initial_positions.{joint.strip()}'] = _number(
            f'initial_positions of {joint.strip()}', value)
    return overrides


def _mode(arguments: ProgramArguments) -> dict[str, object]:
    """Return what mode, seed and record mean in settings."""
    if arguments.mode not in MODES:
        raise UsageError(
            f"'{arguments.mode}' is not a mode; allowed: {', '.join(MODES)}; an argument 'mode' "
            f"of the robot's xacro is set with {XACRO}mode:={arguments.mode}")
    seed = arguments.seed
    if seed and not seed.isdecimal():
        raise UsageError(f"cannot read the seed '{seed}'; allowed: 0 or a positive whole number")
    overrides: dict[str, object] = {}
    if arguments.mode == LOCKSTEP:
        overrides.update({
            'simulation.deterministic': True,
            'simulation.paused': True,
            'simulation.real_time_factor': 0.0,
            'simulation.pace.priority': 0,
        })
    if seed or arguments.mode == LOCKSTEP:
        overrides['ompl.planning_seed'] = int(seed or 0)
    if arguments.record:
        _check_recording(arguments.record)
        overrides['simulation.recorder.file'] = arguments.record
        overrides['simulation.recorder.seconds'] = LONGEST_RECORD
    return overrides


def _check_recording(file: str) -> None:
    """Refuse at the start what could not be written at the end of the run."""
    path = Path(file).expanduser().absolute()
    place = next(parent for parent in (path, *path.parents) if parent.exists())
    if path.is_dir() or (place != path and not place.is_dir()):
        wrong = f"'{place}' is a {'folder' if path.is_dir() else 'file'}"
    elif not os.access(place, os.W_OK):
        wrong = f"'{place}' cannot be written"
    else:
        return
    raise UsageError(f'record:={file}: {wrong}; name a file in a folder that can be written')


def _given_overrides(text: str) -> dict[str, object]:
    try:
        given = yaml.safe_load(text) if text else {}
    except yaml.YAMLError:
        given = None
    if not isinstance(given, dict) or not all(isinstance(path, str) for path in given):
        raise UsageError(f"cannot read '{text}' of overrides; allowed: dotted paths with values, "
                         "such as '{simulation.gravity: [0, 0, 0]}'")
    return given


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
