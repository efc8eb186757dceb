# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which files of a folder describe the robot."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import redirect_stderr
from dataclasses import dataclass, field
from io import StringIO
import os
from pathlib import Path
import re
from typing import TypedDict

from armsim_ros.config.cell import robots_file
from armsim_ros.config.package_files import PackageFiles
from armsim_ros.config.package_reading import PackageRoles
from armsim_ros.config.sensors_3d import FILE as SENSORS_FILE
from armsim_ros.errors import ConfigError, Location, Problem, ResourceError, Severity
from armsim_ros.install_rules.xacro_run import xacro_finding
from armsim_ros.packages import depends_on, MANIFEST, package_name, Packages, packages_below
from armsim_ros.resources import find_robot, PACKAGE, share_folder

MOST_FILES = 100

_YAML_ENDINGS = ('.yaml', '.yml')
_URDF_ENDINGS = ('.urdf.xacro', '.xacro', '.urdf')
_SUBFOLDERS = ('', 'config', 'urdf', 'robots', 'srdf', 'description')

#: Files of other programs, by the start of their name -> whose they are.
_OTHER_FILES = {
    'lerp_planning': 'of the lerp planner',
    'trajopt_planning': 'of the TrajOpt planner',
    'fake_controllers': 'of fake controllers',
    'moveit_cpp': 'of MoveItCpp clients',
}


@dataclass(frozen=True)
class RobotFolder:
    """
    The files of a robot.

    :param name: the folder's name, the robot's name.
    :param urdf_file: of a cell, the file with its robots.
    :param yaml_files: settings to read, in the order of their names.
    :param remarks: files that are left out.
    :param is_cell: whether the folder is that of a cell with robots of their own folders.
    :param packages: where packages are searched.
    :param arguments: arguments of the URDF's and the SRDF's xacro.
    :param declared: arguments that the URDF's xacro declares, with their values, where it was
        run already.
    :param package: which of the files means what, where the folder is a package.
    :param controller_files: named by the user; of a folder that is not a package, their settings
        replaces the controllers of ``yaml_files``.
    """

    name: str
    folder: Path
    urdf_file: Path
    srdf_file: Path | None
    yaml_files: tuple[Path, ...]
    remarks: tuple[Problem, ...] = ()
    is_cell: bool = False
    packages: Packages = field(default_factory=Packages)
    arguments: Mapping[str, str] = field(default_factory=dict)
    declared: Mapping[str, str] = field(default_factory=dict)
    package: PackageRoles | None = None
    controller_files: tuple[Path, ...] = ()


class FileOptions(TypedDict, total=False):
    """Keyword arguments of :func:`find_files`, for those that pass them on."""

    config: Path | None
    urdf: Path | None
    srdf: Path | None
    controllers: Sequence[Path]
    arguments: Mapping[str, str] | None
    packages_path: Iterable[Path]


def find_files(robot: str, *, config: Path | None = None, urdf: Path | None = None,
               srdf: Path | None = None, controllers: Sequence[Path] = (),
               arguments: Mapping[str, str] | None = None,
               packages_path: Iterable[Path] = ()) -> RobotFolder:
    """
    Find a robot's files.

    :param robot: a name under ``config/``, a path to a folder, or the name of a package.
    :param config: another folder for the YAML files; of a package, a folder searched first.
    :param urdf: another URDF or xacro file.
    :param srdf: another SRDF file.
    :param controllers: other files with the controllers of ros2_control.
    :param arguments: arguments for the xacro of URDF and SRDF.
    :param packages_path: folders that are searched first for packages.
    :raises ConfigError: where a file is missing, or where several could be meant.
    """
    packages = Packages(packages_path)
    folder = robot_folder(robot, packages)
    if not folder.is_dir():
        raise ConfigError(Problem(f"robot '{folder}' is a file", allowed='a folder with the '
                                  "robot's files", remedy='name a single URDF with urdf:=FILE'))
    if config is not None and not config.is_dir():
        raise ConfigError(Problem(f"config '{config}' is not a folder"))
    named = [path for path in (urdf, srdf, *controllers) if path is not None]
    for kind, file in (('urdf', urdf), ('srdf', srdf), *(('controllers', path)
                                                         for path in controllers)):
        if file is not None and not file.is_file():
            raise ConfigError(Problem(f"{kind} '{file}' is not a file"))
    packages = packages.beside(*named, folder)
    own = packages.installed(folder.resolve())
    package = _moveit_package(own, packages, named=bool(urdf or srdf))
    if package is not None and robots_file(folder) is None:
        found = PackageFiles(package, packages.beside(package), config=config)
        if package != own:
            found.problems.append(Problem(
                f"the MoveIt package of '{folder.name}' is '{package}'", Location(str(package)),
                severity=Severity.INFO))
        return _of_package(found, urdf, srdf, tuple(controllers), arguments or {})
    name = folder.resolve().name
    if name == 'config':
        name = folder.resolve().parent.name
    name = name.removesuffix('_moveit_config')
    settings_folder = config if config is not None else folder
    yaml_files, remarks = _yaml_files(settings_folder)
    srdf_file = _optional_srdf(srdf, name, folder, settings_folder)
    yaml_files = tuple(file for file in yaml_files if file not in controllers)
    robots = robots_file(folder) if urdf is None else None
    if robots is not None:
        others = tuple(file for file in yaml_files if file != robots)
        return RobotFolder(name, settings_folder, robots, srdf_file, others, remarks, True,
                           packages, arguments or {}, controller_files=tuple(controllers))
    urdf_file = _one_file(
        urdf, 'urdf', name, _candidates(folder, _URDF_ENDINGS)
        or _candidates(settings_folder, _URDF_ENDINGS) or _own_urdf(name), folder)
    return RobotFolder(name, settings_folder, urdf_file, srdf_file, yaml_files, remarks, False,
                       packages, arguments or {}, controller_files=tuple(controllers))


def robot_folder(robot: str, packages: Packages) -> Path:
    """
    Return the folder of a robot by its name, its path, or the name of its package.

    :raises ConfigError: there is none.
    """
    try:
        return find_robot(robot)
    except ResourceError as error:
        package = packages.find(robot) if robot and '/' not in robot else None
        if package is None:
            raise ConfigError(Problem(str(error))) from None
        return package


def _moveit_package(folder: Path, packages: Packages, *, named: bool) -> Path | None:
    """
    Return the package that a folder represents, None for a folder of the user's own files.

    A package with an SRDF is itself; a description or bringup package represents the MoveIt
    package that depends on it; a folder of packages for the only MoveIt package in it.

    :param named: whether the user names URDF or SRDF, and so needs no other package.
    :raises ConfigError: where several could be meant.
    """
    own = (folder / MANIFEST).is_file()
    if own and (named or PackageFiles(folder, packages).srdf() is not None):
        return folder
    if own:
        name = package_name(folder) or folder.name
        found = {package: place for package, place in packages.names().items()
                 if place != folder and depends_on(place, name)
                 and PackageFiles(place, packages).srdf() is not None}
    elif _candidates(folder, (*_URDF_ENDINGS, *_YAML_ENDINGS)):
        return None
    else:
        found = {package: place for package, place in packages_below(folder).items()
                 if PackageFiles(place, packages).srdf() is not None}
    if len(found) > 1:
        raise ConfigError(Problem(
            f"{len(found)} MoveIt packages could be meant by '{folder}'",
            Location(str(folder)), ', '.join(sorted(found)),
            'name one of them: robot:=NAME packages_path:=' + str(folder)))
    for place in found.values():
        return packages.installed(place)
    return folder if own else None


def _of_package(found: PackageFiles, urdf: Path | None, srdf: Path | None,
                controllers: tuple[Path, ...], arguments: Mapping[str, str]) -> RobotFolder:
    """Return the files of a MoveIt configuration package, or of a similar package."""
    urdf_file = urdf or found.urdf()
    if urdf_file is None:
        raise ConfigError([*(problem for problem in found.problems), Problem(
            f"package '{found.folder.name}' has no URDF that its files name", Location(
                str((found.folder / MANIFEST).resolve().parent)), remedy=urdf_remedy(found))])
    roles = PackageRoles.of(found, controllers)
    return RobotFolder(
        found.name, found.folder, urdf_file, srdf or found.srdf(), roles.files,
        (*found.problems, *roles.remarks), False, found.packages,
        {**({} if urdf is not None else found.assistant.xacro_args), **arguments}, {}, roles)


def _yaml_files(folder: Path) -> tuple[tuple[Path, ...], tuple[Problem, ...]]:
    found: list[Path] = []
    remarks: list[Problem] = []
    for file in _candidates(folder, _YAML_ENDINGS, ('', 'config')):
        if file.name == SENSORS_FILE:
            continue
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


#: So many descriptions are tried, and so many of each kind are named at most.
MOST_TRIED, MOST_NAMED = 40, 5
_ENDINGS = ('.urdf', '.urdf.xacro', '.xacro')
_FOLDERS = ('urdf', 'robots', 'robot', 'description', 'config', 'xacro', '.')
_PART = re.compile(r'_macro\b|ros2_control|gazebo|\.srdf')
_LAUNCH = ('.launch.py', '_launch.py', '.launch.xml', '.launch.yaml')
_NEEDED = re.compile(r'<(?:joint|link)\s[^>]*?name="([^"$]+)"')
_REFERRED = re.compile(r'\b(?:base_link|tip_link|link1|link2)="([^"$]+)"')
_GIVEN = re.compile(r'<(?:joint|link)\s[^>]*?name="([^"]+)"')
_STATES = re.compile(r'<group_state.*?</group_state>', re.DOTALL)


def urdf_remedy(files: PackageFiles) -> str:
    """Return what a user can do about a package without URDF."""
    lines = ['name it: urdf:=FILE, with the arguments that its xacro declares']
    fitting = list(_fitting(files))
    if fitting:
        lines.append('the workspace has for this SRDF: '
                     + ', '.join(f'urdf:={file}' for file in fitting[:MOST_NAMED]))
    launch_files = sorted((file.name for file in (files.folder / 'launch').glob('*')
                           if file.name.endswith(_LAUNCH)),
                          key=lambda name: (name.startswith('_'), name))
    if launch_files:
        name = package_name(files.folder) or files.folder.name
        named = ', '.join(launch_files[1:MOST_NAMED])
        lines.append(f'or run a launch file of the package: armsim launch {name} '
                     f'{launch_files[0]}' + (f' (also {named})' if named else ''))
    return '; '.join(lines)


def _fitting(files: PackageFiles) -> Iterator[Path]:
    """Yield the descriptions of the workspace that have all joints and links of the SRDF."""
    srdf = files.srdf()
    text = _STATES.sub('', _text(srdf, files.packages)) if srdf is not None else ''
    needed = {*_NEEDED.findall(text), *_REFERRED.findall(text)}
    if not needed:
        return
    for number, file in enumerate(_descriptions(files)):
        if number == MOST_TRIED:
            return
        if needed <= set(_GIVEN.findall(_text(file, files.packages))):
            yield file


def _descriptions(files: PackageFiles) -> Iterator[Path]:
    home = (files.folder / MANIFEST).resolve()
    packages = files.packages.names().values()
    for package in sorted(packages, key=lambda place: -len(os.path.commonpath((home, place)))):
        for folder in _FOLDERS:
            yield from (file for file in sorted((package / folder).glob('*'))
                        if file.name.endswith(_ENDINGS) and not _PART.search(file.name))


def _text(file: Path, packages: Packages) -> str:
    """Return a description, after xacro; '' where it cannot be read without arguments."""
    if file.suffix != '.xacro':
        try:
            return file.read_text(encoding='utf-8', errors='replace')
        except OSError:
            return ''
    with xacro_finding(packages.folder) as xacro, redirect_stderr(StringIO()):
        try:
            return str(xacro.process_file(str(file), mappings={}, verbosity=0).toxml())
        except Exception:  # noqa: BLE001 - any error of the expressions in the file
            return ''
