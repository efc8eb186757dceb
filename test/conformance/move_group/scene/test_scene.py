# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The world: objects, rules, colours, padding, and what the scene services answer."""

from __future__ import annotations

import math
import os
from typing import Any

from geometry_msgs.msg import Pose, Quaternion, TransformStamped
from move_group_bench import xyz
from moveit_msgs.msg import CollisionObject, ObjectColor, PlanningSceneComponents
from moveit_msgs.srv import GetPlanningScene, LoadMap, SaveMap
import numpy as np
import pytest
from scene_contents import contents
from shape_msgs.msg import Plane, SolidPrimitive
from std_srvs.srv import Empty
from wire import at, box, carried, quiet_diff, removal, sphere, tetrahedron, thing

from armsim_ros.nodes.conversions.octomap import octomap_to_message
from armsim_ros.planning.scene.octomap import octomap_from_cells

Part = PlanningSceneComponents


@pytest.mark.statement('SRV-50')
def test_no_component_means_all(arm: Any) -> None:
    """0 asks for everything; the answer is no diff."""
    scene = arm.scene(0)
    assert not scene.is_diff
    assert scene.robot_model_name == arm.robot_name
    assert set(scene.robot_state.joint_state.name) >= set(arm.joints)
    assert scene.allowed_collision_matrix.entry_names
    assert scene.link_padding


@pytest.mark.statement('SRV-50', 'RVZ-2')
def test_components_are_answered_alone(arm: Any) -> None:
    """Each bit brings its own part and no other."""
    arm.add(thing('crate', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0)))
    names = arm.scene(Part.WORLD_OBJECT_NAMES)
    assert [item.id for item in names.world.collision_objects] == ['crate']
    assert not names.world.collision_objects[0].primitives
    assert not names.robot_state.joint_state.name
    assert not names.robot_model_name
    both = arm.scene(Part.WORLD_OBJECT_NAMES | Part.WORLD_OBJECT_GEOMETRY)
    assert both.world.collision_objects[0].primitives
    assert not arm.scene(Part.ROBOT_STATE).world.collision_objects
    assert arm.scene(Part.ALLOWED_COLLISION_MATRIX).allowed_collision_matrix.entry_names


@pytest.mark.statement('SRV-50')
def test_attached_objects_have_a_bit_of_their_own(arm: Any) -> None:
    """Bit 2 alone leaves out what the robot carries, bit 4 brings joints and objects."""
    arm.attach(carried(thing('tool', arm.tip, [box(0.01, 0.01, 0.01)], pose=at()), arm.tip))
    alone = arm.scene(Part.ROBOT_STATE).robot_state
    assert alone.joint_state.name
    assert not alone.attached_collision_objects
    both = arm.scene(Part.ROBOT_STATE_ATTACHED_OBJECTS).robot_state
    assert both.joint_state.name
    assert len(both.attached_collision_objects) == 1


@pytest.mark.statement('SRV-51')
def test_apply_is_synchronous(arm: Any) -> None:
    """When apply returns, the next question sees the change."""
    for k in range(5):
        assert arm.add(thing(f'crate {k}', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0 + k)))
        assert f'crate {k}' in arm.objects()


@pytest.mark.statement('SRV-52')
def test_the_measured_state_wins(arm: Any) -> None:
    """Joints in a scene diff last until the next joint state."""
    scene = quiet_diff()
    name = arm.joints[0]
    now = arm.positions()[name]
    scene.robot_state.joint_state.name = [name]
    scene.robot_state.joint_state.position = [now + 0.5]
    arm.apply(scene)
    arm.joint_states.clear()
    arm.joint_states.wait(10)
    state = arm.scene(Part.ROBOT_STATE).robot_state.joint_state
    assert dict(zip(state.name, state.position, strict=True))[name] == pytest.approx(now, abs=0.01)


@pytest.mark.statement('SRV-53', 'RVZ-10')
def test_clear_octomap_answers(arm: Any) -> None:
    """Without an octomap the service answers all the same."""
    arm.client.call(arm.name('clear_octomap'), Empty)


# ---------------------------------------------------------------- objects


@pytest.mark.statement('SCN-1', 'PM-7')
def test_add_append_move_remove(arm: Any) -> None:
    """The four operations of a collision object."""
    arm.add(thing('crate', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0)))
    arm.add(thing('crate', arm.frame, [sphere(0.05)], pose=at(2.0), poses=[at(0, 0, 0.2)],
                  operation=CollisionObject.APPEND))
    assert len(arm.objects()['crate'].primitives) == 2
    move = CollisionObject(id='crate', operation=CollisionObject.MOVE, pose=at(3.0))
    move.header.frame_id = arm.frame
    assert arm.add(move)
    assert xyz(arm.objects()['crate'].pose.position) == pytest.approx((3.0, 0.0, 0.0))
    assert arm.add(removal('crate'))
    assert not arm.objects()


@pytest.mark.statement('SCN-1')
def test_add_replaces(arm: Any) -> None:
    """ADD of an id that exists puts the new object in place of the old one."""
    arm.add(thing('crate', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0)))
    arm.add(thing('crate', arm.frame, [sphere(0.3)], pose=at(2.0)))
    (shape,) = arm.objects()['crate'].primitives
    assert shape.type == SolidPrimitive.SPHERE


@pytest.mark.statement('SCN-4', 'MGI-7')
@pytest.mark.parametrize(('kind', 'size'), [
    (SolidPrimitive.BOX, [0.1, 0.2, 0.3]), (SolidPrimitive.SPHERE, [0.1]),
    (SolidPrimitive.CYLINDER, [0.3, 0.1]), (SolidPrimitive.CONE, [0.3, 0.1]),
])
def test_primitives_come_back_as_they_went(arm: Any, kind: int, size: list[float]) -> None:
    """Type, dimensions and pose of a primitive are echoed."""
    shape = SolidPrimitive(type=kind, dimensions=size)
    assert arm.add(thing('it', arm.frame, [shape], pose=at(2.0, 0.5, 1.0)))
    found = arm.objects()['it']
    assert found.primitives[0].type == kind
    assert list(found.primitives[0].dimensions) == pytest.approx(size)
    assert xyz(found.pose.position) == pytest.approx((2.0, 0.5, 1.0))


@pytest.mark.statement('SCN-4', 'MGI-7')
def test_meshes_and_planes_come_back(arm: Any) -> None:
    """Vertices and triangles of a mesh, coefficients of a plane."""
    mesh = tetrahedron(0.2)
    ground = thing('ground', arm.frame)
    ground.planes, ground.plane_poses = [Plane(coef=[0.0, 0.0, 1.0, 2.0])], [at()]
    assert arm.add(thing('mesh', arm.frame, [mesh], pose=at(2.0)), ground)
    found = arm.objects()
    assert found['mesh'].meshes[0] == mesh
    assert list(found['ground'].planes[0].coef) == pytest.approx([0.0, 0.0, 1.0, 2.0])


@pytest.mark.statement('SCN-2', 'SCN-2a')
@pytest.mark.parametrize('case', [
    'no shape', 'unknown frame', 'no id', 'octomap', 'operation', 'more poses than shapes',
    'not finite', 'negative size', 'unknown prism',
])
def test_bad_objects_are_refused_and_change_nothing(arm: Any, case: str) -> None:
    """A refused message leaves even the object of the same id as it was."""
    arm.add(thing('crate', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0)))
    bad = thing('crate', arm.frame, [box(0.5, 0.5, 0.5)], pose=at(2.0))
    if case == 'no shape':
        bad.primitives = []
    elif case == 'unknown frame':
        bad.header.frame_id = 'the_moon'
    elif case == 'no id':
        bad.id = ''
    elif case == 'octomap':
        bad.id = '<octomap>'
    elif case == 'operation':
        bad.operation = bytes([9])
    elif case == 'more poses than shapes':
        bad.primitive_poses = [at(), at()]
    elif case == 'not finite':
        bad.pose.position.x = math.nan
    elif case == 'negative size':
        bad.primitives = [box(0.1, -0.1, 0.1)]
    else:
        bad.primitives = [SolidPrimitive(type=99, dimensions=[1.0])]
    before = contents(arm)
    assert not arm.add(bad)
    assert contents(arm) == before


@pytest.mark.statement('SCN-2')
def test_tolerable_objects_are_taken(arm: Any) -> None:
    """Fewer poses than shapes are filled up, a leading slash is stripped."""
    item = thing('two', f'/{arm.frame}', [box(0.1, 0.1, 0.1), sphere(0.1)], pose=at(2.0),
                 poses=[at(0, 0, 0.5)])
    assert arm.add(item)
    found = arm.objects()['two']
    assert len(found.primitive_poses) == 2
    assert xyz(found.primitive_poses[1].position) == (0.0, 0.0, 0.0)


@pytest.mark.statement('SCN-3')
def test_one_shape_without_object_pose_is_the_object(arm: Any) -> None:
    """The single shape's pose becomes the object's; an all-zero quaternion is the identity."""
    item = thing('it', arm.frame, [box(0.1, 0.1, 0.1)], poses=[at(2.0, 0.0, 1.0)])
    item.pose = Pose(orientation=Quaternion(w=0.0))
    assert arm.add(item)
    found = arm.objects()['it']
    assert xyz(found.pose.position) == pytest.approx((2.0, 0.0, 1.0))
    assert xyz(found.primitive_poses[0].position) == (0.0, 0.0, 0.0)
    assert found.pose.orientation.w == 1.0


@pytest.mark.statement('SCN-5')
def test_remove(arm: Any) -> None:
    """An unknown id is refused, an empty id removes all, with colours and rules."""
    scene = quiet_diff()
    scene.world.collision_objects = [
        thing('a', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0)),
        thing('b', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(3.0)),
    ]
    scene.object_colors = [ObjectColor(id='a')]
    scene.object_colors[0].color.g = scene.object_colors[0].color.a = 1.0
    assert arm.apply(scene)
    assert not arm.add(removal('nobody'))
    assert arm.add(removal(''))
    assert not arm.objects()
    assert not arm.scene().object_colors


@pytest.mark.statement('SCN-6', 'SCN-2a')
def test_move_rules(arm: Any) -> None:
    """MOVE of an unknown id, into an unknown frame or with too many poses has no effect."""
    arm.add(thing('crate', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0)))
    before = contents(arm)
    for item in (
        thing('nobody', arm.frame, pose=at(3.0), operation=CollisionObject.MOVE),
        thing('crate', 'the_moon', pose=at(3.0), operation=CollisionObject.MOVE),
        thing('crate', arm.frame, pose=at(3.0), poses=[at(), at()],
              operation=CollisionObject.MOVE),
    ):
        assert not arm.add(item)
        assert contents(arm) == before


@pytest.mark.statement('SCN-7', 'CON-5')
def test_subframes_are_frames(arm: Any) -> None:
    """A subframe 'object/name' is a frame, and moves with its object."""
    item = thing('cup', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(1.0))
    item.subframe_names, item.subframe_poses = ['handle'], [at(0.0, 0.2, 0.0)]
    assert arm.add(item)
    assert arm.add(thing('ring', 'cup/handle', [box(0.1, 0.1, 0.1)], pose=at(0.1)))
    objects = arm.objects()
    assert xyz(objects['ring'].pose.position) == pytest.approx((1.1, 0.2, 0.0), abs=1e-6)
    assert objects['cup'].subframe_names == ['handle']


@pytest.mark.statement('SCN-17')
def test_colours(arm: Any) -> None:
    """Colours by id come back with their component."""
    scene = quiet_diff()
    scene.world.collision_objects = [thing('a', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0))]
    scene.object_colors = [ObjectColor(id='a')]
    scene.object_colors[0].color.r, scene.object_colors[0].color.a = 1.0, 0.5
    assert arm.apply(scene)
    (found,) = arm.scene(Part.OBJECT_COLORS).object_colors
    assert (found.id, found.color.r, found.color.a) == ('a', 1.0, 0.5)


@pytest.mark.statement('SCN-18', 'CON-5')
def test_fixed_frames(arm: Any) -> None:
    """
    A transform from a frame to the planning frame makes a frame that objects may use.

    The frame's name is header.frame_id; moveit_core transforms.cpp, setTransform.
    """
    scene = quiet_diff()
    frame = TransformStamped(child_frame_id=arm.frame)
    frame.header.frame_id = 'table'
    frame.transform.translation.x = 2.0
    frame.transform.rotation.w = 1.0
    scene.fixed_frame_transforms = [frame]
    assert arm.apply(scene)
    assert arm.add(thing('cup', 'table', [box(0.1, 0.1, 0.1)], pose=at(0.5)))
    assert xyz(arm.objects()['cup'].pose.position) == pytest.approx((2.5, 0.0, 0.0))
    told = {one.header.frame_id: one for one in
            arm.scene(Part.TRANSFORMS).fixed_frame_transforms}
    assert told['table'].child_frame_id == told[arm.frame].child_frame_id == arm.frame
    assert told['table'].transform.translation.x == pytest.approx(2.0)


@pytest.mark.statement('SCN-19', 'SRV-53', 'IF-24')
def test_an_octomap_counts_until_it_is_cleared(arm: Any) -> None:
    """A client's map is part of the scene; damaged data is refused, the rest of it counts."""
    scene = quiet_diff()
    scene.world.octomap = octomap_to_message(octomap_from_cells(
        np.array([[0, 0, 5]]), np.ones(1, dtype=np.float32), 0.1, np.eye(4)), arm.frame)
    assert arm.apply(scene)
    held = arm.scene(Part.OCTOMAP).world.octomap
    assert (held.octomap.id, held.header.frame_id) == ('OcTree', arm.frame)
    assert list(held.octomap.data) == list(scene.world.octomap.octomap.data)
    scene.world.octomap.octomap.data = [1, 2, 3]
    scene.world.collision_objects = [thing('a', arm.frame, [box(0.1, 0.1, 0.1)], pose=at(2.0))]
    assert not arm.apply(scene)
    assert 'a' in arm.objects()
    assert arm.scene(Part.OCTOMAP).world.octomap.octomap.data == held.octomap.data
    name = f'octomap_test_{os.getpid()}.bt'
    saved = arm.client.call(arm.name('save_map'), SaveMap, SaveMap.Request(filename=name))
    arm.client.call(arm.name('clear_octomap'), Empty)
    assert not arm.scene(Part.OCTOMAP).world.octomap.octomap.data
    loaded = arm.client.call(arm.name('load_map'), LoadMap, LoadMap.Request(filename=name))
    assert saved.success
    assert loaded.success
    assert arm.scene(Part.OCTOMAP).world.octomap.octomap.data
    outside = LoadMap.Request(filename='/etc/passwd')
    assert not arm.client.call(arm.name('load_map'), LoadMap, outside).success
    arm.client.call(arm.name('clear_octomap'), Empty)


@pytest.mark.statement('SRV-50')
def test_unknown_bits_do_no_harm(arm: Any) -> None:
    """All bits at once are answered."""
    request = GetPlanningScene.Request()
    request.components.components = 2**32 - 1
    answer = arm.client.call(arm.name('get_planning_scene'), GetPlanningScene, request)
    assert answer.scene.robot_model_name == arm.robot_name
