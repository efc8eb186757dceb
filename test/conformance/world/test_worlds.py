# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Worlds are listed, loaded and unloaded around the robot."""

from __future__ import annotations

import pytest
from simulation_interfaces.msg import Resource
from world_user import FAILED, NO_WORLD, OK, PAUSED, PLAYING, STOPPED, WorldUser

from armsim_ros.clients.trajectory import ABORTED, SUCCEEDED

statement = pytest.mark.statement

NO_WORLD_LOADED, INCORRECT = 101, 103
SDF = """<sdf version="1.9"><world name="room"><light name="sun" type="directional"/>
  <model name="shelf"><static>true</static><pose>2 0 0.5 0 0 0</pose>
    <link name="l"><collision name="c"><geometry><box><size>1 1 1</size></box></geometry>
      </collision></link></model>
  <model name="can"><pose relative_to="shelf">0 0 0.56 0 0 1.5708</pose>
    <link name="l"><pose>0 0 0.01 0 0 0</pose><collision name="c"><geometry><cylinder>
      <radius>0.03</radius><length>0.1</length></cylinder></geometry></collision></link></model>
</world></sdf>"""
MJCF = """<mujoco model="yard"><worldbody><geom type="plane" size="1 1 1"/>
  <geom name="post" type="cylinder" size="0.05 0.5" pos="2 0 0.5"/>
  <body name="ball" pos="0 2 1"><freejoint/><geom type="sphere" size="0.05"/></body>
</worldbody></mujoco>"""


@statement('A1', 'A2')
def test_features_are_true(world: WorldUser) -> None:
    """A value is listed exactly when its service is there; formats and versions are said."""
    features = world.call('get_simulator_features').features
    services = {name for name, _ in world.client.node.get_service_names_and_types()}
    listed = set(features.features)
    needed = {
        0: 'spawn_entity', 1: 'delete_entity', 2: 'get_named_poses', 3: 'get_named_pose_bounds',
        5: 'get_entity_bounds', 10: 'get_entity_state', 11: 'set_entity_state',
        12: 'get_entity_info', 13: 'set_entity_info', 14: 'get_spawnables',
        20: 'reset_simulation', 24: 'get_simulation_state', 25: 'set_simulation_state',
        31: 'step_simulation', 33: 'simulate_steps/_action/send_goal', 40: 'load_world',
        43: 'unload_world', 44: 'get_current_world', 45: 'get_available_worlds',
        50: 'spawn_entities',
    }
    for number, name in needed.items():
        assert (number in listed) == (f'/{name}' in services), name
    assert {0, 1, 5, 6, 8, 9, 10, 11, 12, 14, 20, 22, 23, 24, 25, 26, 31, 32, 33, 40, 41, 43,
            44, 45, 50} <= listed
    assert 21 not in listed
    assert set(features.spawn_formats) == {'sdf', 'urdf', 'mjcf', 'yaml'}
    for word in ('MuJoCo', 'mode', 'step'):
        assert word in features.custom_info


@statement('A20', 'B1')
def test_available_worlds_can_be_loaded(world: WorldUser) -> None:
    """The shipped ones and those of the user's folders, each by the address that is listed."""
    (world.folder / 'room.sdf').write_text(SDF)
    worlds = {one.name: one for one in world.call('get_available_worlds').worlds}
    assert {'feeding_place', 'empty', 'room'} <= set(worlds)
    code, words = world.result('load_world', uri=worlds['room'].world_resource.uri)
    assert code == OK, words
    assert 'light' in words
    assert world.entities() == ['can', 'shelf', 'sunday']
    assert world.position('can') == pytest.approx((2.0, 0.0, 1.06))
    assert world.call('get_current_world').world.name == 'room'
    assert world.state == STOPPED
    (world.folder / 'room.sdf').unlink()


@statement('A20', 'B1')
def test_a_world_is_exchanged_under_a_goal(world: WorldUser) -> None:
    """
    The goal ends and says so; the robot stays and works in the new world, whose text is kept.

    simulation_interfaces Resource.msg, uri.
    """
    goal = world.move(20.0, 1.0)
    assert world.result('load_world', resource_string=MJCF)[0] == OK
    outcome = goal.result(timeout=15.0)
    assert outcome.status == ABORTED
    assert 'world' in outcome.error_string
    assert world.entities() == ['ball', 'post', 'sunday']
    current = world.call('get_current_world').world.world_resource
    assert current == Resource(resource_string=MJCF)
    assert world.become(PLAYING)[0] == OK
    assert world.move(0.2).result().status == SUCCEEDED


@statement('A20')
@pytest.mark.parametrize(('request_', 'code'), [
    ({}, 102), ({'uri': 'nowhere'}, 104), ({'uri': 'https://a/b.sdf'}, 101),
    ({'resource_string': '<sdf><world>'}, 103), ({'resource_string': '<robot name="a"/>'}, 101),
    ({'resource_string': SDF, 'fail_on_unsupported_element': True}, 106),
    ({'resource_string': MJCF.replace('ball', 'sunday')}, 103),
])
def test_a_world_that_cannot_be_loaded_leaves_the_old_one(
    world: WorldUser, request_: dict[str, object], code: int
) -> None:
    """Each mistake has its code; the old world and the goal go on."""
    goal = world.move(0.5)
    found, words = world.result('load_world', **request_)
    assert (found, bool(words)) == (code, True)
    assert 'cube' in world.entities()
    assert goal.result().status == SUCCEEDED


@statement('S26')
def test_a_world_can_leave_missing_assets_out(world: WorldUser) -> None:
    """
    Shapes whose files are missing are left out, and the answer names them.

    simulation_interfaces LoadWorld.srv, ignore_missing_or_unsupported_assets.
    """
    text = SDF.replace('</model>', """<link name="more"><collision name="c"><geometry>
        <mesh><uri>file:///nowhere.stl</uri></mesh></geometry></collision></link></model>""", 1)
    assert world.result('load_world', resource_string=text)[0] == 104
    code, words = world.result(
        'load_world', resource_string=text, ignore_missing_or_unsupported_assets=True)
    assert code == OK
    assert 'nowhere.stl' in words
    assert world.entities() == ['can', 'shelf', 'sunday']


@statement('A14', 'A20')
def test_without_a_world_nothing_plays(world: WorldUser) -> None:
    """The robots are alone; unloading twice is refused, and so is playing."""
    assert world.result('unload_world')[0] == OK
    assert world.state == NO_WORLD
    assert world.entities() == ['sunday']
    assert world.result('unload_world')[0] == NO_WORLD_LOADED
    assert world.result('get_current_world')[0] == NO_WORLD_LOADED
    for state in (PLAYING, PAUSED, STOPPED):
        assert world.become(state)[0] == INCORRECT
    assert world.result('load_world', uri='empty')[0] == OK
    assert world.state == STOPPED
    assert world.entities() == ['sunday']


@statement('A20')
def test_further_folders_must_be_allowed(world: WorldUser) -> None:
    """A folder elsewhere is refused, or left out where that is wanted."""
    code, words = world.result('get_available_worlds', additional_sources=['/etc'])
    assert code == FAILED
    assert '/etc' in words
    response = world.call(
        'get_available_worlds', additional_sources=['/etc'], continue_on_error=True)
    assert response.result.result == OK
    assert response.worlds
