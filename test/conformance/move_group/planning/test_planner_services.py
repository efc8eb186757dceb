# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Planners and their parameters, parts of the URDF, worlds as files."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from move_group_bench import name_of, xyz
from moveit_msgs.msg import ObjectColor
from moveit_msgs.srv import (
    GetGroupUrdf,
    GetPlannerParams,
    LoadGeometryFromFile,
    QueryPlannerInterfaces,
    SaveGeometryToFile,
    SetPlannerParams,
)
import pytest
from wire import at, box, quiet_diff, removal, sphere, tetrahedron, thing

PILZ = 'pilz_industrial_motion_planner'


def planners(arm: Any) -> dict[str, Any]:
    """Return pipeline -> its description."""
    answer = arm.client.call(arm.name('query_planner_interface'), QueryPlannerInterfaces)
    return {one.pipeline_id: one for one in answer.planner_interfaces}


def get(arm: Any, **fields: str) -> dict[str, str]:
    """Ask get_planner_params."""
    request = GetPlannerParams.Request(**fields)
    params = arm.client.call(arm.name('get_planner_params'), GetPlannerParams, request).params
    assert len(params.keys) == len(params.values) == len(params.descriptions)
    return dict(zip(params.keys, params.values, strict=True))


def set_(
    arm: Any, keys: list[str], values: list[str], replace: bool = False, **fields: str
) -> None:
    """Ask set_planner_params."""
    request = SetPlannerParams.Request(replace=replace, **fields)
    request.params.keys, request.params.values = keys, values
    arm.client.call(arm.name('set_planner_params'), SetPlannerParams, request)


@pytest.mark.statement('SRV-60', 'OMP-8', 'RVZ-5', 'M27')
def test_the_planners_of_each_pipeline(arm: Any) -> None:
    """One entry for each pipeline; ids are the groups and their configurations."""
    found = planners(arm)
    assert found['ompl'].name == 'OMPL'
    ids = found['ompl'].planner_ids
    assert {f'{arm.group}[RRTConnect]', arm.group} <= set(ids)
    assert 'RRTConnect' not in ids
    assert len(ids) == len(set(ids))


@pytest.mark.statement('PLZ-1')
def test_pilz_is_listed(arm: Any) -> None:
    """The second pipeline, with its commands."""
    entry = planners(arm)[PILZ]
    assert entry.name == 'Pilz Industrial Motion Planner'
    assert set(entry.planner_ids) == {'PTP', 'LIN', 'CIRC'}


@pytest.mark.statement('SRV-61', 'SRV-62', 'RVZ-6')
def test_planner_params(arm: Any) -> None:
    """What is set for a configuration of a group is got, and the next plan takes it."""
    where = {'pipeline_id': 'ompl', 'planner_config': 'RRTConnect', 'group': arm.group}
    before = get(arm, **where)
    set_(arm, ['range'], ['0.3'], **where)
    assert get(arm, **where)['range'] == '0.3'
    arm.planned(arm.near(), planner_id='RRTConnect')
    set_(arm, ['range', 'goal_bias'], ['0.4'], **where)
    assert get(arm, **where)['range'] == '0.3'
    set_(arm, list(before), list(before.values()), replace=True, **where)
    assert get(arm, **where) == before


@pytest.mark.statement('SRV-61', 'SRV-62')
def test_params_of_each_pipeline(arm: Any) -> None:
    """
    Pilz has no parameters but those that a client sets, which leave those of OMPL as they are.

    moveit_ros, query_planners_service_capability.cpp, getParams and setParams.
    """
    where = {'planner_config': 'RRTConnect', 'group': arm.group}
    before = get(arm, pipeline_id='ompl', **where)
    assert before
    assert get(arm, pipeline_id=PILZ, **where) == {}
    set_(arm, ['range'], ['0.3'], pipeline_id=PILZ, **where)
    assert get(arm, pipeline_id=PILZ, **where) == {'range': '0.3'}
    assert get(arm, pipeline_id='ompl', **where) == before
    set_(arm, [], [], replace=True, pipeline_id=PILZ, **where)
    assert get(arm, pipeline_id=PILZ, **where) == {}


@pytest.mark.statement('SRV-61')
def test_params_of_an_unknown_pipeline(arm: Any) -> None:
    """Nothing."""
    assert get(arm, pipeline_id='chomp', planner_config='RRTConnect') == {}


@pytest.mark.statement('SRV-70')
def test_urdf_of_a_group(arm: Any) -> None:
    """A robot with the group's joints whose links all exist; an unknown group is 99999."""
    request = GetGroupUrdf.Request(group_name=arm.group)
    answer = arm.client.call(arm.name('get_urdf'), GetGroupUrdf, request)
    assert name_of(answer.error_code) == 'SUCCESS'
    robot = ElementTree.fromstring(answer.urdf_string)
    joints = robot.findall('joint')
    links = {link.get('name') for link in robot.findall('link')}
    assert set(arm.group_joints) <= {joint.get('name') for joint in joints}
    for joint in joints:
        assert {joint.find('parent').get('link'), joint.find('child').get('link')} <= links
    request = GetGroupUrdf.Request(group_name='no_such_group')
    answer = arm.client.call(arm.name('get_urdf'), GetGroupUrdf, request)
    assert name_of(answer.error_code) == 'FAILURE'
    assert answer.error_code.message


def save(arm: Any, path: Path | str) -> bool:
    """Ask save_geometry_to_file."""
    request = SaveGeometryToFile.Request(file_path_and_name=str(path))
    name = arm.name('save_geometry_to_file')
    return bool(arm.client.call(name, SaveGeometryToFile, request).success)


def load(arm: Any, path: Path | str) -> bool:
    """Ask load_geometry_from_file."""
    request = LoadGeometryFromFile.Request(file_path_and_name=str(path))
    name = arm.name('load_geometry_from_file')
    return bool(arm.client.call(name, LoadGeometryFromFile, request).success)


@pytest.fixture
def folder(server: Any, tmp_path: Path) -> Path:
    """Give a folder in which the server may write."""
    return tmp_path if server.home is None else server.home / 'scenes'


@pytest.mark.statement('SRV-71', 'SCN-7')
def test_a_world_as_a_file(arm: Any, folder: Path) -> None:
    """Save, clear, load: ids, shapes, poses, colours and subframes are back."""
    scene = quiet_diff()
    cup = thing('my cup', arm.frame, [box(0.1, 0.2, 0.3), sphere(0.05)], pose=at(2.0, 0.5),
                poses=[at(0.0, 0.0, 0.1), at(0.0, 0.3)])
    cup.subframe_names, cup.subframe_poses = ['handle'], [at(0.0, 0.2)]
    scene.world.collision_objects = [
        cup, thing('mesh', arm.frame, [tetrahedron(0.2)], pose=at(3.0))
    ]
    scene.object_colors = [ObjectColor(id='my cup')]
    scene.object_colors[0].color.b = scene.object_colors[0].color.a = 1.0
    assert arm.apply(scene)
    before = arm.scene()
    assert save(arm, folder / 'world.scene')
    assert save(arm, folder / 'world.scene')
    assert arm.add(removal(''))
    assert load(arm, folder / 'world.scene')
    after = arm.scene()
    assert after.world == before.world
    assert after.object_colors == before.object_colors


@pytest.mark.statement('SRV-71')
def test_an_old_file(arm: Any, tmp_path: Path) -> None:
    """
    Objects without a pose of their own, as older programs wrote them, are at the origin.

    Upstream, planning_scene.cpp, loadGeometryFromStream: the poses are those of the shapes.
    """
    path = tmp_path / 'old.scene'
    path.write_text(
        '(noname)+\n* crate\n1\nbox\n0.1 0.2 0.3\n2 0 1\n0 0 0 1\n0 0 0 0\n.\n', encoding='utf-8'
    )
    assert load(arm, path)
    crate = arm.objects()['crate']
    assert xyz(crate.pose.position) == pytest.approx((0.0, 0.0, 0.0))
    assert xyz(crate.primitive_poses[0].position) == pytest.approx((2.0, 0.0, 1.0))


@pytest.mark.statement('SRV-71')
@pytest.mark.parametrize('text', [
    '', 'name\n* a\n0 0', 'name\n* a\n0 0 0\n0 0 0 1\n1\nblob\n1\n', 'name\n* a\nx y z\n',
    'name\n* a\n0 0 0\n0 0 0 1\n99999999999\n', 'name\n* a\n0 0 0\n0 0 0 1\n1\nbox\n1 nan 1\n',
])
def test_files_that_are_none(arm: Any, tmp_path: Path, text: str) -> None:
    """Success false, and the world stays as it was."""
    arm.add(thing('crate', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0)))
    path = tmp_path / 'bad.scene'
    path.write_text(text, encoding='utf-8')
    before = arm.scene().world
    assert not load(arm, path)
    assert arm.scene().world == before


@pytest.mark.statement('SRV-71')
def test_paths_that_are_none(arm: Any, tmp_path: Path) -> None:
    """A missing file, a folder and a folder that does not exist."""
    assert not load(arm, tmp_path / 'missing.scene')
    assert not load(arm, tmp_path)
    assert not save(arm, tmp_path)
    assert not save(arm, tmp_path / 'nowhere' / 'world.scene')


@pytest.mark.statement('SRV-71')
def test_no_file_of_the_user_is_written_over(arm: Any, server: Any, tmp_path: Path) -> None:
    """Files are written in one folder, and only where none or a scene was before."""
    if server.home is None:
        pytest.skip('needs a server whose folder is known')
    folder = server.home / 'scenes'
    assert save(arm, 'relative.scene')
    assert (folder / 'relative.scene').is_file()
    assert load(arm, 'relative.scene')
    (folder / 'letter.txt').write_text('Dear\nAda\n', encoding='utf-8')
    (folder / 'link').symlink_to(tmp_path)
    for path in ('letter.txt', tmp_path / 'new.scene', '../up.scene', 'link/new.scene', ''):
        assert not save(arm, path)
    assert (folder / 'letter.txt').read_text(encoding='utf-8') == 'Dear\nAda\n'
    assert not list(tmp_path.iterdir())
    assert not (server.home / 'up.scene').exists()


@pytest.mark.statement('SRV-71')
@pytest.mark.parametrize('name', ['two\nlines', 'two\u2028lines', '  padded ', 'cr\r'])
def test_names_that_a_file_cannot_hold(arm: Any, folder: Path, name: str) -> None:
    """They are refused, rather than written so that the file does not load again."""
    assert arm.add(thing(name, arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0)))
    assert not save(arm, folder / 'odd.scene')
    assert not (folder / 'odd.scene').exists()
