# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a URDF to a folder with a complete first set of files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
import shutil

from armsim_ros.config.draft import empty_node
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import ConfigError, Location, ModelError, Problem, Severity
from armsim_ros.model.description.srdf import parse_srdf
from armsim_ros.model.loading import survey_robot_model
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.packages import Packages
from armsim_ros.tools.generate_config.collision_pairs import sample_pairs, SampledPairs
from armsim_ros.tools.generate_config.found_groups import find_groups, FoundGroup
from armsim_ros.tools.generate_config.named_states import find_states
from armsim_ros.tools.generate_config.yaml_texts import controller_name, settings_texts, srdf_text

USUAL_STATES = 10_000


def generate_config(urdf: Path, target: Path, *, states: int = USUAL_STATES, seed: int = 0,
                    copy: bool = False, arguments: Mapping[str, str] | None = None,
                    packages_path: Iterable[Path] = (),
                    progress: Callable[[int], None] | None = None) -> list[str]:
    """
    Write SRDF, controllers, limits, kinematics and simulation settings beside a URDF.

    :param urdf: URDF or xacro file.
    :param target: folder for the files; none of them may be there yet.
    :param states: random states that are checked for collisions.
    :param seed: of the random numbers; the same gives the same files.
    :param copy: copy the URDF in place of a link to it.
    :param arguments: arguments of the URDF's xacro.
    :param packages_path: folders that are searched first for packages.
    :param progress: is called with how many states are done.
    :returns: what was found, line by line.
    :raises ConfigError: the URDF has errors, has no movable joint, or files are there already.
    """
    robot = read_urdf(urdf, arguments, packages_path)
    groups = find_groups(robot)
    if not groups:
        raise ModelError(Problem(f"robot '{robot.name}' has no movable joint",
                                 Location(str(urdf))))
    pairs = sample_pairs(robot, states=states, seed=seed, progress=progress)
    positions = find_states(_with_srdf(robot, srdf_text(robot, groups, {}, pairs.disabled)), seed)
    texts = {f'{target.name}.srdf': srdf_text(robot, groups, positions, pairs.disabled),
             **settings_texts(robot, groups, positions)}
    _write(texts, target)
    _place_urdf(urdf, target, copy)
    return [*_group_lines(groups), *_pair_lines(robot, pairs),
            f"named states: {', '.join(positions) or 'none that touches nothing was found'}",
            *(f'{target / name}' for name in texts)]


def read_urdf(urdf: Path, arguments: Mapping[str, str] | None = None,
              packages_path: Iterable[Path] = ()) -> RobotModel:
    """
    Return the model of a URDF alone.

    :param arguments: arguments of its xacro.
    :param packages_path: folders that are searched first for packages.
    :raises ConfigError: with every error in it.
    """
    if not urdf.is_file():
        raise ConfigError(Problem(f"urdf '{urdf}' is not a file"))
    settings = RobotSettings(
        name=urdf.name.split('.')[0], folder=urdf.parent, urdf_file=urdf,
        arguments=dict(arguments or {}),
    ).with_source(empty_node(), Packages(packages_path))
    robot, found = survey_robot_model(settings)
    errors = [problem for problem in found if problem.severity is Severity.ERROR]
    if errors or robot is None:
        raise ConfigError(errors)
    return robot


def _with_srdf(robot: RobotModel, text: str) -> RobotModel:
    content = parse_srdf(text, 'the new SRDF', robot_name=robot.name, root_link=robot.root_link,
                         links=robot.links, joints=robot.joints)
    return replace(robot, semantic=content.semantic, srdf=text)


def _write(texts: dict[str, str], target: Path) -> None:
    there = [name for name in texts if (target / name).exists()]
    if there:
        raise ConfigError(Problem(
            f"{', '.join(there)} exist already", Location(str(target)),
            remedy='name another folder with --to, or move them away'))
    target.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (target / name).write_text(text, encoding='utf-8')


def _place_urdf(urdf: Path, target: Path, copy: bool) -> None:
    """Put the URDF into the folder; as a link, so that its meshes are found beside it."""
    ending = '.urdf.xacro' if urdf.name.endswith('.xacro') else '.urdf'
    place = target / f'{target.name}{ending}'
    if urdf.resolve().parent == target.resolve() or place.exists():
        return
    if copy:
        shutil.copy(urdf, place)
    else:
        place.symlink_to(urdf.resolve())


def _group_lines(groups: list[FoundGroup]) -> Iterator[str]:
    for group in groups:
        where = ' -> '.join(group.chain) if group.chain else f'on {group.parent_link}'
        yield (f"group '{group.name}' ({where}): {', '.join(group.active_joints)}; moved by "
               f"'{controller_name(group)}'")


def _pair_lines(robot: RobotModel, pairs: SampledPairs) -> Iterator[str]:
    counts = Counter(pairs.disabled.values())
    total = len(pairs.disabled) + len(pairs.checked)
    reasons = ', '.join(f'{count} {reason}' for reason, count in counts.most_common())
    yield (f'{total} pairs of links in {pairs.states} states: {len(pairs.checked)} are checked, '
           f"{len(pairs.disabled)} are not{f' ({reasons})' if reasons else ''}")
