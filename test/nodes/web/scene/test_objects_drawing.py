# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How objects of a planning scene are to be drawn."""

from geometry_msgs.msg import Pose, Vector3
from moveit_msgs.msg import CollisionObject
import numpy as np
import pytest
from shape_msgs.msg import Plane, SolidPrimitive
from simulation_interfaces.msg import Bounds
from std_msgs.msg import ColorRGBA

pytest.importorskip('viser')

from armsim_ros.model.geometry import Box, Cone, Cylinder, Sphere
from armsim_ros.nodes.web.objects_drawing import DrawnObject, Entity, geometries

GREY = ColorRGBA(r=0.5, g=0.5, b=0.5, a=1.0)


def box(*sides):
    """Return an object that is a box."""
    return CollisionObject(primitives=[SolidPrimitive(type=SolidPrimitive.BOX, dimensions=sides)])


@pytest.mark.parametrize('item', [
    CollisionObject(planes=[Plane(coef=[0.0, 0.0, 1.0, 0.0])]), box(10.0, 10.0, 0.1),
    box(0.2, 8.0, 4.0)], ids=['plane', 'floor', 'wall'])
def test_floors_and_walls_hide_nothing(item):
    """The page's own floor is seen through them, whatever their colour."""
    assert DrawnObject(item, '', GREY).opacity < 0.5


def test_a_table_is_solid():
    """It has the opacity of its colour."""
    assert DrawnObject(box(3.0, 1.0, 0.05), '', GREY).opacity is None
    assert DrawnObject(box(3.0, 1.0, 0.05), '', ColorRGBA(a=0.5)).opacity == 0.5


def test_primitives_have_their_shapes():
    """The height of a cylinder and of a cone comes before its radius (SolidPrimitive.msg)."""
    item = CollisionObject(primitives=[
        SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.1, 0.2, 0.3]),
        SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.1]),
        SolidPrimitive(type=SolidPrimitive.CYLINDER, dimensions=[0.3, 0.1]),
        SolidPrimitive(type=SolidPrimitive.CONE, dimensions=[0.4, 0.2])])
    item.primitive_poses = [Pose() for _ in item.primitives]
    assert [shape for shape, _ in geometries(item)] == [
        Box((0.1, 0.2, 0.3)), Sphere(0.1), Cylinder(0.1, 0.3), Cone(0.2, 0.4)]


def test_an_entity_is_as_large_as_its_bounds():
    """Whichever corner the simulator sends first."""
    corners = [Vector3(x=0.3, y=0.2, z=0.1), Vector3(x=-0.1)]
    for points in (corners, corners[::-1]):
        bounds = Bounds(type=Bounds.TYPE_BOX, points=points)
        middle, sides = Entity('cube', 'world', Pose(), bounds).box()
        np.testing.assert_allclose(middle, (0.1, 0.1, 0.05))
        np.testing.assert_allclose(sides, (0.4, 0.2, 0.1))
