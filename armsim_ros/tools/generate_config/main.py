# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program generate_config: from a URDF to a complete first set of files."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
import shlex
import shutil
import sys

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.cli.arguments import argparse_words, part_words, split_ros_args
from armsim_ros.config.draft import empty_node
from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import ConfigError, Location, ModelError, Problem, Severity
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.description.srdf import parse_srdf
from armsim_ros.model.geometry import corner_points
from armsim_ros.model.loading import survey_robot_model
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.packages import Packages, split_path
from armsim_ros.planning.scene.allowed_collision_matrix import sorted_pair
from armsim_ros.tools.generate_config.collision_pairs import (
    LinkPairs,
    random_state,
    sample_pairs,
    SampledPairs,
)
from armsim_ros.tools.generate_config.found_groups import find_groups, FoundGroup
from armsim_ros.tools.generate_config.yaml_texts import controller_name, settings_texts, srdf_text

#: How far the moving links stay above the floor, and from each other [m].
CLEARANCE = 0.01
_TRIES = 2000
_WANTED = 30


def find_states(robot: RobotModel, seed: int = 0) -> dict[str, dict[str, float]]:
    """
    Return 'home' (the default positions, where they are free) and 'ready', another free state.

    :param robot: with the pairs that need no check in its SRDF.
    :param seed: of the random numbers.
    """
    model = KinematicModel(robot)
    # Free in the physics too, where meshes are hulls; some robots' hulls always overlap.
    return _find(model, _Clearances(model, hulls=True), seed) or _find(
        model, _Clearances(model, hulls=False), seed)


def _find(model: KinematicModel, clearances: _Clearances, seed: int
          ) -> dict[str, dict[str, float]]:
    generator = np.random.default_rng(seed)
    middle = model.default()
    found = {'home': middle} if clearances.is_free(middle, 0.0) else {}
    free: list[Vector] = []
    for _ in range(_TRIES):
        q = np.round(middle + 0.5 * (random_state(model, generator) - middle), 3)
        q = model.apply_mimic(q)
        if model.within_limits(q) and clearances.is_free(q):
            free.append(q)
        if len(free) >= _WANTED:
            break
    if free:
        found['ready'] = max(free, key=lambda q: clearances.height(q))
    return {state: {name: round(value, 6) for name, value in model.positions(q).items()
                    if model.robot.joints[name].active} for state, q in found.items()}


class _Clearances:
    """What is around the robot in a state."""

    def __init__(self, model: KinematicModel, *, hulls: bool) -> None:
        self._model = model
        robot = model.robot
        self._links = LinkPairs(model, hulls=hulls)
        solid = self._links.links
        self._pairs = [pair for place, first in enumerate(solid) for second in solid[place + 1:]
                       for pair in [sorted_pair(first, second)]
                       if pair not in robot.semantic.disabled_collisions]
        depth = {robot.root_link: 0}
        for joint in robot.joints.values():
            depth[joint.child] = depth[joint.parent] + int(joint.movable)
        # The first moving link only turns on its base, which is on the floor.
        self._corners = [
            (name, np.vstack([corner_points(item.geometry, item.origin)
                              for item in link.collisions]))
            for name, link in robot.links.items() if depth[name] >= 2 and link.collisions]

    def is_free(self, q: Vector, distance: float = CLEARANCE) -> bool:
        """
        Return whether no links are nearer than a distance, and none is near the floor.

        :param distance: [m]; 0 asks only that nothing touches.
        """
        return self.height(q) > CLEARANCE and not self._links.nearer(q, self._pairs, distance)

    def height(self, q: Vector) -> float:
        """Return the height of the lowest corner of the moving links [m]."""
        poses = self._model.link_poses(q, [name for name, _ in self._corners])
        return min((float(np.min(corners @ pose[2, :3]) + pose[2, 3])
                    for pose, (_, corners) in zip(poses, self._corners, strict=True)
                    if len(corners)), default=np.inf)


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


def main(argv: Sequence[str] | None = None) -> int:
    """
    Write a first set of files for a URDF, and check it.

    :param argv: the words after the program's name; those of this process where None.
    :returns: check_config's status for the new files: 0, 1 with warnings, 2 with errors.
    :raises ConfigError: the URDF has errors, or the files are there already.
    """
    words, _ = split_ros_args(sys.argv[1:] if argv is None else argv)
    words, arguments = part_words(words, _parser())
    options = _parser().parse_args(argparse_words(words))
    # Slow to import, and not needed for --help.
    from armsim_ros.tools.check_config.main import exit_status, report_lines
    from armsim_ros.tools.check_config.robot_check import check_robot
    target = options.to or Path.cwd() / options.urdf.name.split('.')[0]
    for line in generate_config(options.urdf, target, states=options.states, seed=options.seed,
                                copy=options.copy, arguments=arguments,
                                packages_path=options.packages_path):
        print(line, flush=True)
    check = check_robot(str(target), arguments=arguments, packages_path=options.packages_path)
    for line in report_lines(check):
        print(line)
    given = [f'{name}:={value}' for name, value in arguments.items()]
    if options.packages_path:
        given.append(f"packages_path:={':'.join(map(str, options.packages_path))}")
    words = ['armsim', 'bringup', f'robot:={target}', *given]
    print(f'start it with: {shlex.join(words)}')
    return exit_status(check)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='armsim generate_config',
        description='Write SRDF, controllers, joint limits, kinematics and simulation settings '
                    'for a URDF.',
        epilog='exit status: that of check_config for the new files')
    parser.add_argument('urdf', type=Path, metavar='URDF', help='URDF or xacro file; the '
                        'arguments of a xacro follow as name:=value')
    parser.add_argument('--to', type=Path, metavar='DIR',
                        help="folder for the files (default: a folder with the URDF's name)")
    parser.add_argument('--packages-path', type=split_path, default=(), metavar='DIR:...',
                        help='folders that are searched first for packages')
    parser.add_argument('--states', type=int, default=10_000, metavar='N',
                        help='random states that are checked for collisions (%(default)s)')
    parser.add_argument('--seed', type=int, default=0,
                        help='seed of the random numbers (%(default)s)')
    parser.add_argument('--copy', action='store_true',
                        help='copy the URDF instead of linking to it')
    return parser
