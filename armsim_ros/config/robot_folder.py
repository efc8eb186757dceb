# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which files of a folder describe the robot."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from armsim_ros.config.cell import robots_file
from armsim_ros.errors import ConfigError, Location, Problem, ResourceError, Severity
from armsim_ros.resources import find_robot, PACKAGE, share_folder

MOST_FILES = 100

_YAML_ENDINGS = ('.yaml', '.yml')
_URDF_ENDINGS = ('.urdf.xacro', '.xacro', '.urdf')
_SUBFOLDERS = ('', 'config', 'urdf', 'robots', 'srdf', 'description')

#: Files of other programs, by the start of their name -> whose they are.
_OTHER_FILES = {
    'chomp_planning': 'of the CHOMP planner',
    'stomp_planning': 'of the STOMP planner',
    'lerp_planning': 'of the lerp planner',
    'trajopt_planning': 'of the TrajOpt planner',
    'pilz_industrial_motion_planner': 'of the Pilz planner, which needs none',
    'sensors_3d': 'of sensors, which build an octomap',
    'servo': 'of MoveIt Servo',
    'fake_controllers': 'of fake controllers',
    'moveit_cpp': 'of MoveItCpp clients',
}


@dataclass(frozen=True)
class RobotFolder:
    """
    The files of one robot.

    :param name: the folder's name, the robot's name.
    :param urdf_file: of a cell, the file with its robots.
    :param yaml_files: settings to read, in the order of their names.
    :param remarks: files that are left out.
    :param is_cell: whether the folder is that of a cell with robots of their own folders.
    """

    name: str
    folder: Path
    urdf_file: Path
    srdf_file: Path | None
    yaml_files: tuple[Path, ...]
    remarks: tuple[Problem, ...] = ()
    is_cell: bool = False


def find_files(robot: str, *, config: Path | None = None, urdf: Path | None = None,
               srdf: Path | None = None) -> RobotFolder:
    """
    Find a robot's files.

    :param robot: a name under ``config/``, or a path to a folder.
    :param config: another folder for the YAML files.
    :param urdf: another URDF or xacro file.
    :param srdf: another SRDF file.
    :raises ConfigError: where a file is missing, or where several could be meant.
    """
    try:
        folder = find_robot(robot)
    except ResourceError as error:
        raise ConfigError(Problem(str(error))) from None
    if not folder.is_dir():
        raise ConfigError(Problem(f"robot '{folder}' is a file", allowed='a folder with the '
                                  "robot's files", remedy='name a single URDF with urdf:=FILE'))
    name = folder.resolve().name
    if name == 'config':
        name = folder.resolve().parent.name
    name = name.removesuffix('_moveit_config')
    settings_folder = config if config is not None else folder
    if not settings_folder.is_dir():
        raise ConfigError(Problem(f"config '{settings_folder}' is no folder"))
    yaml_files, remarks = _yaml_files(settings_folder)
    srdf_file = _optional_srdf(srdf, name, folder, settings_folder)
    robots = robots_file(folder) if urdf is None else None
    if robots is not None:
        others = tuple(file for file in yaml_files if file != robots)
        return RobotFolder(name, settings_folder, robots, srdf_file, others, remarks, True)
    urdf_file = _one_file(
        urdf, 'urdf', name, _candidates(folder, _URDF_ENDINGS)
        or _candidates(settings_folder, _URDF_ENDINGS) or _own_urdf(name), folder)
    return RobotFolder(name, settings_folder, urdf_file, srdf_file, yaml_files, remarks)


def _yaml_files(folder: Path) -> tuple[tuple[Path, ...], tuple[Problem, ...]]:
    found: list[Path] = []
    remarks: list[Problem] = []
    for file in _candidates(folder, _YAML_ENDINGS, ('', 'config')):
        owner = next((whose for start, whose in _OTHER_FILES.items()
                      if file.name.startswith(start)), None)
        if owner is None:
            found.append(file)
        else:
            remarks.append(Problem(f'the file is {owner} and not used here', Location(str(file)),
                                   severity=Severity.INFO))
    if len(found) > MOST_FILES:
        raise ConfigError(Problem(
            f'{len(found)} YAML files', Location(str(folder)), f'at most {MOST_FILES}',
            "is this the robot's folder?"))
    return tuple(found), tuple(remarks)


def _candidates(folder: Path, endings: Iterable[str],
                subfolders: tuple[str, ...] = _SUBFOLDERS) -> list[Path]:
    places = dict.fromkeys(folder / sub for sub in subfolders)
    files = [file for place in places if place.is_dir() for file in sorted(place.iterdir())
             if file.is_file() and not file.name.startswith('.')]
    return [file for file in files if file.name.endswith(tuple(endings))]


def _own_urdf(name: str) -> list[Path]:
    place = share_folder(PACKAGE) / 'urdf'
    return [place / f'{name}{ending}' for ending in _URDF_ENDINGS
            if (place / f'{name}{ending}').is_file()]


def _one_file(given: Path | None, kind: str, name: str, found: list[Path],
              folder: Path) -> Path:
    if given is not None:
        if not given.is_file():
            raise ConfigError(Problem(f"{kind} '{given}' is no file"))
        return given
    named = [file for file in found if file.name.split('.')[0] in (name, f'{name}_robot')]
    chosen = named[:1] or found
    if len(chosen) == 1:
        return chosen[0]
    if not chosen:
        raise ConfigError(Problem(
            f"no {kind.upper()} of robot '{name}'", Location(str(folder)),
            remedy=f'put {name}.{kind} there, or name the file with {kind}:=FILE'))
    raise ConfigError(Problem(
        f'several {kind.upper()} files and none is called {name}.{kind}', Location(str(folder)),
        ', '.join(file.name for file in chosen), f'choose one with {kind}:=FILE'))


def _optional_srdf(given: Path | None, name: str, folder: Path,
                   settings_folder: Path) -> Path | None:
    found = _candidates(settings_folder, ('.srdf', '.srdf.xacro')) or _candidates(
        folder, ('.srdf', '.srdf.xacro'))
    if given is None and not found:
        return None
    return _one_file(given, 'srdf', name, found, folder)
