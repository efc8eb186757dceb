# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a folder to a robot, or to the several robots of a cell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from typing_extensions import Unpack

from armsim_ros.config.cell import CellRobot, merged_settings, read_cell
from armsim_ros.config.loading import survey_files, survey_robot_settings
from armsim_ros.config.prefix import prefixed_settings
from armsim_ros.config.robot_folder import FileOptions, find_files, RobotFolder
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.simulation import PlacementSettings
from armsim_ros.errors import (
    ConfigError,
    Location,
    nearest,
    Problem,
    ResourceError,
    Severity,
    SimulationError,
    strictly,
)
from armsim_ros.model.cell import (
    Cell,
    CellSurvey,
    clashes,
    errors_of,
    merged_model,
    PlacedRobot,
    prefixed_model,
    Robot,
)
from armsim_ros.model.cross_check import check_settings, fitting_controllers
from armsim_ros.model.description.ros2_control import plugin_parameters
from armsim_ros.model.description.xacro_text import describe, Description, read_description
from armsim_ros.model.loading import survey_robot_model
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.transforms import inverse_pose, pose_matrix, rpy_from_matrix
from armsim_ros.model.world_objects import (
    initial_positions,
    START_KEYS,
    with_default_floor,
    with_hardware_start,
)
from armsim_ros.resources import check_inside, PACKAGE, robot_names, share_folder


def load_cell(
    robot: str = 'sunday', *, world: str | Path | None = None,
    overrides: Mapping[str, object] | None = None
) -> Cell:
    """
    Read a robot, or a cell with several.

    :param robot: a name under ``config/``, or a path to a folder.
    :param world: a name under ``worlds/`` or a file, in place of simulation.yaml's.
    :param overrides: dotted path -> value; of a cell, over the files of its own folder.
    :raises ConfigError: with every error of all files.
    """
    return survey_cell(robot, world=world, overrides=overrides).checked()


class SurveyOptions(FileOptions, total=False):
    """Keyword arguments of :func:`survey_cell`, for those that pass them on."""

    world: str | Path | None
    namespace: str | None
    overrides: Mapping[str, object] | None


def survey_cell(
    robot: str = 'sunday', *, world: str | Path | None = None, namespace: str | None = None,
    overrides: Mapping[str, object] | None = None, strict: bool = False,
    **sources: Unpack[FileOptions]
) -> CellSurvey:
    """
    Read the same as :func:`load_cell`, and continue despite errors.

    :param namespace: replaces the namespace from the files of a single robot.
    :param strict: whether what upstream silently ignores is an error.
    :param sources: those of :func:`find_files`.
    :raises ConfigError: where the files cannot be found at all, or robots.yaml has errors.
    """
    files = find_files(robot, **sources)
    if files.is_cell and namespace is not None:
        raise ConfigError(Problem(
            f"namespace '{namespace}' is given for a cell of several robots",
            Location(str(files.urdf_file)), remedy="give each robot its 'namespace' there"))
    descriptions = (None, None) if files.is_cell else _describe(files)
    if descriptions[0] is not None:
        files = with_plugin_files(files, descriptions[0], keep=bool(sources.get('controllers')))
    settings = survey_files(files, world=world, namespace=namespace, overrides=overrides)
    if files.is_cell:
        return _CellReader(files, settings).read()
    found = [strictly(remark) if strict else remark for remark in settings.remarks]
    faulty = bool(errors_of(found))
    model, of_model = survey_robot_model(
        settings, partial=faulty, urdf=descriptions[0], srdf=descriptions[1])
    found += of_model
    declared = {name: value for description in reversed(descriptions) if description is not None
                for name, value in description.arguments.items()}
    cell = None
    if model is not None and not errors_of(found):
        if files.package is not None:
            settings = settings.model_copy(update={'spawn': fitting_controllers(settings, model)})
        if files.package is not None and not model.hardware:
            settings = _at_full_speed(settings, found)
        try:
            settings, of_start = with_hardware_start(settings, model)
            settings, of_floor = with_default_floor(settings, model)
            found += [*of_start, *of_floor]
        except SimulationError:
            pass  # an unknown state, which is reported at the start of the robot
        cell = Cell(settings, model, (Robot(settings.name, settings, model),))
    return CellSurvey(tuple(found), settings, (), model, cell, declared)


def _at_full_speed(settings: RobotSettings, problems: list[Problem]) -> RobotSettings:
    """Return settings whose controllers ask no hardware for a speed that none declares."""
    controllers = []
    for controller in settings.controllers:
        scaling = getattr(controller.parameters, 'speed_scaling', None)
        if scaling is not None and (scaling.state_interface or scaling.command_interface):
            quiet = scaling.model_copy(update={'state_interface': '', 'command_interface': ''})
            controller = controller.model_copy(update={
                'parameters': controller.parameters.model_copy(update={'speed_scaling': quiet})})
            problems.append(Problem(
                f"controller '{controller.name}' runs at full speed: the URDF declares no "
                f"hardware with '{scaling.state_interface or scaling.command_interface}'",
                settings.locate('controllers', controller.name), severity=Severity.CHANGED))
        controllers.append(controller)
    return settings.model_copy(update={'controllers': tuple(controllers)})


def _describe(files: RobotFolder) -> tuple[Description | None, Description | None]:
    """Return URDF and SRDF after xacro; None if unreadable, which is reported later."""
    found = []
    for file in (files.urdf_file, files.srdf_file):
        try:
            found.append(None if file is None else describe(
                file, mappings=files.arguments, packages=files.packages.beside(file.resolve())))
        except (ConfigError, ResourceError):
            found.append(None)
    return found[0], found[1]


def with_plugin_files(files: RobotFolder, urdf: Description, *, keep: bool = False) -> RobotFolder:
    """
    Return a package's files with the content of its URDF: arguments, and the controllers' files.

    :param keep: whether the user named the controllers' files, which then stay.
    """
    files = replace(files, declared=urdf.arguments)
    if files.package is None or keep:
        return files
    named = [Path(text) for text in plugin_parameters(urdf.text)]
    missing = [file for file in named if not file.is_file()]
    remarks = tuple(Problem(
        f"the URDF's plugin names the controllers' file '{file}', which is not there",
        Location(str(files.urdf_file)), severity=Severity.WARNING) for file in missing)
    present = [file for file in named if file.is_file()]
    package = files.package.with_controllers(present) if present else files.package
    own = tuple(remark for remark in files.remarks if remark not in files.package.remarks)
    return replace(files, package=package, yaml_files=package.files,
                   remarks=(*own, *package.remarks, *remarks))


class _CellReader:
    """Reads the robots of a cell and merges them."""

    def __init__(self, files: RobotFolder, own: RobotSettings) -> None:
        self._files, self._own = files, own
        self._problems = list(own.remarks)
        self._cell, self._node = read_cell(files.urdf_file)
        self._read: dict[Path, tuple[RobotSettings, RobotModel | None]] = {}

    def read(self) -> CellSurvey:
        settings: dict[str, RobotSettings] = {}
        placed: dict[str, PlacedRobot] = {}
        for name, entry in self._cell.robots.items():
            try:
                found, model = self._survey(self._folder(entry))
            except ConfigError as error:
                here = self._node.locate(['robots', name, 'robot'])
                self._problems += [replace(problem, where=problem.where or here)
                                   for problem in error.problems]
                continue
            settings[name] = found if model is None else _with_cameras_on_links(found, model)
            if model is not None:
                placed[name] = self._placed(name, entry, found, model)
        for name, text in clashes(placed):
            where = self._node.locate(['robots', name]) or Location(str(self._files.urdf_file))
            self._problems.append(Problem(
                text, where, remedy=f"give '{name}' a prefix of its own"))
        cell = None
        if not errors_of(self._problems):
            cell = self._merged(settings, placed)
        return CellSurvey(
            tuple(dict.fromkeys(self._problems)), self._own,
            tuple(description for description, _ in self._read.values()),
            cell.model if cell else None, None if errors_of(self._problems) else cell)

    def _folder(self, entry: CellRobot) -> str:
        """Return a robot's folder: relative to the cell's folder, else an included robot."""
        here = self._files.urdf_file.resolve().parent
        folder = here / entry.robot
        if not folder.is_dir():
            if entry.robot in robot_names():
                return entry.robot
            raise ConfigError(Problem(
                f"robot '{entry.robot}' is neither a folder from {here} nor one of ours",
                allowed=', '.join(robot_names()), remedy=nearest(entry.robot, robot_names())))
        try:
            check_inside(folder, (here, here.parent, share_folder(PACKAGE) / 'config'))
        except ResourceError as error:
            raise ConfigError(Problem(str(error))) from None
        return str(folder)

    def _survey(self, robot: str) -> tuple[RobotSettings, RobotModel | None]:
        """Return a robot's settings, and its model where its files have no errors."""
        folder = Path(robot)
        if folder not in self._read:
            settings = survey_robot_settings(robot)
            faulty = bool(errors_of(settings.remarks))
            model, found = survey_robot_model(settings, partial=faulty)
            self._problems += [*settings.remarks, *found]
            usable = not faulty and not errors_of(found)
            self._read[folder] = settings, model if usable else None
        return self._read[folder]

    def _placed(self, name: str, entry: CellRobot, settings: RobotSettings, model: RobotModel
                ) -> PlacedRobot:
        own = settings.simulation.placement
        prefixed = prefixed_model(
            model, self._cell.prefix(name), urdf_file=str(settings.urdf_file),
            srdf_file=str(settings.srdf_file))
        return PlacedRobot(
            prefixed,
            PlacementSettings(xyz=own.xyz if entry.xyz is None else entry.xyz,
                              rpy=own.rpy if entry.rpy is None else entry.rpy))

    def _merged(self, found: Mapping[str, RobotSettings], placed: Mapping[str, PlacedRobot]
                ) -> Cell | None:
        renamed = {name: prefixed_settings(settings_of, self._cell.prefix(name),
                                           self._cell.namespace(name))
                   for name, settings_of in found.items()}
        try:
            model, of_srdf, places = merged_model(self._own.name, placed, self._own_srdf())
        except ConfigError as error:
            self._problems.extend(error.problems)
            return None
        merged = merged_settings(self._own, renamed, self._problems)
        merged = self._with_start(merged, renamed, placed, model)
        if not errors_of(self._problems):
            merged, of_floor = with_default_floor(merged, model)
            self._problems += of_floor
        self._problems += of_srdf
        # What the robots' own files name was checked when they were read.
        own_files = {str(file) for file in (*self._own.files, self._own.srdf_file) if file}
        self._problems += [problem for problem in check_settings(merged, model, places)
                           if problem.where is not None and problem.where.file in own_files]
        rate = merged.controller_manager.update_rate
        return Cell(merged, model, tuple(
            Robot(name, _with_rate(renamed[name], rate), placed[name].model) for name in renamed))

    def _own_srdf(self) -> tuple[str, str] | None:
        file = self._own.srdf_file
        return None if file is None else (read_description(file), str(file))

    def _with_start(self, merged: RobotSettings, robots: Mapping[str, RobotSettings],
                    placed: Mapping[str, PlacedRobot], model: RobotModel) -> RobotSettings:
        """Return the settings with a common start state: the robots' own, then the cell's."""
        start: dict[str, float] = {}
        begun = [(placed[name].model, robot) for name, robot in robots.items()]
        for each, settings in (*begun, (model, self._own)):
            try:
                start.update(initial_positions(each, settings.simulation))
            except SimulationError as error:
                places = (settings.locate('simulation', key) for key in START_KEYS)
                self._problems.append(Problem(str(error), next(filter(None, places), None)))
        simulation = merged.simulation.model_copy(
            update={'initial_positions': start, 'initial_state': ''})
        return merged.model_copy(update={'simulation': simulation})


def _with_rate(settings: RobotSettings, rate: int) -> RobotSettings:
    manager = settings.controller_manager.model_copy(update={'update_rate': rate})
    return settings.model_copy(update={'controller_manager': manager})


def _with_cameras_on_links(settings: RobotSettings, model: RobotModel) -> RobotSettings:
    """
    Mount the cameras of the robot's parent frame on its root link.

    A cell has no parent frames, and a camera sees its robot wherever the cell places it.
    """
    simulation = settings.simulation
    to_root = inverse_pose(pose_matrix(simulation.placement.xyz, simulation.placement.rpy))
    cameras = dict(simulation.cameras)
    for name, camera in simulation.cameras.items():
        if camera.link and camera.link == model.parent_frame:
            pose = to_root @ pose_matrix(camera.xyz, camera.rpy)
            cameras[name] = camera.model_copy(update={
                'link': model.root_link, 'xyz': tuple(pose[:3, 3].tolist()),
                'rpy': tuple(rpy_from_matrix(pose[:3, :3]).tolist())})
    return settings.model_copy(update={
        'simulation': simulation.model_copy(update={'cameras': cameras})})
