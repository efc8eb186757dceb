# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The robots of a cell, and their poses (``robots.yaml``)."""

from __future__ import annotations

from pathlib import Path
import re

from pydantic import field_validator, model_validator
from typing_extensions import Self

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.simulation import finite_triple, Triple
from armsim_ros.config.validation import read_settings
from armsim_ros.config.yaml.node import YamlNode
from armsim_ros.config.yaml.source import read_yaml_file
from armsim_ros.errors import ConfigError, Problem
from armsim_ros.resources import ROBOTS_FILE

_WORD = re.compile(r'[A-Za-z][A-Za-z0-9_]*')


class CellRobot(Settings):
    """A robot of a cell; what is not given follows from its name or its own files."""

    robot: str = parameter(
        ..., "the robot's folder, from the cell's folder; or a name under config/", min_length=1
    )
    xyz: Triple | None = parameter(
        None, 'position of its root link [m]; by default from its simulation.yaml'
    )
    rpy: Triple | None = parameter(
        None, 'roll, pitch, yaw of its root link [rad]; by default from its simulation.yaml'
    )
    prefix: str | None = parameter(
        None, "precedes its links, joints and planning groups; not given: its name and '_'"
    )
    namespace: str | None = parameter(
        None, "of its controllers and joint states, '' is the root; not given: its name"
    )

    @field_validator('xyz', 'rpy')
    @classmethod
    def _finite(cls, value: Triple | None) -> Triple | None:
        return None if value is None else finite_triple(value)

    @field_validator('prefix')
    @classmethod
    def _word(cls, value: str | None) -> str | None:
        if value and not _WORD.fullmatch(value):
            raise ValueError(f"'{value}' cannot begin a name; allowed: letters, digits and _")
        return value

    @field_validator('namespace')
    @classmethod
    def _ros_name(cls, value: str | None) -> str | None:
        name = (value or '').strip('/')
        if name and not all(_WORD.fullmatch(part) for part in name.split('/')):
            raise ValueError(
                f"'{value}' is not a ROS name; allowed: letters, digits and _ that begin with a "
                'letter, parted by /'
            )
        return None if value is None else name


class CellSettings(Settings):
    """The robots of a cell."""

    robots: dict[str, CellRobot] = parameter(
        ..., 'name -> a robot, its place, prefix and namespace'
    )

    @model_validator(mode='after')
    def _told_apart(self) -> Self:
        if not self.robots:
            raise ValueError("'robots' is empty; allowed: at least one robot")
        seen: dict[str, str] = {}
        for name in self.robots:
            if not _WORD.fullmatch(name):
                raise ValueError(
                    f"robots: '{name}' is not a name for a robot; allowed: letters, digits and _ "
                    'that begin with a letter'
                )
            namespace = self.namespace(name)
            if namespace in seen:
                raise ValueError(
                    f"robots: '{name}' and '{seen[namespace]}' are both in namespace "
                    f"'/{namespace}'; allowed: a namespace per robot, 'namespace: ...' chooses it"
                )
            seen[namespace] = name
        return self

    def prefix(self, name: str) -> str:
        """Return what precedes the names of a robot's links, joints and planning groups."""
        given = self.robots[name].prefix
        return f'{name}_' if given is None else given

    def namespace(self, name: str) -> str:
        """Return the namespace of a robot without slashes at its ends."""
        given = self.robots[name].namespace
        return name if given is None else given


def robots_file(folder: Path) -> Path | None:
    """Return the file that makes a folder a cell, None where it is a robot's folder."""
    places = (folder / ROBOTS_FILE, folder / 'config' / ROBOTS_FILE)
    return next((file for file in places if file.is_file()), None)


def read_cell(file: Path) -> tuple[CellSettings, YamlNode]:
    """
    Read the robots of a cell.

    :returns: the settings, and the file's nodes, which know the places.
    :raises ConfigError: with every error.
    """
    problems: list[Problem] = []
    node = read_yaml_file(file)
    cell = read_settings(CellSettings, node, problems, title='cell', tolerant=False)
    if cell is None:
        raise ConfigError(problems)
    return cell, node
