# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Constraints as messages and as values."""

from geometry_msgs.msg import Pose
from moveit_msgs.msg import BoundingVolume, Constraints, PositionConstraint, VisibilityConstraint
import pytest
from shape_msgs.msg import Mesh, SolidPrimitive

from armsim_ros.errors import PlanningError
from armsim_ros.model.geometry import Cylinder, Sphere
from armsim_ros.nodes.conversions.motion_plan_request import constraints_from_message

BALL = SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.1])


def converted(**region):
    """Return the only position constraint of a message."""
    message = PositionConstraint(constraint_region=BoundingVolume(**region))
    made, = constraints_from_message(Constraints(position_constraints=[message])
                                     ).position_constraints
    return made


@pytest.mark.parametrize(('region', 'reason'), [
    ({'primitives': [BALL, BALL], 'primitive_poses': [Pose()]}, 'no pose'),
    ({'primitives': [BALL, SolidPrimitive()], 'primitive_poses': [Pose(), Pose()]},
     'type 0 is not supported'),
    ({'primitives': [BALL, SolidPrimitive(type=1)], 'primitive_poses': [Pose(), Pose()]},
     'needs 3 dimensions'),
    ({'primitives': [BALL], 'primitive_poses': [Pose()], 'meshes': [Mesh()],
      'mesh_poses': [Pose()]}, 'no triangles'),
], ids=['pose', 'type', 'dimensions', 'mesh'])
def test_shapes_that_are_not_complete_are_left_out(region, reason):
    """
    A shape without a pose, dimensions or triangles is left out of a region; others count.

    Upstream: kinematic_constraint.cpp, PositionConstraint::configure.
    """
    made = converted(**region)
    assert len(made.regions) == 1
    assert reason in made.left_out[0]


def test_poses_without_a_shape_are_ignored():
    """
    Poses beyond the number of shapes mean nothing.

    Upstream: kinematic_constraint.cpp, PositionConstraint::configure.
    """
    made = converted(primitives=[BALL], primitive_poses=[Pose(), Pose()])
    assert (len(made.regions), made.left_out) == (1, ())


@pytest.mark.parametrize(('primitive', 'geometry'), [
    (SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.1, 0.0, 0.0]), Sphere(0.1)),
    (SolidPrimitive(type=SolidPrimitive.CYLINDER, dimensions=[0.2, 0.1, 0.0]),
     Cylinder(radius=0.1, length=0.2)),
])
def test_dimensions_that_a_shape_does_not_need_are_ignored(primitive, geometry):
    """
    Clients fill all three; only too few are an error.

    Upstream: geometric_shapes, shape_operations.cpp, constructShapeFromMsg.
    """
    made = converted(primitives=[primitive], primitive_poses=[Pose()])
    assert [region.shape for region in made.regions] == [geometry]


def test_dimensions_that_cannot_exist_are_refused():
    """A region with a negative dimension is refused, as upstream's shapes raise."""
    with pytest.raises(PlanningError, match='cannot have the dimensions'):
        converted(primitives=[SolidPrimitive(type=2, dimensions=[-0.1])], primitive_poses=[Pose()])


def test_a_region_with_a_zero_quaternion_is_not_turned():
    """
    An all-zero quaternion of a region's pose is the identity.

    Upstream: test_constraints.cpp, PositionConstraintsFixed.
    """
    nothing = Pose()
    nothing.orientation.w = 0.0
    (region,) = converted(primitives=[BALL], primitive_poses=[nothing]).regions
    assert region.pose.tolist() == [[float(i == k) for k in range(4)] for i in range(4)]


def test_every_field_of_a_visibility_constraint_counts():
    """Poses, their frames, radius, angles, sides and axis reach the planner."""
    message = VisibilityConstraint(
        target_radius=0.1, cone_sides=7, max_view_angle=0.2, max_range_angle=0.3,
        sensor_view_direction=VisibilityConstraint.SENSOR_X)
    message.target_pose.header.frame_id, message.sensor_pose.header.frame_id = 'disc', 'camera'
    message.target_pose.pose.position.x, message.sensor_pose.pose.position.y = 1.0, 2.0
    made, = constraints_from_message(
        Constraints(visibility_constraints=[message])).visibility_constraints
    assert (made.target_radius, made.cone_sides) == (0.1, 7)
    assert (made.max_view_angle, made.max_range_angle) == (0.2, 0.3)
    assert made.sensor_view_direction == 2
    assert (made.target_frame_id, made.sensor_frame_id) == ('disc', 'camera')
    assert (made.target_pose[0, 3], made.sensor_pose[1, 3]) == (1.0, 2.0)
