# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a robot's name or folder to its settings."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from typing_extensions import Unpack

from armsim_ros.config.base import read_settings
from armsim_ros.config.draft import ConfigDraft, empty_node, SECTIONS
from armsim_ros.config.layout import LayoutReader
from armsim_ros.config.package_files import Role
from armsim_ros.config.package_reading import (
    complete_controllers,
    PackageReader,
    PackageRoles,
    start_positions,
)
from armsim_ros.config.pipeline_defaults import OMPL
from armsim_ros.config.robot_folder import FileOptions, find_files, RobotFolder
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.sections import read_sections
from armsim_ros.config.sensors_3d import read_sensors_file, sensors_file
from armsim_ros.config.world import is_foreign_world, WorldSettings
from armsim_ros.config.yaml_node import node_of, YamlNode
from armsim_ros.config.yaml_source import parse_yaml, read_yaml_file
from armsim_ros.errors import (
    ConfigError,
    ignored,
    Location,
    nearest,
    Problem,
    ResourceError,
    Severity,
    strictly,
)
from armsim_ros.resources import check_inside, find_world, PACKAGE, share_folder


class SettingsOptions(FileOptions, total=False):
    """Keyword arguments of :func:`find_files` and :func:`survey_files`, to be passed on."""

    world: str | Path | None
    namespace: str | None
    overrides: Mapping[str, object] | None


def load_robot_settings(
    robot: str = 'sunday', *, strict: bool = False, **options: Unpack[SettingsOptions]
) -> RobotSettings:
    """
    Read everything that describes a robot, but for the URDF and SRDF themselves.

    :param robot: a name under ``config/``, or a path to a folder with the user's files.
    :param strict: whether what upstream silently ignores is an error.
    :param options: those of :func:`find_files` and :func:`survey_files`.
    :raises ConfigError: with every error of all files.
    """
    settings = survey_robot_settings(robot, **options)
    found = map(strictly, settings.remarks) if strict else settings.remarks
    errors = [problem for problem in found if problem.severity is Severity.ERROR]
    if errors:
        raise ConfigError(errors)
    return settings


def survey_robot_settings(
    robot: str = 'sunday', *, world: str | Path | None = None, namespace: str | None = None,
    overrides: Mapping[str, object] | None = None, **sources: Unpack[FileOptions],
) -> RobotSettings:
    """
    Read the same as :func:`load_robot_settings`, and continue despite errors.

    :returns: settings in which a block with errors has its defaults; the errors are among
        the remarks.
    :raises ConfigError: where the files cannot be found at all.
    """
    files = find_files(robot, **sources)
    if files.is_cell:
        raise ConfigError(Problem(
            f"'{robot}' is a cell of several robots; a single robot is needed",
            Location(str(files.urdf_file)), remedy='name the folder of one of them'))
    return survey_files(files, world=world, namespace=namespace, overrides=overrides)


def survey_files(
    files: RobotFolder, *, world: str | Path | None = None, namespace: str | None = None,
    overrides: Mapping[str, object] | None = None
) -> RobotSettings:
    """
    Read the same of files that were found already; of a cell, those that lie in its own folder.

    :param world: a name under ``worlds/`` or a file, in place of simulation.yaml's.
    :param namespace: replaces that of the files.
    :param overrides: dotted path -> value, such as ``{'simulation.paused': True}``.
    :returns: settings in which a block with errors has its defaults; the errors are among
        the remarks.
    """
    draft = ConfigDraft(problems=list(files.remarks), published=files.package is not None)
    if files.package is not None:
        variables = {**files.declared, **files.arguments}
        PackageReader(draft, files.packages, variables).read(files.package)
        complete_controllers(draft, files.folder)
    else:
        _read_files(files.yaml_files, draft)
        if files.controller_files:
            for section in ('controllers', 'controller_manager'):
                draft.sections.pop(section, None)
            draft.namespaces.clear()
            _read_files(files.controller_files, draft)
    _apply_overrides(draft, overrides or {})
    chosen = _namespace(draft, namespace)
    values = read_sections(draft)
    of_sensors = sensors_file(files.folder)
    octomap = read_sensors_file(of_sensors, draft.problems)
    if files.package is not None:
        draft.problems[:] = [_of_published(problem, files.package) for problem in draft.problems]
    world_file, world_settings = _read_world(world, values['simulation'].world, files, draft)
    if is_foreign_world(world_file) and values['planning_parameters'].scene_from_world == 'fixed':
        draft.problems.append(Problem(
            "planning knows nothing of this world: scene_from_world is 'fixed', which reads "
            "worlds in YAML only; 'live' publishes any to planning",
            Location(str(world_file), 1, 1), severity=Severity.WARNING))
    settings = RobotSettings(
        name=files.name,
        namespace=chosen,
        folder=files.folder,
        urdf_file=files.urdf_file,
        srdf_file=files.srdf_file,
        world_file=world_file,
        files=tuple(dict.fromkeys((*files.yaml_files, *files.controller_files,
                                   *([of_sensors] if of_sensors else ())))),
        arguments=dict(files.arguments),
        spawn_only=files.package is not None,
        start=start_positions(draft),
        octomap=octomap,
        world=world_settings,
        remarks=tuple(draft.problems),
        **values)
    source = empty_node().with_value({name: draft.section(name) for name in SECTIONS})
    return settings.with_source(source, files.packages)


def _of_published(problem: Problem, package: PackageRoles) -> Problem:
    """
    Return an error in a published file as a warning.

    Upstream leaves out the controller or value that it cannot read, and starts.
    """
    where = problem.where
    role = package.roles.get(Path(where.file)) if where is not None else None
    return problem if role in (None, Role.SIMULATION) else ignored(problem)


def _read_files(files: tuple[Path, ...], draft: ConfigDraft) -> None:
    reader = LayoutReader(draft)
    for file in files:
        try:
            reader.read(read_yaml_file(file, draft.problems), file.stem)
        except ConfigError as error:
            draft.problems.extend(error.problems)


def _apply_overrides(draft: ConfigDraft, overrides: Mapping[str, object]) -> None:
    for path, value in overrides.items():
        section, *keys = path.split('.')
        where = Location(f"override '{path}'")
        if section == OMPL:
            section, keys = 'pipelines', [OMPL, *keys]
        if section not in SECTIONS or not keys:
            draft.problems.append(Problem(
                f"'{section}' is not a block of settings", where, ', '.join(SECTIONS),
                nearest(section, SECTIONS)))
            continue
        node = _override_value(value, where)
        draft.override(section, keys, node)


def _override_value(value: object, where: Location) -> YamlNode:
    """Return a value; a text is read as YAML, so that '1.5' from a command line is a number."""
    if not isinstance(value, str):
        return node_of(value, where)
    try:
        parsed = parse_yaml(f'value: {value}', str(where)).get('value')
    except ConfigError:
        parsed = None
    return node_of(parsed.plain() if parsed is not None else value, where)


def _namespace(draft: ConfigDraft, given: str | None) -> str:
    """Return the namespace with its leading slash, '' for the root."""
    found = dict(draft.namespaces)
    if given is None and len(found) > 1:
        places = ', '.join(f"'{name or '/'}' at {where}" for name, where in found.items())
        draft.problems.append(Problem(
            f'the controllers are in {len(found)} namespaces: {places}',
            list(found.values())[-1], remedy='merge them, or choose with namespace:=NS'))
    name = given if given is not None else next(iter(found), '')
    name = name.strip('/')
    if name and not all(part.isidentifier() for part in name.split('/')):
        draft.problems.append(Problem(
            f"namespace '{name}' is not a ROS name", found.get(name),
            'letters, digits and _ that do not begin with a digit, separated by /'))
    return f'/{name}' if name else ''


def _read_world(given: str | Path | None, configured: str, files: RobotFolder,
                draft: ConfigDraft) -> tuple[Path | None, WorldSettings]:
    world = given or configured
    if not world:
        return None, WorldSettings()
    beside = files.folder / str(world)
    try:
        file = beside if beside.is_file() else find_world(str(world))
        if not given:
            check_inside(file, (files.folder, share_folder(PACKAGE) / 'worlds'))
        if is_foreign_world(file):
            return file, WorldSettings()
        node = read_yaml_file(file)
    except ResourceError as error:
        place = None if given else draft.section('simulation').locate(['world'])
        draft.problems.append(Problem(f'argument world: {error}' if given else str(error), place))
        return None, WorldSettings()
    except ConfigError as error:
        draft.problems.extend(error.problems)
        return None, WorldSettings()
    checked = read_settings(WorldSettings, node, draft.problems, title='world', tolerant=False)
    return file, checked or WorldSettings()
