# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The suction cup as a program of the seeds' users drives it."""

from __future__ import annotations

from geometry_msgs.msg import Pose
import numpy as np
import pytest
from scene_user import Planner
from simulation_interfaces.msg import EntityState
from std_msgs.msg import Bool
from std_srvs.srv import Empty
from world_user import OK, PAUSED, pose, WorldUser

from armsim_ros.clients.client_node import LATCHED
from armsim_ros.model.transforms import matrix_from_quat_wxyz

statement = pytest.mark.statement

GRIPPER = '/sunday/vacuum_gripper'
LIGHT = 'armsim://box?size=0.04,0.04,0.04&mass=0.1'
HEAVY = 'armsim://box?size=0.04,0.04,0.04&mass=2.5'


def before_the_cup(world: WorldUser, name: str, distance: float) -> None:
    """Put an object so far before the cup that looks along x of link_6 [m]."""
    state = EntityState(pose=pose((0.005 + distance + 0.02, 0.0, 0.0)))
    state.header.frame_id = 'link_6'
    assert world.result('set_entity_state', entity=name, state=state)[0] == OK


def place(one: Pose) -> tuple[float, float, float]:
    """Return the position of a pose [m]."""
    return one.position.x, one.position.y, one.position.z


def pose_in(frame: Pose, one: Pose) -> list[float]:
    """Return the position of a pose in a frame [m]; both are given in the world."""
    turn = frame.orientation
    rotation = matrix_from_quat_wxyz([turn.w, turn.x, turn.y, turn.z])
    return list(rotation.T @ np.subtract(place(one), place(frame)))


def switch(world: WorldUser, word: str) -> None:
    """Call a service of the gripper."""
    world.client.call(f'{GRIPPER}/{word}', Empty)


@statement('D4', 'C5')
def test_an_object_is_grasped_and_let_go(world: WorldUser) -> None:
    """Grasping is latched; in the scene it is attached, and let go it is an obstacle again."""
    planner = Planner(world)
    assert world.client.latched(f'{GRIPPER}/grasping', Bool).data is False
    grasping = world.client.collect(f'{GRIPPER}/grasping', Bool, LATCHED)
    world.spawn('light', uri=LIGHT)
    planner.wait(lambda objects: 'light' in objects)
    switch(world, 'on')
    before_the_cup(world, 'light', 0.002)
    grasping.wait_for(lambda message: message.data)
    planner.wait(lambda objects: 'light' not in objects)
    attached = planner.attached()
    assert attached['light'].link_name == 'link_6'
    assert 'link_6' in attached['light'].touch_links
    grasping.clear()
    switch(world, 'off')
    grasping.wait_for(lambda message: not message.data)
    planner.wait(lambda objects: 'light' in objects)
    assert 'light' not in planner.attached()
    grasping.close()


@statement('C5', 'D4')
def test_the_scene_has_what_is_held_and_let_go_where_it_is(world: WorldUser) -> None:
    """To a tenth of a millimetre: on the link that holds it, and in the world at once."""
    planner = Planner(world)
    grasping = world.client.collect(f'{GRIPPER}/grasping', Bool, LATCHED)
    world.spawn('light', uri=LIGHT)
    planner.wait(lambda objects: 'light' in objects)
    switch(world, 'on')
    before_the_cup(world, 'light', 0.002)
    grasping.wait_for(lambda message: message.data)
    planner.wait(lambda objects: 'light' not in objects)
    assert world.become(PAUSED)[0] == OK
    on_link = planner.attached()['light'].object
    assert on_link.header.frame_id == 'link_6'
    expected = pose_in(world.entity('sunday/link_6').pose, world.entity('light').pose)
    assert place(on_link.pose) == pytest.approx(expected, abs=1e-4)
    grasping.clear()
    switch(world, 'off')
    grasping.wait_for(lambda message: not message.data)
    planner.wait(lambda objects: 'light' in objects)
    assert place(planner.objects()['light'].pose) == pytest.approx(
        world.position('light'), abs=1e-4)
    grasping.close()


@statement('D5')
def test_what_is_too_heavy_is_lost(world: WorldUser) -> None:
    """One line of the log names force and limit; grasping becomes false."""
    grasping = world.client.collect(f'{GRIPPER}/grasping', Bool, LATCHED)
    lines = len(world.program.output)
    world.spawn('heavy', uri=HEAVY)
    switch(world, 'on')
    before_the_cup(world, 'heavy', 0.0)
    line = world.program.wait_for_line("lost 'heavy'", after=lines)
    assert 'holds 20 N' in line
    grasping.clear()
    assert not grasping.wait(2)[-1].data
    grasping.close()


@statement('A12', 'A19')
def test_what_is_held_can_be_deleted_and_reset(world: WorldUser) -> None:
    """It is let go first; a reset switches the vacuum off."""
    grasping = world.client.collect(f'{GRIPPER}/grasping', Bool, LATCHED)
    for name in ('first', 'second'):
        world.spawn(name, uri=LIGHT)
        switch(world, 'on')
        before_the_cup(world, name, 0.002)
        grasping.wait_for(lambda message: message.data)
        if name == 'first':
            assert world.result('delete_entity', entity=name)[0] == OK
        else:
            assert world.result('reset_simulation')[0] == OK
        grasping.clear()
        grasping.wait_for(lambda message: not message.data)
    grasping.close()
