# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Goals and path constraints of each kind."""

from __future__ import annotations

import math
from typing import Any

from geometry_msgs.msg import Quaternion
from move_group_bench import name_of, turn, xyz
from moveit_msgs.msg import Constraints, VisibilityConstraint
import pytest
from wire import (
    at,
    box,
    carried,
    joint_goal,
    orientation_goal,
    pose_goal,
    position_goal,
    robot_state,
    sphere,
    tetrahedron,
    thing,
)


def end(trajectory: Any) -> dict[str, float]:
    """Return the last state of a trajectory."""
    return dict(zip(trajectory.joint_names, trajectory.points[-1].positions, strict=True))


def elsewhere(arm: Any, step: float = 0.4) -> Any:
    """Return a pose of the tip that can be reached."""
    return arm.pose(arm.near(step))


@pytest.mark.statement('CON-1')
def test_joint_goals(arm: Any) -> None:
    """A joint ends within its tolerances."""
    goal = arm.near(0.3)
    reached = end(arm.planned(goal))
    assert reached == pytest.approx(goal, abs=1.1e-4)


@pytest.mark.statement('CON-1', 'M21')
def test_a_joint_goal_beyond_the_limit_is_clamped(arm: Any) -> None:
    """A target beyond the limits is the limit."""
    goal = arm.near(0.1)
    name = arm.group_joints[0]
    upper = arm.limits[name][1]
    reached = end(arm.planned({**goal, name: upper + 0.5}))
    assert reached[name] == pytest.approx(upper, abs=1e-3)


@pytest.mark.statement('CON-1', 'M18')
def test_an_unknown_joint_is_dropped_among_others(arm: Any) -> None:
    """The other constraints of the same goal count."""
    goal = joint_goal({**arm.near(0.3), 'no_such_joint': 1.0})
    assert end(arm.planned(goal)) == pytest.approx(arm.near(0.3), abs=5e-3)


@pytest.mark.statement('CON-2', 'CON-7')
@pytest.mark.parametrize('shape', [
    sphere(0.01), box(0.02, 0.02, 0.02), tetrahedron(0.03),
], ids=['sphere', 'box', 'mesh'])
def test_position_goals(arm: Any, shape: Any) -> None:
    """A position alone: the link ends in the region, turned as it likes."""
    pose = elsewhere(arm)
    goal = position_goal(arm.tip, pose)
    region = goal.constraint_region
    if hasattr(shape, 'triangles'):
        region.meshes, region.mesh_poses = [shape], region.primitive_poses
        region.primitives, region.primitive_poses = [], []
    else:
        region.primitives = [shape]
    reached = arm.pose(end(arm.planned(Constraints(position_constraints=[goal]))))
    assert math.dist(xyz(reached.pose.position), xyz(pose.pose.position)) < 0.05


@pytest.mark.statement('CON-2')
def test_several_regions_are_alternatives(arm: Any) -> None:
    """One region out of reach beside one in reach is no failure."""
    goal = position_goal(arm.tip, elsewhere(arm))
    goal.constraint_region.primitives = [sphere(0.01), *goal.constraint_region.primitives]
    goal.constraint_region.primitive_poses = [
        at(50.0), *goal.constraint_region.primitive_poses
    ]
    arm.planned(Constraints(position_constraints=[goal]))


@pytest.mark.statement('CON-2')
def test_target_point_offset(arm: Any) -> None:
    """The constrained point is the offset in the link's frame."""
    pose = elsewhere(arm)
    goal = position_goal(arm.tip, pose, 0.005)
    goal.target_point_offset.z = -0.05
    trajectory = arm.planned(Constraints(position_constraints=[goal]))
    state = end(trajectory)
    reached = offset_pose(arm, state, -0.05)
    assert math.dist(reached, xyz(pose.pose.position)) < 0.006


def offset_pose(arm: Any, state: Any, z: float) -> tuple[float, ...]:
    """Return where a point on the tip's z axis is in a state."""
    pose = arm.pose(state).pose
    q = pose.orientation
    axis = (
        2.0 * (q.x * q.z + q.w * q.y), 2.0 * (q.y * q.z - q.w * q.x),
        1.0 - 2.0 * (q.x * q.x + q.y * q.y),
    )
    return tuple(p + z * a for p, a in zip(xyz(pose.position), axis, strict=True))


@pytest.mark.statement('CON-2', 'M17', 'M18', 'M19')
@pytest.mark.parametrize('case', ['frame', 'link', 'region', 'pose'])
def test_position_goals_that_are_none(arm: Any, case: str) -> None:
    """Without frame, with an unknown link or without region nothing usable is left."""
    goal = position_goal(arm.tip, elsewhere(arm))
    if case == 'frame':
        goal.header.frame_id = ''
    elif case == 'link':
        goal.link_name = 'third_hand'
    else:
        goal.constraint_region.primitive_poses = []
        if case == 'region':
            goal.constraint_region.primitives = []
    code = arm.refused(Constraints(position_constraints=[goal]))
    assert name_of(code) == 'INVALID_GOAL_CONSTRAINTS'


@pytest.mark.statement('CON-3', 'CON-7')
@pytest.mark.parametrize('parameterization', [0, 1, 7])
def test_orientation_goals(arm: Any, parameterization: int) -> None:
    """The link ends turned as wanted, by either measure; an unknown one counts as Euler."""
    pose = elsewhere(arm)
    goal = orientation_goal(arm.tip, pose, 0.05)
    goal.parameterization = parameterization
    reached = arm.pose(end(arm.planned(Constraints(orientation_constraints=[goal]))))
    assert turn(reached.pose.orientation, pose.pose.orientation) < 0.1


@pytest.mark.statement('CON-3')
def test_a_quaternion_that_is_none_is_the_identity(arm: Any) -> None:
    """Not of length 1: a warning, and the identity."""
    pose = elsewhere(arm)
    pose.pose.orientation = Quaternion(x=0.0, y=0.0, z=0.0, w=0.0)
    goal = orientation_goal(arm.tip, pose, 0.05)
    reached = arm.pose(end(arm.planned(Constraints(orientation_constraints=[goal]))))
    assert turn(reached.pose.orientation, Quaternion(w=1.0)) < 0.1


@pytest.mark.statement('M15', 'M16')
@pytest.mark.parametrize('axis', [0, 1, 2])
def test_tolerances_are_about_the_axes_of_the_orientation(arm: Any, axis: int) -> None:
    """
    A link turned about an axis of its own is off by that axis' Euler angle alone.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::decide.
    """
    state = arm.near(0.4)
    pose = arm.pose(state)
    pose.pose.orientation = turned(pose.pose.orientation, axis, -0.4)
    goal = orientation_goal(arm.tip, pose, 0.01)
    goal.parameterization, goal.weight = goal.XYZ_EULER_ANGLES, 0.0
    setattr(goal, f'absolute_{"xyz"[axis]}_axis_tolerance', -0.5)
    report = arm.validity(state, constraints=Constraints(orientation_constraints=[goal]))
    assert report.constraint_result[0].result
    assert report.constraint_result[0].distance == pytest.approx(0.4, abs=1e-4)


def turned(q: Quaternion, axis: int, angle: float) -> Quaternion:
    """Return an orientation turned about an axis of its own."""
    x, y, z = (math.sin(0.5 * angle) if k == axis else 0.0 for k in range(3))
    w = math.cos(0.5 * angle)
    return Quaternion(
        x=q.w * x + q.x * w + q.y * z - q.z * y, y=q.w * y - q.x * z + q.y * w + q.z * x,
        z=q.w * z + q.x * y - q.y * x + q.z * w, w=q.w * w - q.x * x - q.y * y - q.z * z)


@pytest.mark.statement('CON-3')
def test_a_free_axis(arm: Any) -> None:
    """A tolerance of pi leaves the axis free."""
    goal = orientation_goal(arm.tip, arm.pose(), 0.1)
    goal.absolute_z_axis_tolerance = 3.14159
    spun = arm.near(0.3)
    kept = Constraints(orientation_constraints=[goal])
    report = arm.validity(spun, constraints=kept)
    assert len(report.constraint_result) == 1


@pytest.mark.statement('CON-7', 'MGI-2', 'UT-2')
def test_pose_goals(arm: Any) -> None:
    """Position and orientation of the tip, as MoveGroupInterface sends them."""
    pose = elsewhere(arm)
    reached = arm.pose(end(arm.planned(pose_goal(arm.tip, pose))))
    assert math.dist(xyz(reached.pose.position), xyz(pose.pose.position)) < 2e-3
    assert turn(reached.pose.orientation, pose.pose.orientation) < 0.03


@pytest.mark.statement('CON-7', 'UT-2')
def test_a_pose_goal_for_another_link(arm: Any) -> None:
    """A link fixed behind the tip can be the goal's link as well."""
    goal_state = arm.near(0.4)
    for link in reversed(arm.links):
        pose = arm.pose(goal_state, link)
        if xyz(pose.pose.position) != xyz(arm.pose(link=link).pose.position):
            break
    arm.planned(pose_goal(link, pose))


@pytest.mark.statement('CON-5', 'ADP-2', 'UT-2')
def test_goals_in_frames_of_links_and_objects(arm: Any) -> None:
    """A goal in an object's frame, and for a subframe of a carried object."""
    pose = elsewhere(arm)
    place = xyz(pose.pose.position)
    arm.add(thing('shelf', arm.frame, [box(0.01, 0.01, 0.01)],
                  pose=at(place[0], place[1], place[2] + 1.0)))
    goal = position_goal(arm.tip, pose)
    goal.header.frame_id = 'shelf'
    goal.constraint_region.primitive_poses = [at(0.0, 0.0, -1.0)]
    reached = arm.pose(end(arm.planned(Constraints(position_constraints=[goal]))))
    assert math.dist(xyz(reached.pose.position), place) < 3e-3


@pytest.mark.statement('CON-5', 'UT-2')
def test_a_goal_for_a_carried_objects_subframe(arm: Any) -> None:
    """Planning moves the subframe of an attached object to the pose."""
    item = thing('pen', arm.tip, [box(0.01, 0.01, 0.1)], pose=at(0.0, 0.0, 0.1))
    item.subframe_names, item.subframe_poses = ['point'], [at(0.0, 0.0, 0.05)]
    arm.attach(carried(item, arm.tip, arm.links))
    pose = arm.pose(arm.near(0.4), 'pen/point')
    reached = arm.pose(end(arm.planned(pose_goal('pen/point', pose))), 'pen/point')
    assert math.dist(xyz(reached.pose.position), xyz(pose.pose.position)) < 3e-3


@pytest.mark.statement('CON-6')
def test_joint_intervals_of_goal_and_path_are_intersected(arm: Any) -> None:
    """The goal ends where both hold."""
    name = arm.group_joints[0]
    now = arm.positions()[name]
    goal = joint_goal({name: now + 0.2}, 0.2)
    trajectory = arm.planned(goal, path_constraints=joint_goal({name: now}, 0.1))
    assert now - 1e-3 <= end(trajectory)[name] <= now + 0.1 + 1e-3


@pytest.mark.statement('UT-2', 'REQ-9', 'CON-3')
def test_an_orientation_kept_along_the_path(arm: Any) -> None:
    """The tip stays level to 0.1 rad while it goes elsewhere."""
    start = list(arm.states.values())[1]
    pose, goal = arm.pose(start), arm.pose(start)
    goal.pose.position.z -= 0.05
    kept = orientation_goal(arm.tip, pose, 0.1)
    trajectory = arm.planned(
        pose_goal(arm.tip, goal), start_state=robot_state(start),
        path_constraints=Constraints(orientation_constraints=[kept]),
    )
    for point in trajectory.points:
        state = dict(zip(trajectory.joint_names, point.positions, strict=True))
        assert turn(arm.pose(state).pose.orientation, pose.pose.orientation) < 0.1 * 3**0.5


@pytest.mark.statement('CON-8', 'SRV-20', 'M18', 'M20')
def test_constraint_results(arm: Any) -> None:
    """A result for each constraint: joints, positions, orientations; unusable ones hold."""
    state = arm.positions()
    state = {name: state[name] for name in arm.group_joints}
    pose = arm.pose()
    pose.pose.position.x += 0.5
    asked = joint_goal({'no_such_joint': 1.0, arm.group_joints[0]: state[arm.group_joints[0]]},
                       0.1)
    asked.position_constraints = [position_goal(arm.tip, pose)]
    asked.orientation_constraints = [orientation_goal(arm.tip, pose, 0.1)]
    report = arm.validity(state, constraints=asked)
    assert [one.result for one in report.constraint_result] == [True, True, False, True]
    assert report.constraint_result[2].distance == pytest.approx(0.5, abs=0.01)
    assert not report.valid


@pytest.mark.statement('CON-8')
def test_visibility_results(arm: Any) -> None:
    """
    A disc is visible past the link that carries it; below the robot it is hidden from above.

    Upstream: kinematic_constraint.cpp, VisibilityConstraint::decide.
    """
    seen = VisibilityConstraint(target_radius=0.01, cone_sides=8)
    seen.target_pose.header.frame_id = arm.tip
    seen.sensor_pose.header.frame_id = arm.tip
    seen.sensor_pose.pose.position.z = 0.2
    hidden = VisibilityConstraint(target_radius=0.3, cone_sides=8)
    for pose, height in ((hidden.target_pose, -0.5), (hidden.sensor_pose, 2.0)):
        pose.header.frame_id = arm.frame
        pose.pose.position.z = height
    report = arm.validity(list(arm.states.values())[1], constraints=Constraints(
        visibility_constraints=[seen, hidden]))
    assert [one.result for one in report.constraint_result] == [True, False]
    assert report.constraint_result[1].distance > 0.0
    assert not report.valid


@pytest.mark.statement('REQ-7')
def test_plans_from_elsewhere(arm: Any) -> None:
    """A start state given by name and value is where the path begins."""
    start = arm.near(0.4)
    trajectory = arm.planned(arm.positions(), start_state=robot_state(start))
    assert list(trajectory.points[0].positions) == pytest.approx(
        [start[name] for name in trajectory.joint_names], abs=1e-6
    )
