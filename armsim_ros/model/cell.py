# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One robot, or several in one world: each by itself, and all merged."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import ConfigError, Problem, Severity
from armsim_ros.model.robot_model import RobotModel


@dataclass(frozen=True, eq=False)
class Robot:
    """
    A robot of a cell.

    :param name: its name in the cell.
    :param settings: with the names that links, joints and groups have in the cell.
    :param model: the same; its root is its own root link.
    """

    name: str
    settings: RobotSettings
    model: RobotModel


@dataclass(frozen=True, eq=False)
class Cell:
    """
    All robots of a world; a single robot is a cell by itself.

    :param settings: of the whole; controllers have their namespace in their name. Of a single
        robot, its own.
    :param model: all robots as a single tree. Of a single robot, its own.
    :param robots: the robots, in the order of their file.
    """

    settings: RobotSettings
    model: RobotModel
    robots: tuple[Robot, ...]


@dataclass(frozen=True, eq=False)
class CellSurvey:
    """
    What was found in the files.

    :param problems: errors, warnings and remarks.
    :param settings: those of the only robot, or of the files in the cell's folder.
    :param robots: settings of the robots of a cell as in their files, each folder once; none
        for a single robot.
    :param model: of the only robot, even if there are errors; else of the cell.
    :param cell: None where there are errors.
    :param declared: arguments of the xacro of URDF and SRDF, with their values.
    """

    problems: tuple[Problem, ...]
    settings: RobotSettings
    robots: tuple[RobotSettings, ...] = ()
    model: RobotModel | None = None
    cell: Cell | None = None
    declared: Mapping[str, str] = field(default_factory=dict)

    def checked(self) -> Cell:
        """
        Return the cell.

        :raises ConfigError: with every error.
        """
        errors = errors_of(self.problems)
        if errors or self.cell is None:
            raise ConfigError(errors)
        return self.cell


def errors_of(problems: Iterable[Problem]) -> list[Problem]:
    """Return the problems that stop a program."""
    return [problem for problem in problems if problem.severity is Severity.ERROR]
