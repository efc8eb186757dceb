# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Obstacles, carried objects and permitted collisions as a user of pymoveit2 handles them."""

from __future__ import annotations

from typing import Any

from arm_user import distance, TIMEOUT, until, xyz
from pymoveit2 import MoveIt2
import pytest
from shape_msgs.msg import SolidPrimitive

UPRIGHT = (0.0, 0.0, 0.0, 1.0)
FAR = (0.0, -0.9, 0.2)


def world(arm: MoveIt2) -> dict[str, Any]:
    """Return the objects of the world by name."""
    assert arm.update_planning_scene(5.0)
    return {item.id: item for item in arm.planning_scene.world.collision_objects}


def carried(arm: MoveIt2) -> dict[str, Any]:
    """Return the attached objects by name."""
    assert arm.update_planning_scene(5.0)
    state = arm.planning_scene.robot_state
    return {item.object.id: item for item in state.attached_collision_objects}


def ready(user: Any, arm: MoveIt2) -> list[float]:
    """Move to the named state and return it [rad]."""
    target = list(user.description.joint_positions('ready'))
    assert arm.move_to_configuration(target), arm.last_failure()
    assert arm.wait_until_executed(TIMEOUT), arm.last_failure()
    return target


def z_axis(pose: Any) -> tuple[float, float, float]:
    """Return the direction of a pose's z axis."""
    q = pose.orientation
    return (
        2.0 * (q.x * q.z + q.w * q.y),
        2.0 * (q.y * q.z - q.w * q.x),
        1.0 - 2.0 * (q.x * q.x + q.y * q.y),
    )


@pytest.mark.statement('PM-2', 'PM-7', 'SCN-1', 'SCN-4')
def test_primitives_come_move_and_go(planner: MoveIt2) -> None:
    """Box, sphere, cylinder and cone are added, one is moved, one removed."""
    planner.add_collision_box('box', (0.1, 0.2, 0.3), position=FAR, quat_xyzw=UPRIGHT)
    planner.add_collision_sphere('ball', 0.1, position=FAR)
    planner.add_collision_cylinder('rod', 0.4, 0.05, position=FAR, quat_xyzw=UPRIGHT)
    planner.add_collision_cone('cone', 0.3, 0.1, position=FAR, quat_xyzw=UPRIGHT)
    until(lambda: len(world(planner)) == 4, 'four objects')
    objects = world(planner)
    assert list(objects['box'].primitives[0].dimensions) == [0.1, 0.2, 0.3]
    assert objects['rod'].primitives[0].type == SolidPrimitive.CYLINDER
    assert list(objects['rod'].primitives[0].dimensions) == [0.4, 0.05]
    assert xyz(objects['ball'].pose.position) == pytest.approx(FAR)
    planner.move_collision('ball', (0.0, 0.9, 0.1), UPRIGHT)
    until(
        lambda: xyz(world(planner)['ball'].pose.position) == pytest.approx((0.0, 0.9, 0.1)),
        'the ball at its new place',
    )
    planner.remove_collision_object('cone')
    until(lambda: set(world(planner)) == {'box', 'ball', 'rod'}, 'the cone gone')


@pytest.mark.statement('PM-7', 'SCN-4')
def test_a_mesh_is_an_obstacle(user: Any, planner: MoveIt2) -> None:
    """A mesh, scaled by the client, is in the world and in the way."""
    trimesh = pytest.importorskip('trimesh')
    ready(user, planner)
    goal = list(user.description.joint_positions('left'))
    tip = planner.compute_fk(goal).pose.position
    planner.add_collision_mesh(
        None,
        'cube',
        position=xyz(tip),
        quat_xyzw=UPRIGHT,
        scale=0.1,
        mesh=trimesh.creation.box((1.0, 1.0, 1.0)),
    )
    until(lambda: 'cube' in world(planner), 'the mesh')
    assert len(world(planner)['cube'].meshes[0].triangles) == 12
    assert planner.plan(joint_positions=goal) is None


@pytest.mark.statement('PM-8', 'SCN-13')
def test_collisions_with_an_object_are_allowed_and_forbidden_again(
    user: Any, planner: MoveIt2
) -> None:
    """A goal inside a box is refused, planned once the box may be touched, then refused again."""
    ready(user, planner)
    goal = list(user.description.joint_positions('left'))
    tip = planner.compute_fk(goal).pose.position
    planner.add_collision_box('box', (0.1, 0.1, 0.1), position=xyz(tip), quat_xyzw=UPRIGHT)
    until(lambda: 'box' in world(planner), 'the box')
    assert planner.plan(joint_positions=goal) is None
    for allow in (True, False):
        future = planner.allow_collisions('box', allow)
        until(future.done, 'the answer')
        assert planner.process_allow_collision_future(future)
        assert (planner.plan(joint_positions=goal) is not None) == allow


@pytest.mark.statement('PM-4', 'PM-7', 'SCN-8', 'SCN-9', 'REQ-7')
def test_an_object_is_carried_and_put_down(user: Any, arm: MoveIt2) -> None:
    """Attach takes the box along; what the plan carries counts; detach leaves it there."""
    ready(user, arm)
    tip = arm.compute_fk()
    size = (0.04, 0.04, 0.04)
    arm.add_collision_box('box', size, pose=tip)
    until(lambda: 'box' in world(arm), 'the box')
    touch = ['finger1', 'finger2', 'l6', 'tool']
    arm.attach_collision_object('box', arm.end_effector_name, touch_links=touch)
    until(lambda: 'box' in carried(arm), 'the box on the arm')
    assert world(arm) == {}
    goal = list(user.description.joint_positions('left'))
    at_goal = arm.compute_fk(goal).pose.position
    assert arm.move_to_configuration(goal), arm.last_failure()
    assert arm.wait_until_executed(TIMEOUT), arm.last_failure()
    assert distance(arm, goal) < 0.01
    assert 'box' in carried(arm)
    arm.detach_collision_object('box')
    until(lambda: 'box' in world(arm), 'the box put down')
    assert xyz(world(arm)['box'].pose.position) == pytest.approx(xyz(at_goal), abs=5e-3)


@pytest.mark.statement('PM-4', 'REQ-7')
def test_what_is_carried_does_not_pass_through_walls(user: Any, planner: MoveIt2) -> None:
    """A goal where only the carried rod would hit a wall is refused."""
    goal = ready(user, planner)
    tip = planner.compute_fk()
    planner.add_collision_cylinder('rod', 0.5, 0.01, pose=tip)
    until(lambda: 'rod' in world(planner), 'the rod')
    planner.attach_collision_object(
        'rod', planner.end_effector_name, ['finger1', 'finger2', 'l6', 'l5', 'l4', 'tool']
    )
    until(lambda: 'rod' in carried(planner), 'the rod on the arm')
    turned = [0.6, *goal[1:]]
    assert planner.plan(joint_positions=turned) is not None
    there = planner.compute_fk(turned).pose
    ahead = [x + 0.2 * d for x, d in zip(xyz(there.position), z_axis(there), strict=True)]
    planner.add_collision_box('wall', (0.02,) * 3, position=tuple(ahead), quat_xyzw=UPRIGHT)
    until(lambda: 'wall' in world(planner), 'the wall')
    refused = planner.plan(joint_positions=turned) is None
    planner.detach_all_collision_objects()
    until(lambda: not carried(planner), 'nothing carried')
    planner.remove_collision_object('rod')
    until(lambda: 'rod' not in world(planner), 'the rod gone')
    assert refused
    assert planner.plan(joint_positions=turned) is not None


@pytest.mark.statement('PM-8', 'SCN-9')
def test_the_world_is_cleared_at_once(planner: MoveIt2) -> None:
    """clear_all_collision_objects empties the world; what was carried is put down by it."""
    for name in ('a', 'b', 'c'):
        planner.add_collision_box(name, (0.1, 0.1, 0.1), position=FAR, quat_xyzw=UPRIGHT)
    until(lambda: len(world(planner)) == 3, 'three boxes')
    planner.attach_collision_object('a')
    until(lambda: 'a' in carried(planner), 'one of them attached')
    for left in ({'a'}, set()):
        future = planner.clear_all_collision_objects(timeout_sec=5.0)
        until(future.done, 'the answer')
        assert planner.process_clear_all_collision_objects_future(future)
        assert set(world(planner)) == left
        assert carried(planner) == {}


@pytest.mark.statement('SRV-51')
def test_a_plan_goes_around_what_stands_in_its_way(user: Any, planner: MoveIt2) -> None:
    """A pole between two states: the plan avoids it and its execution succeeds."""
    goal = ready(user, planner)
    a, b = [-0.8, *goal[1:]], [0.8, *goal[1:]]
    assert planner.move_to_configuration(a)
    assert planner.wait_until_executed(TIMEOUT), planner.last_failure()
    tip = planner.compute_fk([0.0, *goal[1:]]).pose.position
    planner.add_collision_box('pole', (0.05, 0.05, 0.3), position=xyz(tip), quat_xyzw=UPRIGHT)
    until(lambda: 'pole' in world(planner), 'the pole')
    planner.allowed_planning_time = 3.0
    assert planner.move_to_configuration(b), planner.last_failure()
    assert planner.wait_until_executed(TIMEOUT), planner.last_failure()
    assert distance(planner, b) < 0.01
