# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""All checks of a robot's files, or of a single file, without starting anything."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from typing_extensions import Unpack

from armsim_ros.cli.arguments import is_harmless
from armsim_ros.config.cell import read_cell
from armsim_ros.config.draft import ConfigDraft
from armsim_ros.config.layout import LayoutReader
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.sections import read_sections
from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.errors import (
    ArmsimError,
    ConfigError,
    Location,
    nearest,
    Problem,
    Severity,
    strictly,
)
from armsim_ros.model.cell import Cell
from armsim_ros.model.cell_loading import survey_cell, SurveyOptions
from armsim_ros.model.description.urdf import parse_urdf
from armsim_ros.model.description.xacro_text import read_description
from armsim_ros.model.meshes import load_mesh
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.packages import Packages
from armsim_ros.resources import find_robot, ROBOTS_FILE
from armsim_ros.sim.assembly import build_managers, build_simulation
from armsim_ros.tools.check_config.launch_file import answer_launch_file

_LAUNCH_ENDINGS = ('.launch', '.launch.xml')
_YAML_ENDINGS = ('.yaml', '.yml')


@dataclass(frozen=True)
class RobotCheck:
    """
    What was found in a robot's files.

    :param problems: errors, warnings and remarks.
    :param settings: of the robot, or of the cell; None where the files could not be found.
    :param model: None where the URDF gives none.
    :param robots: settings of the robots of a cell, as in their own files, each folder once.
    """

    problems: tuple[Problem, ...]
    settings: RobotSettings | None = None
    model: RobotModel | None = None
    robots: tuple[RobotSettings, ...] = ()

    def of(self, severity: Severity) -> list[Problem]:
        """Return the problems of a kind."""
        return [problem for problem in self.problems if problem.severity is severity]


def check_robot(robot: str, *, strict: bool = False, **options: Unpack[SurveyOptions]
                ) -> RobotCheck:
    """
    Check a robot's folder, or that of a cell and those of its robots.

    :param robot: a name under ``config/``, or a path to a folder.
    :param strict: whether what upstream silently ignores is an error.
    :param options: those of :func:`survey_cell`.
    """
    try:
        survey = survey_cell(robot, strict=strict, **options)
    except ConfigError as error:
        return RobotCheck(_sorted([*error.problems, *_files_alone(robot, options.get('config'))]))
    found = list(survey.problems)
    found += [Problem(f"no xacro of the robot declares the argument '{name}'",
                      Location(str(survey.settings.urdf_file)), ', '.join(survey.declared),
                      nearest(name, tuple(survey.declared)))
              for name, text in (options.get('arguments') or {}).items()
              if name not in survey.declared and not is_harmless(name, text)]
    for part in survey.robots or (survey.settings,):
        names = [controller.name for controller in part.controllers]
        read = [file.name for file in part.files]
        for file in launch_files(part.folder):
            # bringup reads none, so an error there stops nothing
            found += [replace(each, severity=Severity.WARNING)
                      if each.severity is Severity.ERROR else each
                      for each in _check_launch_file(file, names, read)]
    settings = survey.settings
    if survey.cell is not None:
        settings = survey.cell.settings
        found += _assemble(survey.cell)
    if strict:
        found = [strictly(problem) for problem in found]
    return RobotCheck(_sorted(found), settings, survey.model, survey.robots)


def check_file(file: Path) -> RobotCheck:
    """Check a file by itself: YAML, launch file, URDF or xacro."""
    if file.name.endswith(_YAML_ENDINGS):
        return RobotCheck(_sorted(_check_yaml_file(file)))
    if file.name.endswith(_LAUNCH_ENDINGS):
        return RobotCheck(_sorted(_check_launch_file(file, None, None)))
    if file.name.endswith(('.urdf', '.xacro')):
        return RobotCheck(_sorted(_check_urdf_file(file)))
    return RobotCheck((Problem(
        'the file is of no kind that is checked', Location(str(file)),
        ', '.join((*_YAML_ENDINGS, *_LAUNCH_ENDINGS, '.urdf', '.xacro')),
        "an SRDF is checked with its robot's folder"),))


def launch_files(folder: Path) -> list[Path]:
    """Return the ROS 1 launch files in a robot's folder and in ``launch`` inside or beside it."""
    places = (folder, folder / 'launch', folder.parent / 'launch')
    return [file for place in places if place.is_dir() for file in sorted(place.iterdir())
            if file.name.endswith(_LAUNCH_ENDINGS) and file.is_file()]


def _check_yaml_file(file: Path) -> list[Problem]:
    draft = ConfigDraft()
    try:
        if file.name == ROBOTS_FILE:
            read_cell(file)
            return []
        LayoutReader(draft).read(read_yaml_file(file), file.stem)
    except ConfigError as error:
        draft.problems.extend(error.problems)
    else:
        read_sections(draft)
    return draft.problems


def _check_launch_file(file: Path, controllers: Collection[str] | None,
                       yaml_files: Collection[str] | None) -> list[Problem]:
    try:
        return answer_launch_file(file, controllers, yaml_files)
    except ConfigError as error:
        return list(error.problems)


def _check_urdf_file(file: Path) -> list[Problem]:
    packages = Packages(near=(file.resolve(),))
    try:
        text = read_description(file, packages=packages)
        content = parse_urdf(text, str(file), read_mesh=lambda uri, scale: load_mesh(
            uri, scale, packages=packages, base=file.parent))
    except ConfigError as error:
        return list(error.problems)
    return list(content.problems)


def _files_alone(robot: str, config: Path | None) -> list[Problem]:
    """Check the YAML files of a folder that is not a robot's."""
    try:
        folder = config or find_robot(robot)
    except ArmsimError:
        return []
    if not folder.is_dir():
        return []
    return [problem for file in sorted(folder.iterdir()) if file.name.endswith(_YAML_ENDINGS)
            for problem in _check_yaml_file(file)]


def _assemble(cell: Cell) -> list[Problem]:
    """Build plant and controllers in memory and return what that finds."""
    where = Location(str(cell.settings.folder))
    try:
        simulation = build_simulation(cell.settings, cell.model)
        managers = build_managers(cell, simulation)
    except ConfigError as error:
        return list(error.problems)
    except ArmsimError as error:
        return [Problem(str(error), where)]
    refusals = [text for manager in managers.values() for text in manager.refusals]
    return [Problem(text, where, severity=Severity.WARNING)
            for text in (*refusals, *simulation.warnings)]


def _sorted(problems: Iterable[Problem]) -> tuple[Problem, ...]:
    """Return the problems by file and line; those without a place come first."""
    def key(problem: Problem) -> tuple[str, int, int]:
        where = problem.where
        return ('', 0, 0) if where is None else (where.file, where.line or 0, where.column or 0)
    return tuple(sorted(dict.fromkeys(problems), key=key))
