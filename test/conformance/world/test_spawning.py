# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Entities that come and go while the arm works."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from simulation_interfaces.msg import Resource, SpawnEntity
from world_user import BOX, FAILED, OK, stamped, WorldUser

from armsim_ros.clients.trajectory import SUCCEEDED

statement = pytest.mark.statement

SDF = """<sdf version="1.9"><model name="lamp"><light name="l" type="point"/>
  <plugin name="p" filename="x.so"/>
  <link name="base"><inertial><mass>0.4</mass>
      <inertia><ixx>0.001</ixx><iyy>0.001</iyy><izz>0.001</izz></inertia></inertial>
    <collision name="c"><geometry><box><size>0.1 0.2 0.3</size></box></geometry></collision>
  </link></model></sdf>"""
URDF = """<robot name="tool"><link name="a"><collision><geometry><sphere radius="0.04"/></geometry>
  </collision><inertial><mass value="0.2"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0"
  izz="1e-4"/></inertial></link></robot>"""
MJCF = """<mujoco><option gravity="0 0 -1"/><worldbody><body name="ball"><freejoint/>
  <geom type="sphere" size="0.03" rgba="1 0 0 1"/></body></worldbody></mujoco>"""
YAML = 'mass: 0.3\nparts: [{shape: {type: cylinder, radius: 0.03, length: 0.1}}]\n'


@statement('A3', 'A8', 'A12')
def test_a_shape_comes_and_goes(world: WorldUser) -> None:
    """An address is enough for a shape; it falls when it has mass, and can be deleted."""
    response = world.spawn('box', (0.5, 1.0, 3.0))
    assert (response.result.result, response.entity_name) == (OK, 'box')
    assert world.call('get_entity_info', entity='box').info.category.category == 0
    assert world.spawn('wall', (2.0, 1.0, 1.0), 'armsim://box?size=1,0.1,2').result.result == OK
    assert world.call('get_entity_info', entity='wall').info.category.category == 5
    assert {'box', 'wall'} <= set(world.entities())
    assert world.result('delete_entity', entity='box')[0] == OK
    assert 'box' not in world.entities()


@statement('A8', 'A11')
@pytest.mark.parametrize(('text', 'measure', 'unused'), [
    (SDF, (0.1, 0.2, 0.3), ('light', 'plugin')),
    (URDF, (0.08, 0.08, 0.08), ()),
    (MJCF, (0.06, 0.06, 0.06), ('option',)),
    (YAML, (0.06, 0.06, 0.1), ()),
], ids=['sdf', 'urdf', 'mjcf', 'yaml'])
def test_texts_of_every_format_are_told_by_their_content(
    world: WorldUser, text: str, measure: Any, unused: tuple[str, ...]
) -> None:
    """SDF, URDF, MJCF and our YAML; what is not used of them is said in the OK answer."""
    response = world.spawn('thing', (0, 2, 3), uri='', resource_string=text)
    assert response.result.result == OK, response.result.error_message
    high, low = world.call('get_entity_bounds', entity='thing').bounds.points
    assert (high.x - low.x, high.y - low.y, high.z - low.z) == pytest.approx(measure, abs=1e-6)
    for word in unused:
        assert f'<{word}' in response.result.error_message


@statement('A8', 'A9')
def test_files_below_the_users_folders_and_addresses_of_ours(world: WorldUser) -> None:
    """A path, file:// and armsim://world/object; nothing else is read."""
    file = world.folder / 'lamp.sdf'
    file.write_text(SDF)
    for number, uri in enumerate((str(file), f'file://{file}', 'armsim://feeding_place/star')):
        response = world.spawn(f'thing_{number}', (0, 2, 3.0 + number), uri=uri)
        assert response.result.result == OK, response.result.error_message


@statement('A9', 'A10', 'S27')
@pytest.mark.parametrize(('uri', 'code'), [
    ('/etc/hostname', 107),
    ('file:///etc/passwd', 107),
    ('../../../../etc/passwd', 107),
    ('package://no_such_package/model.sdf', 107),
    ('https://example.org/model.sdf', 103),
    ('armsim://nothing', 107),
    ('armsim://box?size=1,2', 106),
    ('armsim://feeding_place/nothing', 107),
])
def test_addresses_that_are_not_read(world: WorldUser, uri: str, code: int) -> None:
    """Files elsewhere and networks are refused, and nothing of a file is told."""
    response = world.spawn('x', uri=uri)
    assert response.result.result == code, response.result.error_message
    assert 'root:' not in response.result.error_message
    assert 'x' not in world.entities()


@statement('A9', 'A10')
@pytest.mark.parametrize(('text', 'code', 'words'), [
    ('<sdf version="1.9"><model name="m"><link>', 106, ':1'),
    ('<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><sdf>&b;</sdf>', 106, 'entity'),
    ('<collada/>', 103, 'sdf'),
    ('parts: [{shape: {type: box}}]\n', 106, ':1'),
    (SDF.replace('<box><size>0.1 0.2 0.3</size></box>',
                 '<mesh><uri>file:///nowhere.stl</uri></mesh>'), 107, 'nowhere.stl'),
    (SDF.replace('0.1 0.2 0.3', '0.1 -0.2 0.3'), 106, 'above 0'),
], ids=['broken', 'entity', 'format', 'yaml', 'asset', 'measure'])
def test_texts_that_cannot_be_used(
    world: WorldUser, text: str, code: int, words: str
) -> None:
    """Each kind of mistake has its code, and a text with the line."""
    before = world.entities()
    response = world.spawn('x', uri='', resource_string=text)
    assert response.result.result == code, response.result.error_message
    assert words in response.result.error_message
    assert world.entities() == before


@statement('A10')
def test_neither_address_nor_text(world: WorldUser) -> None:
    """That is NO_RESOURCE."""
    assert world.spawn('x', uri='').result.result == 104


@statement('A3', 'A10')
def test_names_are_unique_and_spelt_right(world: WorldUser) -> None:
    """101 and 102 without renaming; with it a number is put behind the name."""
    assert world.spawn('cube').result.result == 101
    assert world.spawn('').result.result == 102
    for name in ('a b', 'ä', 'x' * 201, 'new\nline'):
        assert world.spawn(name).result.result == 102
    assert world.spawn('cube', allow_renaming=True).entity_name == 'cube_1'
    assert world.spawn('cube', (0, 1, 3), allow_renaming=True).entity_name == 'cube_2'
    link = 'sunday/link_1'
    assert world.spawn(link, (0, 6, 3)).result.result == 101
    assert world.spawn(link, (0, 6, 3), allow_renaming=True).entity_name == f'{link}_1'
    assert world.spawn('A-1./_b', (0, 2, 3)).entity_name == 'A-1./_b'
    assert world.spawn('', (0, 3, 3), allow_renaming=True).result.result == OK
    assert world.spawn('y', (0, 4, 3), entity_namespace='1 bad').result.result == 105


@statement('S26', 'S27')
def test_an_empty_name_is_that_of_the_resource(world: WorldUser) -> None:
    """
    The model's own name counts where none is given, and the address before the text.

    simulation_interfaces SpawnEntity.srv, name.
    """
    assert world.spawn('', (0, 2, 3), uri='', resource_string=SDF).entity_name == 'lamp'
    assert world.spawn('', (0, 3, 3), uri='', resource_string=SDF).result.result == 101
    response = world.spawn('', (0, 4, 3), 'armsim://feeding_place/star', resource_string=SDF)
    assert response.entity_name == 'star_1' or response.result.result == 101
    assert world.spawn('', (0, 5, 3), uri='', resource_string=YAML).result.result == 102


@statement('A10')
@pytest.mark.parametrize(('quaternion', 'frame'), [
    ((0, 0, 0, 0), ''), ((0, 0, math.nan, 1), ''), ((0, 0, 0, 1), 'nowhere'),
])
def test_wrong_poses(world: WorldUser, quaternion: Any, frame: str) -> None:
    """109, and nothing is spawned."""
    response = world.call('spawn_entity', name='x', uri=BOX,
                          initial_pose=stamped((0, 0, 3), frame, quaternion))
    assert response.result.result == 109
    assert 'x' not in world.entities()


@statement('A10')
def test_a_free_object_must_not_overlap_a_robot(world: WorldUser) -> None:
    """109 names link and depth; a fixed object may overlap."""
    place = world.position('sunday/link_2')
    response = world.spawn('x', place)
    assert response.result.result == 109
    assert 'sunday/link_' in response.result.error_message
    assert 'mm' in response.result.error_message
    fixed = 'armsim://box?size=0.05,0.05,0.05'
    assert world.spawn('y', world.position('sunday'), fixed).result.result == OK


@statement('A13')
def test_several_at_once_have_a_result_each(world: WorldUser) -> None:
    """150 when one failed; the others stay."""
    orders = [
        SpawnEntity(name=name, entity_resource=Resource(uri=BOX),
                    initial_pose=stamped((number, 2, 3)))
        for number, name in enumerate(('one', 'cube', 'two'))
    ]
    response = world.call('spawn_entities', spawn_requests=orders)
    assert response.result.result == 150
    assert [one.result.result for one in response.results] == [OK, 101, OK]
    assert {'one', 'two'} <= set(world.entities())


@statement('A12')
def test_a_robot_is_not_deleted(world: WorldUser) -> None:
    """OPERATION_FAILED; it goes on."""
    code, words = world.result('delete_entity', entity='sunday')
    assert code == FAILED
    assert 'robot' in words
    assert 'sunday' in world.entities()


@statement('A8')
def test_spawnables_can_be_spawned(world: WorldUser) -> None:
    """Every address that is listed works, and takes the room that is said."""
    spawnables = world.call('get_spawnables').spawnables
    uris = [one.uri for one in spawnables]
    assert {'armsim://box', 'armsim://feeding_place/cube'} <= set(uris)
    assert all(uri.startswith('armsim://') for uri in uris)
    for number, one in enumerate(spawnables):
        response = world.spawn(f'spawnable_{number}', (3.0 * number, 30.0, 3.0), uri=one.uri)
        assert response.result.result == OK, response.result.error_message
    high, low = spawnables[uris.index('armsim://feeding_place/cube')].spawn_bounds.points
    assert high.x - low.x == pytest.approx(0.08)


@statement('B3', 'B4')
def test_spawn_and_delete_while_the_arm_moves(world: WorldUser) -> None:
    """The goal goes on and is reached with the tolerances that it asked for."""
    goal = world.move(2.0, 0.4)
    for number in range(10):
        assert world.spawn(f'x{number}', (0.1 * number, 2.0, 3.0)).result.result == OK
        assert world.result('delete_entity', entity=f'x{number}')[0] == OK
    assert goal.result().status == SUCCEEDED


def test_the_shipped_worlds_are_files(world: WorldUser) -> None:
    """What is listed as a world lies where its address says."""
    worlds = world.call('get_available_worlds').worlds
    assert worlds
    for one in worlds:
        assert Path(one.world_resource.uri.removeprefix('file://')).is_file()
