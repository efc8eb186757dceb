# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planning scene through its services and topics, from outside."""

from __future__ import annotations

from typing import Any

from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, PlanningScene
from shape_msgs.msg import SolidPrimitive


def cube(name: str, frame: str = 'world', size: float = 0.05) -> CollisionObject:
    """Return a message that adds a cube."""
    item = CollisionObject(id=name, operation=CollisionObject.ADD)
    item.header.frame_id = frame
    item.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[size] * 3)]
    item.pose.position.x, item.pose.position.z = 0.6, 1.2
    item.pose.orientation.w = 1.0
    return item


def diff(*objects: CollisionObject) -> PlanningScene:
    """Return a scene diff with these objects."""
    scene = PlanningScene(is_diff=True)
    scene.robot_state.is_diff = True
    scene.world.collision_objects = list(objects)
    return scene


def names(scene: PlanningScene) -> list[str]:
    """Return the names of the objects of the world."""
    return [item.id for item in scene.world.collision_objects]


def test_apply_returns_when_the_scene_has_changed(stack: Any) -> None:
    """SRV-51: what was applied is there at once, and goes at once."""
    assert stack.apply(diff(cube('a'), cube('b')))
    assert names(stack.scene()) == ['a', 'b']
    gone = CollisionObject(id='a', operation=CollisionObject.REMOVE)
    assert stack.apply(diff(gone))
    assert names(stack.scene()) == ['b']


def test_geometry_and_poses_come_back_as_they_were_sent(stack: Any) -> None:
    """MGI-7: getObjects needs primitives and poses echoed back exactly."""
    assert stack.apply(diff(cube('a')))
    (item,) = stack.scene().world.collision_objects
    assert list(item.primitives[0].dimensions) == [0.05] * 3
    assert (item.pose.position.x, item.pose.position.z) == (0.6, 1.2)


def test_components_choose_what_is_answered(stack: Any) -> None:
    """SRV-50: names alone carry no geometry, the robot state alone no objects."""
    assert stack.apply(diff(cube('a')))
    (item,) = stack.scene(8).world.collision_objects
    assert item.id == 'a'
    assert not item.primitives
    scene = stack.scene(2)
    assert not scene.world.collision_objects
    assert set(scene.robot_state.joint_state.name) >= set(stack.states['home'])


def test_a_refused_object_leaves_the_scene_as_it_was(stack: Any) -> None:
    """SCN-2: an unknown frame or a shape without size is refused; what was there stays."""
    assert stack.apply(diff(cube('a')))
    assert not stack.apply(diff(cube('b', frame='nowhere')))
    flat = cube('c')
    flat.primitives[0].dimensions = [0.1, 0.0, 0.1]
    assert not stack.apply(diff(flat))
    assert names(stack.scene()) == ['a']


def test_an_object_is_attached_and_put_down_again(stack: Any) -> None:
    """SCN-8, SCN-9: attach takes the object out of the world, detach brings it back."""
    assert stack.apply(diff(cube('a')))
    attach = AttachedCollisionObject(link_name='link_6', touch_links=['link_6', 'link_5'])
    attach.object.id = 'a'
    attach.object.operation = CollisionObject.ADD
    scene = diff()
    scene.robot_state.attached_collision_objects = [attach]
    assert stack.apply(scene)
    now = stack.scene()
    assert names(now) == []
    assert [item.object.id for item in now.robot_state.attached_collision_objects] == ['a']
    attach.object.operation = CollisionObject.REMOVE
    assert stack.apply(scene)
    assert names(stack.scene()) == ['a']


def test_a_change_reaches_the_monitored_scene(stack: Any) -> None:
    """IF-40b: a world change is published on monitored_planning_scene."""
    monitored = stack.client.collect('/monitored_planning_scene', PlanningScene)
    publisher = stack.client.node.create_publisher(CollisionObject, '/collision_object', 10)
    while not publisher.get_subscription_count():
        pass
    publisher.publish(cube('seen'))
    message = monitored.wait_for(lambda scene: 'seen' in names(scene), 5.0)
    assert message.is_diff or 'seen' in names(message)
