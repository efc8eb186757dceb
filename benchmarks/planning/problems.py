# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Planning problems of MotionBenchMaker, and the robots that they are for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
import json
import os
from pathlib import Path
import subprocess
import sys
import tarfile
from typing import Any
import xml.etree.ElementTree as ElementTree

import numpy as np
import yaml

from armsim_ros.model.transforms import matrix_from_quat_xyzw, quat_xyzw_from_matrix

#: Its source package holds both robots and all problems (Apache-2.0; the problems BSD-3-Clause,
#: Rice University 2021; Chamzas et al., RA-L 2022, DOI 10.1109/LRA.2021.3133603).
SOURCE = 'vamp-planner==0.6.4'
SCENES = ('box', 'table_pick', 'bookshelf_small', 'cage')
PROBLEMS_OF_A_SCENE = 25
#: The same for every joint and every planner [rad/s], [rad/s^2].
VELOCITY, ACCELERATION = 2.0, 5.0
GROUP = 'arm'


@dataclass(frozen=True)
class Problem:
    """
    A motion to plan.

    :param start: (m,) [rad].
    :param goal: (m,) [rad].
    :param obstacles: ``{id, type, position, quat_xyzw, size | radius, length}`` in the frame of
        the robot's root link [m].
    """

    scene: str
    index: int
    start: tuple[float, ...]
    goal: tuple[float, ...]
    obstacles: tuple[dict[str, Any], ...]


@dataclass(frozen=True)
class ProblemSet:
    """Problems of one robot, and its files: a folder that ``armsim`` can be started with."""

    robot: str
    joints: tuple[str, ...]
    folder: Path
    problems: tuple[Problem, ...]

    def for_peers(self) -> dict[str, Any]:
        """Return what a peer has to know of the robot."""
        return {
            'urdf': str(self.folder / f'{self.robot}.urdf'),
            'srdf': str(self.folder / f'{self.robot}.srdf'),
            'limits': str(self.folder / 'joint_limits.yaml'),
            'folder': str(self.folder), 'group': GROUP, 'joints': list(self.joints),
            'velocity': VELOCITY, 'acceleration': ACCELERATION,
        }


def cache_folder() -> Path:
    """Return where robots and the peers' environments are kept."""
    base = os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache'
    return Path(base) / 'armsim_ros' / 'bench'


def problem_sets(folder: str, count: int) -> list[ProblemSet]:
    """
    Return the problems of every ``*.json`` of a folder, or those of the source package.

    :param folder: '' for the source package, which is fetched once.
    :param count: problems of a scene, at most.
    """
    source = _source()
    found = []
    for document in _documents(Path(folder)) if folder else _packaged(source):
        taken: dict[str, int] = {}
        problems = []
        for each in document['problems']:
            taken[each['scene']] = taken.get(each['scene'], 0) + 1
            if taken[each['scene']] <= count:
                problems.append(Problem(
                    each['scene'], int(each['index']), tuple(each['start']),
                    tuple(each['goal']), tuple(each['obstacles'])))
        joints = tuple(document['joints'])
        robot = document['robot']
        found.append(ProblemSet(
            robot, joints, _robot(robot, joints, source / 'resources' / robot), tuple(problems)))
    return found


def problem_text(problem: Problem) -> dict[str, Any]:
    """Return a problem as plain values for JSON."""
    return asdict(problem)


def _documents(folder: Path) -> list[dict[str, Any]]:
    files = sorted(folder.glob('*.json'))
    if not files:
        raise SystemExit(f'{folder} has no problems: *.json are looked for')
    return [json.loads(path.read_text(encoding='utf-8')) for path in files]


def _source() -> Path:
    """Return the unpacked source package; its own build is not run."""
    folder = cache_folder() / 'source'
    unpacked = sorted(folder.glob('*/resources'))
    if not unpacked:
        folder.mkdir(parents=True, exist_ok=True)
        subprocess.run(
            [sys.executable, '-m', 'pip', 'download', '--quiet', '--no-deps', '--no-binary',
             SOURCE.partition('=')[0], '--dest', str(folder), SOURCE], check=True)
        with tarfile.open(next(folder.glob('*.tar.gz'))) as archive:
            archive.extractall(folder, filter='data')
        unpacked = sorted(folder.glob('*/resources'))
    return unpacked[0].parent


def _robot(name: str, joints: Sequence[str], source: Path) -> Path:
    """Write the folder of a robot whose other joints are fixed; meshes by absolute path."""
    folder = cache_folder() / 'robots' / name
    folder.mkdir(parents=True, exist_ok=True)
    tree = ElementTree.parse(source / f'{name}.urdf')
    root = tree.getroot()
    root.set('name', name)
    for link in root.iter('link'):
        for visual in link.findall('visual'):
            link.remove(visual)
    for mesh in root.iter('mesh'):
        path = source / mesh.get('filename', '').removeprefix('package://')
        mesh.set('filename', str(path.resolve()))
    for joint in root.findall('joint'):
        for mimic in joint.findall('mimic'):
            joint.remove(mimic)
        if joint.get('name') not in joints:
            joint.set('type', 'fixed')
        limit = joint.find('limit')
        if limit is not None:
            limit.set('velocity', str(VELOCITY))
    tree.write(folder / f'{name}.urdf', encoding='utf-8', xml_declaration=True)

    semantic = ElementTree.Element('robot', name=name)
    group = ElementTree.SubElement(semantic, 'group', name=GROUP)
    for joint_name in joints:
        ElementTree.SubElement(group, 'joint', name=joint_name)
    links = {link.get('name') for link in root.iter('link')}
    for pair in ElementTree.parse(source / f'{name}.srdf').getroot().iter('disable_collisions'):
        if {pair.get('link1'), pair.get('link2')} <= links:
            semantic.append(pair)
    ElementTree.ElementTree(semantic).write(folder / f'{name}.srdf', encoding='utf-8')

    limits = {'joint_limits': {joint_name: {
        'has_velocity_limits': True, 'max_velocity': VELOCITY,
        'has_acceleration_limits': True, 'max_acceleration': ACCELERATION,
    } for joint_name in joints}}
    (folder / 'joint_limits.yaml').write_text(yaml.safe_dump(limits), encoding='utf-8')
    return folder


def _packaged(source: Path) -> list[dict[str, Any]]:
    """Return the first problems of each scene as the source package has them."""
    found = []
    for robot in ('panda', 'ur5'):
        kept = cache_folder() / 'problems' / f'{robot}.json'
        if not kept.exists():
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_text(json.dumps(_packaged_for(source, robot)), encoding='utf-8')
        found.append(json.loads(kept.read_text(encoding='utf-8')))
    return found


def _packaged_for(source: Path, robot: str) -> dict[str, Any]:
    problems = []
    joints: list[str] = []
    wanted = {
        f'problems/{scene}_{robot}/{kind}{index:04d}.yaml': (scene, index, kind)
        for scene in SCENES for index in range(1, 101) for kind in ('scene', 'request')}
    texts = {}
    with tarfile.open(source / 'resources' / robot / 'problems.tar.bz2') as archive:
        for member in archive:  # in the order of the file: going back means unpacking anew
            if member.name in wanted:
                content = archive.extractfile(member)
                assert content is not None, f'{member.name} is not a file'
                texts[wanted[member.name]] = content.read()
    for scene in SCENES:
        complete = [index for index in range(1, 101) if {
            (scene, index, 'scene'), (scene, index, 'request')} <= texts.keys()]
        for index in complete[:PROBLEMS_OF_A_SCENE]:
            world, request = (
                yaml.load(texts[scene, index, kind], yaml.CSafeLoader)
                for kind in ('scene', 'request'))
            goal = request['goal_constraints'][0]['joint_constraints']
            state = request['start_state']['joint_state']
            start = dict(zip(state['name'], state['position'], strict=True))
            joints = [each['joint_name'] for each in goal]
            problems.append({
                'scene': scene, 'index': index,
                'start': [start[name] for name in joints],
                'goal': [each['position'] for each in goal],
                'obstacles': list(_obstacles(world['world']['collision_objects'])),
            })
    return {'robot': robot, 'joints': joints, 'problems': problems}


def _obstacles(objects: list[dict[str, Any]]) -> list[dict[str, Any]]:
    found = []
    for each in objects:
        shape = each['primitives'][0]
        pose = _matrix(each.get('pose')) @ _matrix(each['primitive_poses'][0])
        item = {
            'id': each['id'], 'type': shape['type'], 'position': pose[:3, 3].tolist(),
            'quat_xyzw': quat_xyzw_from_matrix(pose).tolist(),
        }
        if shape['type'] == 'box':
            item['size'] = shape['dimensions']
        else:
            item['length'], item['radius'] = shape['dimensions'][:2]
        found.append(item)
    return found


def _matrix(pose: dict[str, Any] | None) -> np.ndarray:
    matrix = np.eye(4)
    if pose:
        matrix[:3, :3] = matrix_from_quat_xyzw(np.array(pose['orientation'], dtype=float))
        matrix[:3, 3] = pose['position']
    return matrix
