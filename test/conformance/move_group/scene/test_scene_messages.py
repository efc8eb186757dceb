# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Scene messages as clients send them: part by part, whole scenes, and those that go back."""

from __future__ import annotations

import math
from typing import Any

from geometry_msgs.msg import TransformStamped
from moveit_msgs.msg import (
    AllowedCollisionEntry,
    CollisionObject,
    LinkPadding,
    LinkScale,
    ObjectColor,
    PlanningScene,
    PlanningSceneComponents,
)
import pytest
from scene_contents import contents
from wire import at, box, carried, quiet_diff, removal, thing

Part = PlanningSceneComponents


@pytest.mark.statement('M4', 'X6')
@pytest.mark.parametrize('kind', [
    'object', 'shape', 'operation', 'matrix', 'contradicting matrix', 'padding link', 'padding',
    'scale', 'frame', 'joint', 'joint value', 'link', 'attached frame',
])
def test_a_refused_part_changes_nothing_and_stops_no_other(
    arm: Any, log: Any, kind: str
) -> None:
    """
    What is wrong is named in one line of the log, success is false, and the rest is applied.

    moveit_core planning_scene.cpp, setPlanningSceneDiffMsg.
    """
    before, seen = contents(arm), len(log.output)
    scene = quiet_diff()
    crate = thing('crate', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0))
    bad = thing('nobody', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(3.0))
    tool = carried(thing('nobody', arm.tip, [box(0.01, 0.01, 0.01)], pose=at()), arm.tip)
    matrix = scene.allowed_collision_matrix
    if kind == 'object':
        scene.world.collision_objects = [removal('nobody')]
    elif kind in ('shape', 'operation'):
        scene.world.collision_objects = [bad]
        if kind == 'shape':
            bad.primitives[0].dimensions = [0.1, 0.0, 0.1]
        else:
            bad.operation = bytes([9])
    elif kind == 'matrix':
        matrix.entry_names = ['nobody', 'b']
        matrix.entry_values = [AllowedCollisionEntry(enabled=[True])]
    elif kind == 'contradicting matrix':
        matrix.entry_names = ['nobody', 'b', 'nobody']
        matrix.entry_values = [
            AllowedCollisionEntry(enabled=row)
            for row in ([False, True, False], [True, False, False], [False, False, False])
        ]
    elif kind == 'padding link':
        scene.link_padding = [LinkPadding(link_name='nobody', padding=0.1)]
    elif kind == 'padding':
        scene.link_padding = [LinkPadding(link_name=arm.tip, padding=-0.1)]
    elif kind == 'scale':
        scene.link_scale = [LinkScale(link_name=arm.tip, scale=0.0)]
    elif kind == 'frame':
        scene.fixed_frame_transforms = [TransformStamped(child_frame_id='the_moon')]
        scene.fixed_frame_transforms[0].header.frame_id = 'nobody'
    elif kind.startswith('joint'):
        name, value = ('nobody', 0.0) if kind == 'joint' else (arm.joints[0], math.nan)
        scene.robot_state.joint_state.name = [name]
        scene.robot_state.joint_state.position = [value]
    else:
        scene.robot_state.attached_collision_objects = [tool]
        if kind == 'link':
            tool.link_name = 'nobody'
        else:
            tool.object.header.frame_id = 'the_moon'
    scene.world.collision_objects.append(crate)
    scene.object_colors = [ObjectColor(id='crate')]
    assert not arm.apply(scene)
    assert set(arm.objects()) == {'crate'}
    assert [color.id for color in arm.scene(Part.OBJECT_COLORS).object_colors] == ['crate']
    log.wait_for_line('apply_planning_scene: ', after=seen)
    assert sum('apply_planning_scene: ' in line for line in log.output[seen:]) == 1
    assert arm.add(removal('crate'))
    assert contents(arm) == before


@pytest.mark.statement('M4', 'M40')
def test_what_may_be_there_is_removed_and_the_new_is_added(arm: Any) -> None:
    """
    A list of removals, some of which find nothing, and the additions after it.

    moveit_ros planning_scene_interface.cpp; robot_state.is_diff is false there.
    """
    crate = thing('crate', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0))
    other = thing('other', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(3.0))
    assert arm.add(crate)
    assert arm.attach(carried(
        thing('tool', arm.tip, [box(0.01, 0.01, 0.01)], pose=at()), arm.tip))
    scene = PlanningScene(is_diff=True)
    scene.world.collision_objects = [removal('nobody'), removal('crate'), removal('none'), other]
    assert not arm.apply(scene)
    assert set(arm.objects()) == {'other'}
    assert set(arm.attached()) == {'tool'}


@pytest.mark.statement('SRV-51')
def test_a_failed_attached_operation_is_no_success(arm: Any) -> None:
    """Attaching what is not there makes success false."""
    assert not arm.attach(carried(CollisionObject(id='nobody'), arm.tip))


@pytest.mark.statement('SRV-51', 'M5', 'M6')
def test_a_full_scene_replaces_all(arm: Any, rules: Any) -> None:
    """
    is_diff false replaces world, colours and rules; what is attached stays without joints.

    moveit_core planning_scene.cpp, setPlanningSceneMsg.
    """
    arm.add(thing('crate', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0)))
    arm.attach(carried(thing('tool', arm.tip, [box(0.01, 0.01, 0.01)], pose=at()), arm.tip))
    scene = PlanningScene(is_diff=False)
    scene.allowed_collision_matrix = rules.allowed_collision_matrix
    scene.world.collision_objects = [
        thing('other', arm.frame, [box(0.2, 0.1, 0.1)], pose=at(2.0))
    ]
    assert arm.apply(scene)
    assert set(arm.objects()) == {'other'}
    assert set(arm.attached()) == {'tool'}
    scene.robot_state = arm.scene(Part.ROBOT_STATE).robot_state
    assert arm.apply(scene)
    assert not arm.attached()


@pytest.mark.statement('M38')
def test_a_scene_goes_back_as_it_came(arm: Any) -> None:
    """
    The full scene that RViz publishes is that which it was given.

    moveit_ros motion_planning_frame_objects.cpp, publishScene.
    """
    arm.add(thing('crate', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0)))
    arm.attach(carried(thing('tool', arm.tip, [box(0.01, 0.01, 0.01)], pose=at()), arm.tip))
    before = contents(arm)
    assert arm.apply(arm.scene())
    assert contents(arm) == before
