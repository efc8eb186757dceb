# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From settings to the robot model: URDF and SRDF together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import ConfigError, Location, ModelError, Problem, ResourceError, Severity
from armsim_ros.model.cross_check import check_description, check_settings
from armsim_ros.model.description.srdf import parse_srdf
from armsim_ros.model.description.urdf import parse_urdf, UrdfContent
from armsim_ros.model.description.urdf_elements import Scale
from armsim_ros.model.description.xacro_text import describe, Description, read_text, source_line
from armsim_ros.model.geometry import Mesh
from armsim_ros.model.meshes import load_mesh
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.semantic_model import SemanticModel
from armsim_ros.packages import Packages


def load_robot_model(
    settings: RobotSettings, *, report: Callable[[Problem], None] | None = None,
    visual_meshes: bool = False
) -> RobotModel:
    """
    Build the model of a robot and check that the settings fit it.

    :param report: receives every warning and remark.
    :param visual_meshes: whether to read visual meshes too; physics and planning need none.
    :raises ConfigError: with every error in URDF and SRDF, or every place where the settings
        name what the robot has not.
    """
    model, found = survey_robot_model(settings, visual_meshes=visual_meshes)
    errors = [problem for problem in found if problem.severity is Severity.ERROR]
    if errors or model is None:
        raise ConfigError(errors)
    if report is not None:
        for problem in found:
            report(problem)
    return model


def survey_robot_model(
    settings: RobotSettings, *, visual_meshes: bool = False, partial: bool = False,
    urdf: Description | None = None, srdf: Description | None = None,
) -> tuple[RobotModel | None, list[Problem]]:
    """
    Build the model and continue despite errors.

    :param partial: whether the settings have errors of their own; what only follows from
        those is left out.
    :param urdf: the URDF after xacro, where it was read already.
    :param srdf: the SRDF after xacro, the same.
    :returns: the model, None where the URDF gives none, and everything that was found.
    """
    try:
        return _build(settings, visual_meshes, partial, urdf, srdf)
    except ConfigError as error:
        return None, list(error.problems)
    except ResourceError as error:
        return None, [Problem(str(error), Location(str(settings.urdf_file)))]


def packages_of(settings: RobotSettings) -> Packages:
    """Return the search path for the packages of a robot."""
    files = (settings.urdf_file, settings.srdf_file, settings.folder)
    return settings.packages.beside(*(file.resolve() for file in files if file is not None))


def _build(settings: RobotSettings, visual_meshes: bool, partial: bool,
           urdf: Description | None, srdf_description: Description | None
           ) -> tuple[RobotModel, list[Problem]]:
    packages = packages_of(settings)
    arguments = settings.arguments
    if urdf is None:
        urdf = describe(settings.urdf_file, mappings=arguments, packages=packages)
    urdf_text = urdf.text
    content = _parse_urdf(settings, urdf_text, packages, _workspace(settings), visual_meshes)
    srdf_text, semantic, places = '', SemanticModel(), dict(content.places)
    found = [*content.problems, *check_description(settings, content)]
    if settings.srdf_file is not None:
        try:
            if srdf_description is None:
                srdf_description = describe(
                    settings.srdf_file, mappings=arguments, packages=packages)
            srdf_text = srdf_description.text
            srdf = parse_srdf(srdf_text, str(settings.srdf_file), robot_name=content.name,
                              root_link=content.root_link, links=content.links,
                              joints=content.joints)
            semantic = srdf.semantic
            places.update(srdf.places)
            found.extend(srdf.problems)
        except ModelError as error:
            found.extend(error.problems)
            partial = True
    model = RobotModel(
        name=content.name, links=content.links, joints=content.joints, root_link=content.root_link,
        semantic=semantic, hardware=content.hardware, urdf=urdf_text, srdf=srdf_text)
    found.extend(check_settings(settings, model, places, partial=partial))
    return model, found


def _parse_urdf(settings: RobotSettings, text: str, packages: Packages,
                folders: tuple[Path, ...], visual_meshes: bool) -> UrdfContent:
    file = settings.urdf_file

    def read_mesh(uri: str, scale: Scale) -> Mesh:
        return load_mesh(uri, scale, packages=packages, base=file.resolve().parent,
                         within=folders)

    name = str(file)
    source = _source_of(file, text)
    try:
        content = parse_urdf(text, name, read_mesh=read_mesh,
                             read_visual_mesh=read_mesh if visual_meshes else None)
    except ModelError as error:
        raise ModelError([_to_source(problem, text, source)
                          for problem in error.problems]) from None
    if source is None:
        return content
    places = {what: _place_in_source(where, text, source)
              for what, where in content.places.items()}
    return replace(
        content, places=places,
        problems=tuple(_to_source(problem, text, source) for problem in content.problems),
        plugin_namespaces={name: _place_in_source(where, text, source)
                           for name, where in content.plugin_namespaces.items()})


def _source_of(file: Path, text: str) -> str | None:
    """Return the text of a file that xacro changed, None where it did not."""
    source = read_text(file)
    return None if source == text else source


def _to_source(problem: Problem, text: str, source: str | None) -> Problem:
    if source is None or problem.where is None:
        return problem
    return replace(problem, where=_place_in_source(problem.where, text, source))


def _place_in_source(where: Location, text: str, source: str) -> Location:
    """Return a place in the text after xacro as a line of the user's file, where a line fits."""
    if where.line is None:
        return where
    line = text.splitlines()[where.line - 1]
    _, quote, rest = line.partition('name="')
    found = source_line(source, rest.partition('"')[0]) if quote else None
    return Location(where.file, found)


def _workspace(settings: RobotSettings) -> tuple[Path, ...]:
    """Return the folders near a robot's files in which its meshes may lie."""
    starts = (settings.urdf_file.resolve().parent, settings.folder.resolve())
    places = [place for start in starts for place in (start, *list(start.parents)[:3])]
    return tuple(dict.fromkeys(place for place in places if place != Path(place.anchor)))
