# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Messages as the known clients fill them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from geometry_msgs.msg import Point, Pose, Quaternion
from moveit_msgs.msg import (
    AttachedCollisionObject,
    CollisionObject,
    Constraints,
    JointConstraint,
    OrientationConstraint,
    PlanningScene,
    PositionConstraint,
    RobotState,
)
from shape_msgs.msg import Mesh, MeshTriangle, SolidPrimitive


def quiet_diff() -> PlanningScene:
    """Return a scene diff that changes nothing."""
    scene = PlanningScene(is_diff=True)
    scene.robot_state.is_diff = True
    return scene


def robot_state(positions: Mapping[str, float] | None, is_diff: bool = True) -> RobotState:
    """Return a robot state; of the present robot for None."""
    state = RobotState(is_diff=is_diff)
    if positions is not None:
        state.joint_state.name = list(positions)
        state.joint_state.position = [float(value) for value in positions.values()]
    return state


def joint_goal(positions: Mapping[str, float], tolerance: float = 1e-4) -> Constraints:
    """Return joint constraints as RViz sends them."""
    return Constraints(joint_constraints=[
        JointConstraint(
            joint_name=name, position=float(value), tolerance_above=tolerance,
            tolerance_below=tolerance, weight=1.0,
        )
        for name, value in positions.items()
    ])


def position_goal(link: str, pose: Any, radius: float = 1e-3) -> PositionConstraint:
    """Return a sphere about a stamped pose's position."""
    goal = PositionConstraint(header=pose.header, link_name=link, weight=1.0)
    goal.constraint_region.primitives = [sphere(radius)]
    goal.constraint_region.primitive_poses = [
        Pose(position=pose.pose.position, orientation=Quaternion(w=1.0))
    ]
    return goal


def orientation_goal(link: str, pose: Any, tolerance: float = 1e-2) -> OrientationConstraint:
    """Return a small rotation about a stamped pose's orientation."""
    return OrientationConstraint(
        header=pose.header, orientation=pose.pose.orientation, link_name=link, weight=1.0,
        absolute_x_axis_tolerance=tolerance, absolute_y_axis_tolerance=tolerance,
        absolute_z_axis_tolerance=tolerance, parameterization=1,
    )


def pose_goal(link: str, pose: Any) -> Constraints:
    """Return a pose goal as MoveGroupInterface sends it."""
    return Constraints(
        position_constraints=[position_goal(link, pose)],
        orientation_constraints=[orientation_goal(link, pose)],
    )


def box(*size: float) -> SolidPrimitive:
    """Return a box [m]."""
    return SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(size))


def sphere(radius: float) -> SolidPrimitive:
    """Return a sphere [m]."""
    return SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[radius])


def tetrahedron(size: float) -> Mesh:
    """Return a closed mesh with four triangles [m]."""
    corners = [(0.0, 0.0, 0.0), (size, 0.0, 0.0), (0.0, size, 0.0), (0.0, 0.0, size)]
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    return Mesh(
        vertices=[Point(x=x, y=y, z=z) for x, y, z in corners],
        triangles=[MeshTriangle(vertex_indices=list(face)) for face in faces],
    )


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Pose:
    """Return a pose without rotation [m]."""
    return Pose(position=Point(x=float(x), y=float(y), z=float(z)), orientation=Quaternion(w=1.0))


def thing(
    name: str, frame: str, shapes: Sequence[Any] = (), *, pose: Pose | None = None,
    poses: Sequence[Pose] = (), operation: bytes = CollisionObject.ADD,
) -> CollisionObject:
    """Return a collision object; meshes are recognized among the shapes."""
    item = CollisionObject(id=name, operation=operation)
    item.header.frame_id = frame
    if pose is not None:
        item.pose = pose
    item.primitives = [shape for shape in shapes if isinstance(shape, SolidPrimitive)]
    item.meshes = [shape for shape in shapes if isinstance(shape, Mesh)]
    places = list(poses)
    if item.meshes and not item.primitives:
        item.mesh_poses = places
    else:
        item.primitive_poses = places
    return item


def removal(name: str) -> CollisionObject:
    """Return the message that removes an object."""
    return CollisionObject(id=name, operation=CollisionObject.REMOVE)


def carried(
    item: CollisionObject, link: str, touch: Sequence[str] = ()
) -> AttachedCollisionObject:
    """Return the message that attaches an object."""
    return AttachedCollisionObject(object=item, link_name=link, touch_links=list(touch))


def detached(name: str = '', link: str = '') -> AttachedCollisionObject:
    """Return the message that puts an object down."""
    return AttachedCollisionObject(object=removal(name), link_name=link)
