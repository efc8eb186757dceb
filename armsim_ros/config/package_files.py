# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Which files of a MoveIt configuration package count, as MoveItConfigsBuilder decides.

The rules go by exact names and their order, never by what else lies in the folder. Where the
builder would give up, a further rule here still finds what is alone of its kind.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from pathlib import Path
import re

from armsim_ros.config.yaml_node import YamlNode
from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.errors import ConfigError, Location, Problem, ResourceError, Severity
from armsim_ros.packages import package_name, Packages

SETUP_ASSISTANT = '.setup_assistant'


@dataclass(frozen=True)
class SetupAssistant:
    """
    The entries of the file that are still used; empty where it has none.

    :param urdf_package: the package that holds the URDF.
    :param urdf_path: the URDF's path in it.
    :param xacro_args: arguments of the URDF.
    :param srdf_path: the SRDF's path in the package of the file.
    :param where: the place of the URDF's and the SRDF's entry.
    """

    urdf_package: str = ''
    urdf_path: str = ''
    xacro_args: Mapping[str, str] = field(default_factory=dict)
    srdf_path: str = ''
    where: Mapping[str, Location] = field(default_factory=dict)


def read_setup_assistant(package: Path) -> SetupAssistant:
    """Return what a package's ``.setup_assistant`` contains; empty where it cannot be read."""
    file = package / SETUP_ASSISTANT
    if not file.is_file():
        return SetupAssistant()
    try:
        root = read_yaml_file(file, []).get('moveit_setup_assistant_config')
    except ConfigError:
        return SetupAssistant()
    urdf, srdf = _block(root, 'urdf'), _block(root, 'srdf')
    places = {kind: node.place for kind, node in (('urdf', urdf), ('srdf', srdf)) if node}
    return SetupAssistant(
        _text_of(urdf, 'package'), _text_of(urdf, 'relative_path'),
        split_arguments(_text_of(urdf, 'xacro_args')), _text_of(srdf, 'relative_path'), places)


def split_arguments(text: str) -> dict[str, str]:
    """Return the arguments of a ``name:=value name:=value`` text."""
    pairs = (word.partition(':=') for word in text.split())
    return {name: value for name, sign, value in pairs if sign and name}


def _block(root: YamlNode | None, key: str) -> YamlNode | None:
    if root is None:
        return None
    return root.get(key) or root.get(key.upper())


def _text_of(node: YamlNode | None, key: str) -> str:
    inner = node.get(key) if node is not None else None
    return '' if inner is None or inner.value is None else inner.text


_URDF_ENDINGS = ('.urdf.xacro', '.urdf', '.xacro')
_SRDF_ENDINGS = ('.srdf.xacro', '.srdf')
_URDF_FOLDERS = ('config', 'urdf', 'robots', 'description', '.')
_SRDF_FOLDERS = ('config', 'srdf')
_MACRO = re.compile(r'_macro\b|\.ros2_control\.xacro$|\.gazebo\.xacro$')
_PIPELINE = '_planning.yaml'
_CONTROLLERS = '_controllers.yaml'
#: Of several files with MoveIt's controllers the first of these names; then the robot's own.
_PREFERRED = ('moveit', 'moveit2')
_NEVER_MOVEITS = ('ros2_controllers.yaml', 'fake_controllers.yaml')
MOVEIT_MANAGER = 'moveit_simple_controller_manager'


class Role(Enum):
    """What a settings file is to the stack; the value is how a message calls it."""

    KINEMATICS = 'inverse kinematics'
    JOINT_LIMITS = 'joint limits'
    INITIAL_POSITIONS = 'start'
    CARTESIAN_LIMITS = 'Cartesian limits'
    SENSORS = 'sensors, which build an octomap'
    MOVEIT_CPP = 'MoveItCpp clients'
    TRAJECTORY_EXECUTION = 'trajectory execution'
    PIPELINE = 'planning pipeline'
    MOVEIT_CONTROLLERS = 'controllers of move_group'
    ROS2_CONTROLLERS = 'controllers of ros2_control'
    SIMULATION = 'simulation'


#: Files that count under their exact name.
BY_NAME: Mapping[str, Role] = {
    'kinematics.yaml': Role.KINEMATICS,
    'joint_limits.yaml': Role.JOINT_LIMITS,
    'initial_positions.yaml': Role.INITIAL_POSITIONS,
    'pilz_cartesian_limits.yaml': Role.CARTESIAN_LIMITS,
    'sensors_3d.yaml': Role.SENSORS,
    'moveit_cpp.yaml': Role.MOVEIT_CPP,
    'trajectory_execution.yaml': Role.TRAJECTORY_EXECUTION,
    'simulation.yaml': Role.SIMULATION,
}
_DEPRECATED_LIMITS = 'cartesian_limits.yaml'


def pipeline_of(file: Path) -> str:
    """Return the name of the planning pipeline that a file is of."""
    return file.name.removesuffix(_PIPELINE)


@dataclass
class PackageFiles:
    """
    The files of a MoveIt configuration package.

    :param folder: the package.
    :param packages: where other packages are searched.
    :param name: the robot's name; where it is empty, taken from the package.
    :param config: a folder that is searched before ``config/``.
    :param problems: what was odd in choosing the files.
    """

    folder: Path
    packages: Packages
    name: str = ''
    config: Path | None = None
    problems: list[Problem] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Find out the robot's name."""
        self.name = self.name or self._own_name()

    @cached_property
    def assistant(self) -> SetupAssistant:
        """What the setup assistant left."""
        return read_setup_assistant(self.folder)

    @property
    def config_folders(self) -> tuple[Path, ...]:
        """Folders that are searched for settings, in this order."""
        own = self.folder / 'config'
        return (own,) if self.config is None else (self.config, own)

    def settings_file(self, name: str) -> Path | None:
        """Return the settings file of an exact name, None where there is none."""
        return next((folder / name for folder in self.config_folders
                     if (folder / name).is_file()), None)

    def settings_files(self) -> list[Path]:
        """Return all YAML files of the settings folders, the first of each name."""
        found: dict[str, Path] = {}
        for folder in self.config_folders:
            for file in sorted(folder.iterdir()) if folder.is_dir() else ():
                if file.is_file() and file.suffix in ('.yaml', '.yml') and file.name[0] != '.':
                    found.setdefault(file.name, file)
        return list(found.values())

    # descriptions -----------------------------------------------------------------------------

    def urdf(self) -> Path | None:
        """Return the robot's URDF or xacro, None where no rule finds it."""
        own = self.folder / 'config' / f'{self.name}.urdf.xacro'
        if own.is_file():
            return own
        return self._assistants_urdf() or self._first(
            [self.folder / 'config' / f'{self.name}.urdf']) or self._only(
                _URDF_FOLDERS, _URDF_ENDINGS)

    def srdf(self) -> Path | None:
        """Return the SRDF, None where no rule finds it."""
        named = self.assistant.srdf_path
        if named:
            file = self.folder / named
            twin = file.with_suffix('') if file.suffix == '.xacro' else file.with_name(
                f'{file.name}.xacro')
            found = self._first([file, twin])
            if found is not None:
                return found
            self._warn(f"the SRDF '{named}' does not exist", self.assistant.where.get('srdf'))
        own = [folder / f'{self.name}{ending}' for folder in self.config_folders
               for ending in ('.srdf', '.srdf.xacro')]
        return self._first(own) or self._only(_SRDF_FOLDERS, _SRDF_ENDINGS)

    # settings ---------------------------------------------------------------------------------

    def pipelines(self) -> dict[str, Path]:
        """Return planning pipeline -> its file."""
        return {pipeline_of(file): file for file in self.settings_files()
                if file.name.endswith(_PIPELINE)}

    def cartesian_limits(self) -> Path | None:
        """Return the file with the tool's limits; the deprecated name gives a warning."""
        found = self.settings_file('pilz_cartesian_limits.yaml')
        old = self.settings_file(_DEPRECATED_LIMITS)
        if old is not None:
            self._warn('the name is deprecated' + (
                ' and the file is not read: there is pilz_cartesian_limits.yaml' if found else ''),
                Location(str(old)), 'rename it to pilz_cartesian_limits.yaml')
        return found or old

    def moveit_controllers(self) -> Path | None:
        """Return the file with the controllers that move_group sends trajectories to."""
        named = [file for file in self.settings_files() if file.name.endswith(_CONTROLLERS)
                 and file.name not in _NEVER_MOVEITS]
        for word in (*_PREFERRED, self.name):
            for file in named:
                if file.name == f'{word}{_CONTROLLERS}':
                    return file
        marks = (MOVEIT_MANAGER, 'controller_names', 'controller_list')
        by_content = [file for file in self.settings_files()
                      if 'controllers' in file.name and file.name not in _NEVER_MOVEITS
                      and any(mark in _text(file) for mark in marks)]
        for candidates in (named, by_content):
            if len(candidates) == 1 and candidates[0] in by_content:
                return candidates[0]
        if len(by_content) > 1:
            others = ', '.join(file.name for file in by_content[1:])
            self._warn(f'the controllers of move_group are read from here; {others} could be '
                       'meant as well', Location(str(by_content[0])),
                       'call the right file moveit_controllers.yaml')
        return next(iter(by_content), None)

    def ros2_controllers(self) -> Path | None:
        """Return the file with ros2_control's controllers, None where no rule finds it."""
        found = self.settings_file('ros2_controllers.yaml')
        if found is not None:
            return found
        with_manager = [file for file in self.settings_files()
                        if re.search(r'^[ ]*[\w/*]*controller_manager\s*:', _text(file), re.M)
                        and 'ros__parameters' in _text(file)]
        return next(iter(with_manager), None)

    def by_role(self) -> dict[Path, Role]:
        """Return the settings files that count, but those of controllers and pipelines."""
        found = {file: BY_NAME[file.name] for file in self.settings_files()
                 if file.name in BY_NAME}
        limits = self.cartesian_limits()
        if limits is not None:
            found[limits] = Role.CARTESIAN_LIMITS
        return found

    # ------------------------------------------------------------------------------------------

    def _own_name(self) -> str:
        """Return the first name that a ``config/NAME.urdf.xacro`` bears out."""
        package = (package_name(self.folder) or self.folder.name).removesuffix('_moveit_config')
        folder = self.folder.name.removesuffix('_moveit_config')
        names = [folder, _stem(self.assistant.srdf_path), _stem(self.assistant.urdf_path),
                 package]
        for name in names:
            if name and (self.folder / 'config' / f'{name}.urdf.xacro').is_file():
                return name
        only = [_stem(file.name) for file in self._with_endings(('config',), ('.urdf.xacro',))]
        return only[0] if len(only) == 1 else next(filter(None, names[1:3]), folder)

    def _assistants_urdf(self) -> Path | None:
        assistant, where = self.assistant, self.assistant.where.get('urdf')
        if not assistant.urdf_path:
            return None
        try:
            package = (self.packages.folder(assistant.urdf_package) if assistant.urdf_package
                       else self.folder)
        except ResourceError as error:
            self._warn(str(error), where)
            return None
        file = package / assistant.urdf_path
        if not file.is_file():
            self._warn(f"the URDF '{file}' does not exist", where)
            return None
        return file

    def _only(self, folders: Iterable[str], endings: tuple[str, ...]) -> Path | None:
        """Return the file that is alone of its kind, in the first folder that has any."""
        for folder in folders:
            found = self._with_endings((folder,), endings)
            stems = {_stem(file.name) for file in found}
            if len(stems) == 1:
                return found[0]
            if found:
                exact = [file for file in found if _stem(file.name) == self.name]
                return exact[0] if exact else None
        return None

    def _with_endings(self, folders: Iterable[str], endings: tuple[str, ...]) -> list[Path]:
        files = [file for folder in folders if (self.folder / folder).is_dir()
                 for file in (self.folder / folder).iterdir() if file.is_file()
                 and file.name.endswith(_SRDF_ENDINGS) == (endings == _SRDF_ENDINGS)]
        rank = {ending: number for number, ending in enumerate(endings)}
        found = [(min(rank[ending] for ending in endings if file.name.endswith(ending)), file)
                 for file in files if file.name.endswith(endings)
                 and not _MACRO.search(file.name)]
        return [file for _, file in sorted(found)]

    def _first(self, files: Iterable[Path]) -> Path | None:
        return next((file for file in files if file.is_file()), None)

    def _warn(self, what: str, where: Location | None, remedy: str = '') -> None:
        self.problems.append(Problem(what, where or Location(str(self.folder / SETUP_ASSISTANT)),
                                     '', remedy, Severity.WARNING))


def _stem(path: str) -> str:
    name = path.rpartition('/')[2]
    for ending in (*_URDF_ENDINGS, *_SRDF_ENDINGS):
        if name.endswith(ending):
            return name.removesuffix(ending)
    return name


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding='utf-8', errors='replace')
    except OSError:
        return ''
