# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects that the robot carries."""

from __future__ import annotations

from typing import Any

from move_group_bench import name_of, xyz
from moveit_msgs.msg import CollisionObject
import pytest
from wire import at, box, carried, detached, quiet_diff, removal, thing


def tool(arm: Any, name: str = 'tool', size: float = 0.02, reach: float = 0.3) -> Any:
    """Return a box in front of the tip."""
    return thing(name, arm.tip, [box(size, size, size)], pose=at(0.0, 0.0, reach))


@pytest.mark.statement('SCN-8')
def test_attach_with_geometry(arm: Any) -> None:
    """The object is on the link, and a world object of that id is gone."""
    arm.add(thing('tool', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0)))
    assert arm.attach(carried(tool(arm), arm.tip))
    assert not arm.objects()
    assert arm.attached()['tool'].link_name == arm.tip


@pytest.mark.statement('SCN-8', 'MGI-6')
def test_attach_by_id(arm: Any) -> None:
    """Without geometry the world's object is taken and keeps its place."""
    pose = arm.pose()
    place = xyz(pose.pose.position)
    arm.add(thing('cup', arm.frame, [box(0.02, 0.02, 0.02)],
                  pose=at(place[0] + 0.3, place[1], place[2])))
    assert arm.attach(carried(CollisionObject(id='cup'), arm.tip, [arm.tip]))
    assert not arm.objects()
    assert arm.attached()['cup'].touch_links == [arm.tip]
    where = xyz(arm.pose(link='cup').pose.position)
    assert where == pytest.approx((place[0] + 0.3, place[1], place[2]), abs=2e-3)


@pytest.mark.statement('SCN-8')
def test_what_cannot_be_attached(arm: Any) -> None:
    """An unknown object, an unknown link and MOVE are refused without effect."""
    arm.attach(carried(tool(arm), arm.tip))
    before = arm.attached()
    move = tool(arm)
    move.operation = CollisionObject.MOVE
    for item in (
        carried(CollisionObject(id='nobody'), arm.tip),
        carried(tool(arm, 'other'), 'third_hand'),
        carried(move, arm.tip),
    ):
        assert not arm.attach(item)
        assert arm.attached() == before


@pytest.mark.statement('SCN-8')
def test_attached_objects_are_replaced_and_extended(arm: Any) -> None:
    """The same id again replaces; APPEND adds shapes and touch links."""
    arm.attach(carried(tool(arm), arm.tip))
    arm.attach(carried(tool(arm, size=0.05), arm.tip))
    (shape,) = arm.attached()['tool'].object.primitives
    assert list(shape.dimensions) == pytest.approx([0.05] * 3)
    more = tool(arm)
    more.operation = CollisionObject.APPEND
    assert arm.attach(carried(more, arm.tip, [arm.tip]))
    found = arm.attached()['tool']
    assert len(found.object.primitives) == 2
    assert found.touch_links == [arm.tip]


@pytest.mark.statement('SCN-9')
def test_detach_puts_the_object_where_it_is(arm: Any) -> None:
    """REMOVE by id returns the object to the world at its present pose."""
    arm.attach(carried(tool(arm), arm.tip))
    place = xyz(arm.pose(link='tool').pose.position)
    assert arm.attach(detached('tool'))
    assert xyz(arm.objects()['tool'].pose.position) == pytest.approx(place, abs=2e-3)
    assert not arm.attached()


@pytest.mark.statement('SCN-9', 'PM-7', 'MGI-6')
def test_detach_by_link_and_all(arm: Any) -> None:
    """An empty id takes all from the link, an empty link too all; wrong ones are refused."""
    arm.attach(carried(tool(arm, 'a'), arm.tip), carried(tool(arm, 'b'), arm.tip))
    assert not arm.attach(detached('nobody'))
    assert not arm.attach(detached('a', arm.links[0]))
    assert set(arm.attached()) == {'a', 'b'}
    assert arm.attach(detached('', arm.tip))
    assert not arm.attached()
    arm.add(removal(''))
    arm.attach(carried(tool(arm, 'c'), arm.tip))
    assert arm.attach(detached())
    assert not arm.attached()


@pytest.mark.statement('SCN-10')
def test_touch_links(arm: Any) -> None:
    """A carried object collides with its own link unless that is a touch link."""
    inside = tool(arm, reach=0.0, size=0.1)
    arm.attach(carried(inside, arm.tip))
    report = arm.validity(arm.positions())
    assert not report.valid
    assert any('tool' in (one.contact_body_1, one.contact_body_2) for one in report.contacts)
    arm.attach(carried(inside, arm.tip, arm.links))
    assert arm.validity(arm.positions()).valid


@pytest.mark.statement('SCN-10a')
def test_a_hint_for_missing_touch_links(arm: Any, log: Any) -> None:
    """The log names the link to add, and nothing is exempted."""
    seen = len(log.output)
    arm.attach(carried(tool(arm, 'hinted', reach=0.0, size=0.1), arm.tip))
    log.wait_for_line(f"'hinted' touches the link '{arm.tip}'.*touch_links", after=seen)
    assert not arm.validity(arm.positions()).valid


@pytest.mark.statement('SCN-10')
def test_carried_objects_move_with_the_robot(arm: Any) -> None:
    """What is free here may collide there: the object goes along in every check."""
    arm.attach(carried(tool(arm), arm.tip, arm.links))
    there = next(iter(arm.states.values()))
    arm_pose = arm.pose(there, 'tool')
    arm.add(thing('wall', arm.frame, [box(0.02, 0.02, 0.02)], pose=arm_pose.pose))
    report = arm.validity(there)
    assert not report.valid
    assert {report.contacts[0].body_type_1, report.contacts[0].body_type_2} == {1, 2}


@pytest.mark.statement('SCN-11')
def test_weight_and_posture_come_back(arm: Any) -> None:
    """Weight and detach_posture are kept."""
    item = carried(tool(arm), arm.tip)
    item.weight = 1.5
    item.detach_posture.joint_names = [arm.joints[0]]
    arm.attach(item)
    found = arm.attached()['tool']
    assert (found.weight, found.detach_posture.joint_names) == (1.5, [arm.joints[0]])


@pytest.mark.statement('REQ-7', 'PM-4')
def test_a_start_state_keeps_what_the_robot_carries(arm: Any) -> None:
    """REQ-7c: joints with is_diff false do not drop the carried object."""
    arm.attach(carried(tool(arm), arm.tip, [arm.tip]))
    start = quiet_diff().robot_state
    now = arm.positions()
    start.joint_state.name = list(now)
    start.joint_state.position = list(now.values())
    start.is_diff = False
    answer = arm.plan(arm.near(), start_state=start)
    assert name_of(answer.error_code) == 'SUCCESS'
    assert len(answer.trajectory_start.attached_collision_objects) == 1


@pytest.mark.statement('SCN-7')
def test_subframes_stay_through_attach_and_detach(arm: Any) -> None:
    """A subframe of an object is a frame while it is carried and after."""
    item = tool(arm)
    item.subframe_names, item.subframe_poses = ['point'], [at(0.0, 0.0, 0.1)]
    arm.attach(carried(item, arm.tip))
    carried_at = xyz(arm.pose(link='tool/point').pose.position)
    arm.attach(detached('tool'))
    assert arm.add(thing('ring', 'tool/point', [box(0.1, 0.1, 0.1)], pose=at()))
    assert xyz(arm.objects()['ring'].pose.position) == pytest.approx(carried_at, abs=2e-3)
