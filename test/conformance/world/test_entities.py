# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Entities: which there are, where they are, and how they are put elsewhere."""

from __future__ import annotations

import math

from geometry_msgs.msg import Twist, Vector3
import pytest
from simulation_interfaces.msg import (
    Bounds,
    EntityCategory,
    EntityFilters,
    EntityInfo,
    EntityState,
    TagsFilter,
)
from world_user import FAILED, NOT_FOUND, OK, pose, WorldUser

statement = pytest.mark.statement

ALL = ['cube', 'picture', 'star', 'sunday', 'table', 'triangle']
INVALID_POSE = 101


def chosen(world: WorldUser, **filters: object) -> list[str]:
    """Return the entities that pass a filter."""
    response = world.call('get_entities', filters=EntityFilters(**filters))
    assert response.result.result == OK, response.result.error_message
    return list(response.entities)


@statement('A1', 'A3', 'A4')
def test_entities_are_the_robot_and_the_objects(world: WorldUser) -> None:
    """Names come sorted; robot 1, fixed 5, free 0."""
    assert world.entities() == ALL
    for name, category in (('sunday', 1), ('table', 5), ('cube', 0)):
        assert world.call('get_entity_info', entity=name).info.category.category == category


@statement('A4')
def test_a_filter_is_an_expression_that_is_searched(world: WorldUser) -> None:
    """POSIX classes work, anchors are the user's, and all filters count together."""
    assert chosen(world, filter='abl') == ['table']
    assert chosen(world, filter='^[[:lower:]]u') == ['cube', 'sunday']
    fixed = [EntityCategory(category=5)]
    assert chosen(world, categories=fixed) == ['picture', 'table']
    assert chosen(world, categories=fixed, filter='t$|e$') == ['picture', 'table']
    assert chosen(world, categories=fixed, filter='^t') == ['table']


@statement('A1', 'A4')
@pytest.mark.parametrize('text', ['[', '(', 'a{2', '((a{255}){255}){255}', 'x' * 600])
def test_a_broken_filter_is_refused(world: WorldUser, text: str) -> None:
    """The code is OPERATION_FAILED, and the text says what is wrong."""
    for service in ('get_entities', 'get_entities_states'):
        code, words = world.result(service, filters=EntityFilters(filter=text))
        assert code == FAILED
        assert 'filter' in words


@statement('A4')
def test_entities_by_region_and_by_label(world: WorldUser) -> None:
    """Sphere and box choose what overlaps them; labels by any or all."""
    near = [Vector3(x=0.16, y=0.25, z=1.03), Vector3(x=0.02)]
    assert 'cube' in chosen(world, bounds=Bounds(type=3, points=near))
    assert 'triangle' not in chosen(world, bounds=Bounds(type=3, points=near))
    high = [Vector3(x=0.5, y=-0.5, z=1.8), Vector3(x=0.7, y=0.5, z=1.9)]
    assert chosen(world, bounds=Bounds(type=1, points=high)) == ['picture']
    assert chosen(world, bounds=Bounds(type=1, points=high[::-1])) == ['picture']
    code, _ = world.result('set_entity_info', entity='cube',
                           info=EntityInfo(description='red', tags=['food', 'red']))
    assert code == OK
    world.call('set_entity_info', entity='star', info=EntityInfo(tags=['food']))
    assert chosen(world, tags=TagsFilter(tags=['food', 'red'])) == ['cube', 'star']
    assert chosen(world, tags=TagsFilter(tags=['food', 'red'], filter_mode=1)) == ['cube']
    code, words = world.result(
        'get_entities', filters=EntityFilters(bounds=Bounds(type=1, points=near[:1])))
    assert code == FAILED
    assert '2' in words


@statement('A5')
def test_states_are_of_one_moment_in_the_world(world: WorldUser) -> None:
    """The frame is world, the stamp simulated time; all of a list have the same."""
    response = world.call('get_entities_states')
    assert list(response.entities) == ALL
    stamps = {(state.header.stamp.sec, state.header.stamp.nanosec) for state in response.states}
    assert len(stamps) == 1
    assert {state.header.frame_id for state in response.states} == {'world'}
    table = response.states[ALL.index('table')]
    assert table.pose.position.z == 0.0
    assert world.position('cube')[:2] == pytest.approx((0.16, 0.25), abs=2e-3)


@statement('A1')
def test_an_info_replaces_what_was_known(world: WorldUser) -> None:
    """
    Category, description and tags; a category that is none is refused.

    simulation_interfaces SetEntityInfo.srv, info.
    """
    for entity, category in (('table', 0), ('cube', 2), ('star', 4)):
        info = EntityInfo(category=EntityCategory(category=category), tags=['here'])
        assert world.result('set_entity_info', entity=entity, info=info)[0] == OK
        assert world.call('get_entity_info', entity=entity).info == info
    assert chosen(world, categories=[EntityCategory(category=2)]) == ['cube']
    code, words = world.result('set_entity_info', entity='table', info=EntityInfo(
        category=EntityCategory(category=3)))
    assert code == FAILED
    assert 'HUMAN (2)' in words


@statement('A3', 'A5')
def test_a_robots_pose_is_its_root_links_and_links_can_be_read(world: WorldUser) -> None:
    """The root link stands still; another link moves with the arm; it is not listed."""
    root = world.entity('sunday')
    assert root.twist == Twist()
    before = world.entity('sunday/link_6').pose.position
    goal = world.move(0.4)
    world.clock().wait(12)
    moving = world.entity('sunday/link_6').twist.linear
    assert math.hypot(moving.x, moving.y, moving.z) > 1e-3
    goal.result()
    after = world.entity('sunday/link_6').pose.position
    assert math.dist((before.x, before.y, before.z), (after.x, after.y, after.z)) > 0.01


@statement('A1', 'A5', 'A7', 'A12')
@pytest.mark.parametrize('service', [
    'get_entity_state', 'get_entity_info', 'get_entity_bounds', 'set_entity_state',
    'delete_entity', 'set_entity_info',
])
def test_an_unknown_entity_is_not_found(world: WorldUser, service: str) -> None:
    """The answer names those that there are, or the nearest."""
    code, words = world.result(service, entity='cub')
    assert code == NOT_FOUND
    assert "'cube'" in words


@statement('A6')
def test_an_entity_is_put_elsewhere_with_a_velocity(world: WorldUser) -> None:
    """Between two ticks; it flies on from there, and falls."""
    state = EntityState(pose=pose((1.0, 1.0, 2.0)))
    state.twist.linear.x = 0.5
    assert world.result('set_entity_state', entity='cube', state=state)[0] == OK
    placed = world.entity('cube')
    assert placed.pose.position.x >= 1.0
    assert placed.twist.linear.x == pytest.approx(0.5, abs=1e-3)
    world.clock().wait(2)
    assert world.entity('cube').acceleration.linear.z == pytest.approx(-9.8, abs=1e-6)


@statement('A6')
def test_frames_of_a_pose_are_links_and_entities(world: WorldUser) -> None:
    """The pose is meant in the frame that the header names."""
    assert world.become(2)[0] == OK
    for frame, expected in (('table', (0.1, 0.0, 2.0)), ('picture', (0.7, -0.1, 3.515))):
        state = EntityState(pose=pose((0.1, 0.0, 2.0)))
        state.header.frame_id = frame
        assert world.result('set_entity_state', entity='cube', state=state)[0] == OK
        assert world.position('cube') == pytest.approx(expected)
    state.header.frame_id = 'link_6'
    assert world.result('set_entity_state', entity='cube', state=state)[0] == OK


@statement('A6')
@pytest.mark.parametrize(('place', 'quaternion', 'frame'), [
    ((0, 0, math.nan), (0, 0, 0, 1), ''),
    ((0, 0, 1), (0, 0, 0, 1.02), 'world'),
    ((0, 0, 1), (0, 0, 0, 0), ''),
    ((0, 0, 1), (0, 0, 0, 1), 'nowhere'),
])
def test_a_wrong_pose_is_refused(
    world: WorldUser, place: object, quaternion: object, frame: str
) -> None:
    """INVALID_POSE with the reason; the object stays where it is."""
    before = world.position('picture')
    state = EntityState(pose=pose(place, quaternion))
    state.header.frame_id = frame
    code, words = world.result('set_entity_state', entity='picture', state=state)
    assert code == INVALID_POSE
    assert words
    assert world.position('picture') == before


@statement('A6')
def test_fixed_objects_move_but_have_no_velocity_and_robots_stay(world: WorldUser) -> None:
    """A fixed object may be put elsewhere; a twist for it, or a fixed robot, is refused."""
    state = EntityState(pose=pose((2.0, 0.0, 1.0)))
    assert world.result('set_entity_state', entity='picture', state=state)[0] == OK
    assert world.position('picture') == (2.0, 0.0, 1.0)
    state.twist.angular.z = 1.0
    assert world.result('set_entity_state', entity='picture', state=state)[0] == FAILED
    state.twist.angular.z = 0.0
    state.acceleration.linear.x = 1.0
    assert world.result('set_entity_state', entity='picture', state=state)[0] == FAILED
    code, words = world.result(
        'set_entity_state', entity='sunday', state=EntityState(pose=pose((0, 0, 1))))
    assert code == FAILED
    assert 'fixed' in words


@statement('A7')
def test_bounds_are_a_box_in_the_entitys_frame(world: WorldUser) -> None:
    """
    Of the cube its own measures; of the robot all its links; the upper corner comes first.

    simulation_interfaces Bounds.msg, TYPE_BOX.
    """
    bounds = world.call('get_entity_bounds', entity='cube').bounds
    assert bounds.type == Bounds.TYPE_BOX
    high, low = bounds.points
    assert (low.x, low.y, low.z) == pytest.approx((-0.04, -0.04, -0.0125), abs=1e-6)
    assert (high.x, high.y, high.z) == pytest.approx((0.04, 0.04, 0.0125), abs=1e-6)
    high, low = world.call('get_entity_bounds', entity='sunday').bounds.points
    assert high.z - low.z > 0.3
