# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects of the world that come into the way of a planned motion."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

from moveit_msgs.msg import MoveItErrorCodes
import pytest
from scene_user import Planner
from sensor_msgs.msg import JointState
from world_user import JOINTS, OK, PLAYING, WorldUser

from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.move_group import MoveGroupClient

statement = pytest.mark.statement

GROUP = 'manipulator'
BAR = 'armsim://box?size=0.1,0.1,0.1'
#: Stretched out; the arm turns by its first joint.
STRETCHED = dict(zip(JOINTS, (0.0, 0.4569, 0.4905, -0.5519, 1.57, 0.0), strict=True))
BEFORE, BETWEEN, BEHIND = ({**STRETCHED, 'joint_1': angle} for angle in (-1.0, 0.0, 1.0))


@pytest.fixture
def planner(world: WorldUser) -> Planner:
    """Give the planning scene of a world with a floor and no more."""
    assert world.result('load_world', uri='empty')[0] == OK
    assert world.become(PLAYING)[0] == OK
    planner = Planner(world)
    planner.wait(lambda objects: set(objects) == {'floor'})
    return planner


@statement('C3')
def test_what_comes_into_the_way_stops_a_motion(world: WorldUser, planner: Planner) -> None:
    """The result names it, nothing leads into it, and when it has gone the way is free."""
    arm = MoveGroupClient(world.client)
    assert arm.move(GROUP, BEFORE).error_code.val == SUCCESS
    place = arm.pose('link_6', BETWEEN, 'world')[:3, 3]
    states = world.client.collect('/sunday/joint_states', JointState)
    with ThreadPoolExecutor(1) as pool:
        moved = pool.submit(arm.move, GROUP, BEHIND, max_velocity_scaling_factor=0.05)
        states.wait_for(lambda one: one.position[one.name.index('joint_1')] > -0.95)
        world.spawn('bar', place, BAR)
        code = moved.result(60.0).error_code
    states.close()

    assert code.val == MoveItErrorCodes.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE
    assert "'bar'" in code.message
    assert not arm.valid(GROUP, BETWEEN)
    assert arm.plan(GROUP, BETWEEN).error_code.val != SUCCESS
    assert world.result('delete_entity', entity='bar')[0] == OK
    planner.wait(lambda objects: 'bar' not in objects)
    assert arm.move(GROUP, BETWEEN).error_code.val == SUCCESS
