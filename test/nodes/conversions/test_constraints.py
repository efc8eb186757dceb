# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Constraints as messages and as values."""

from geometry_msgs.msg import Pose
from moveit_msgs.msg import BoundingVolume, Constraints, PositionConstraint
import pytest
from shape_msgs.msg import Mesh, SolidPrimitive

from armsim_ros.errors import PlanningError
from armsim_ros.nodes.conversions.constraints import constraints_from_message

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
