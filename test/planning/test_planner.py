# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of planning from a request to a checked trajectory."""

from dataclasses import replace
import itertools
import math

import coal
import numpy as np
import pytest

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.geometry import Box, Sphere
from armsim_ros.model.robot_model import JointType
from armsim_ros.model.transforms import (
    matrix_from_axis_angle,
    pose_matrix,
    quat_xyzw_from_matrix,
)
from armsim_ros.planning.request import (
    Constraints,
    JointConstraint,
    MotionPlanRequest,
    OrientationConstraint,
    PositionConstraint,
    Region,
    StartState,
)
from armsim_ros.planning.scene import PlanningScene
from armsim_ros.planning.settings import PlanningSettings

SIX = tuple(f'axis{k}' for k in range(1, 7))
LEFT = (-0.9, 1.2, 0.3, 0.0, 0.5, 0.0)
RIGHT = (0.9, 1.2, 0.3, 0.0, 0.5, 0.0)


def joint_goal(values, names=SIX, tolerance=1e-4):
    """Return a goal for all joints, as clients send it."""
    return Constraints(tuple(
        JointConstraint(name, value, tolerance, tolerance)
        for name, value in zip(names, values, strict=True)))


def pose_goal(pose, link='tool', position=1e-4, angle=1e-3):
    """Return a goal for a link's pose in the base frame, as clients send it."""
    region = Region(Sphere(position), pose_matrix(pose[:3, 3]))
    return Constraints(
        position_constraints=(PositionConstraint(link, (region,), 'base'),),
        orientation_constraints=(OrientationConstraint(
            link, tuple(quat_xyzw_from_matrix(pose)), (angle,) * 3, 'base', 1),))


def request(goal, start=LEFT, **options):
    """Return a repeatable request for the six-axis arm."""
    options.setdefault('seed', 1)
    goals = goal if isinstance(goal, tuple) else (goal,)
    return MotionPlanRequest('arm', goals, StartState(SIX[:len(start)], tuple(start)), **options)


# ------------------------------------------------------------------ an independent judge


def poses(robot, positions):
    """Return the pose of every link, from the joints' definitions alone."""
    found = {robot.root_link: np.eye(4)}
    for name, joint in robot.joints.items():
        motion = np.eye(4)
        if joint.type in (JointType.REVOLUTE, JointType.CONTINUOUS):
            motion[:3, :3] = matrix_from_axis_angle(joint.axis, positions[name])
        elif joint.type is JointType.PRISMATIC:
            motion[:3, 3] = joint.axis * positions[name]
        found[joint.child] = found[joint.parent] @ joint.origin @ motion
    return found


def penetration(robot, positions, boxes):
    """Return how deep [m] the robot's boxes are in each other or in boxes of the world."""
    at = poses(robot, positions)
    solids = [
        (name, shape.geometry.size, at[name] @ shape.origin)
        for name, link in robot.links.items() for shape in link.collisions
    ] + [('', size, pose) for size, pose in boxes]
    deepest = 0.0
    for (one, size1, pose1), (two, size2, pose2) in itertools.combinations(solids, 2):
        if not (one or two) or tuple(sorted((one, two))) in robot.semantic.disabled_collisions:
            continue
        wanted, result = coal.DistanceRequest(), coal.DistanceResult()
        distance = coal.distance(
            coal.Box(*size1), coal.Transform3s(pose1[:3, :3], pose1[:3, 3]),
            coal.Box(*size2), coal.Transform3s(pose2[:3, :3], pose2[:3, 3]), wanted, result)
        deepest = max(deepest, -distance)
    return deepest


def between(trajectory, t):
    """Return the positions at a time as a controller interpolates: a quintic, solved here."""
    k = min(int(np.searchsorted(trajectory.times(), t, side='right')), len(trajectory.points) - 1)
    first, second = trajectory.points[k - 1], trajectory.points[k]
    h = second.time_from_start - first.time_from_start
    x = t - first.time_from_start
    system = np.array([
        [1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 2, 0, 0, 0],
        [h**p for p in range(6)], [p * h**(p - 1) if p else 0 for p in range(6)],
        [p * (p - 1) * h**(p - 2) if p > 1 else 0 for p in range(6)]])
    values = np.array([first.positions, first.velocities, first.accelerations,
                       second.positions, second.velocities, second.accelerations])
    return np.array([x**p for p in range(6)]) @ np.linalg.solve(system, values)


def judge(response, robot, boxes=(), samples=250):
    """Check a trajectory without any code that made it."""
    trajectory = response.trajectory
    times = np.linspace(0.0, trajectory.duration, samples)
    states = np.array([between(trajectory, t) for t in times])
    limits = [robot.joints[name].limits for name in trajectory.joint_names]
    for state in states:
        named = dict(zip(trajectory.joint_names, state, strict=True))
        assert penetration(robot, named, boxes) == 0.0
    assert np.all(states >= np.array([each.lower for each in limits]) - 1e-6)
    assert np.all(states <= np.array([each.upper for each in limits]) + 1e-6)
    step = times[1] - times[0]
    velocity = np.diff(states, axis=0) / step
    acceleration = np.diff(velocity, axis=0) / step
    assert np.all(np.abs(velocity).max(axis=0) <= [each.velocity * 1.01 for each in limits])
    assert np.all(
        np.abs(acceleration).max(axis=0) <= [each.acceleration * 1.02 for each in limits])
    assert np.diff(trajectory.times()).max() <= 0.1


WALL = ((0.05, 0.6, 0.9), (0.4, 0.0, 0.45))


@pytest.fixture
def wall(six_scene, add_box):
    """Return a scene in which a wall stands between LEFT and RIGHT."""
    add_box(six_scene, 'wall', *WALL)
    return six_scene


# ------------------------------------------------------------------ paths


def test_free_motion_is_the_straight_line(six_scene, plan_for, clock):
    """Where nothing is in the way the arm goes straight in joint space."""
    response = plan_for(six_scene).plan(request(joint_goal(RIGHT)), six_scene, clock=clock)
    assert response.success, response.message
    assert response.path_length == pytest.approx(1.8)
    positions = response.trajectory.positions()
    assert np.ptp(positions[:, 1:], axis=0).max() < 1e-9


def test_response_of_a_plan(six_scene, plan_for, clock):
    """REQ-17: joints of the group, start first at time 0, times increasing, rest at both ends."""
    response = plan_for(six_scene).plan(request(joint_goal(RIGHT)), six_scene, clock=clock)
    points = response.trajectory.points
    assert response.trajectory.joint_names == SIX
    assert points[0].time_from_start == 0.0
    assert np.diff(response.trajectory.times()).min() > 0.0
    assert points[0].positions == pytest.approx(LEFT)
    assert points[-1].positions == pytest.approx(RIGHT, abs=1e-9)
    for point in (points[0], points[-1]):
        assert not np.any(point.velocities)
    assert response.planning_time > 0.0
    assert response.trajectory_start == pytest.approx(dict(zip(SIX, LEFT, strict=True)))


@pytest.mark.parametrize('seed', range(4))
def test_around_a_wall(wall, plan_for, clock, seed):
    """ADP-8: a trajectory round an obstacle is free by a judge of its own, within all limits."""
    response = plan_for(wall).plan(request(joint_goal(RIGHT), seed=seed), wall, clock=clock)
    assert response.success, response.message
    judge(response, wall.robot, [(WALL[0], pose_matrix(WALL[1]))])


@pytest.mark.parametrize('planner', ['RRT', 'KPIECE', 'LBKPIECE', 'PRM', 'BITstar', 'RRTstar'])
def test_other_planners(wall, plan_for, clock, planner):
    """OMP-1: planners of other kinds solve it too."""
    response = plan_for(wall).plan(
        request(joint_goal(RIGHT), planner_id=planner, allowed_planning_time=0.1), wall,
        clock=clock)
    assert response.success, response.message
    judge(response, wall.robot, [(WALL[0], pose_matrix(WALL[1]))], samples=60)


def test_thin_obstacle_is_not_jumped(six_scene, add_box, plan_for, clock):
    """OMP-4: a plate of 1 mm between start and goal is not overlooked."""
    add_box(six_scene, 'plate', (0.4, 0.001, 0.9), (0.5, 0.0, 0.45))
    response = plan_for(six_scene).plan(request(joint_goal(RIGHT)), six_scene, clock=clock)
    assert response.success, response.message
    plate = ((0.4, 0.001, 0.9), pose_matrix((0.5, 0.0, 0.45)))
    judge(response, six_scene.robot, [plate], samples=400)
    assert response.path_length > 1.9


def test_same_seed_same_trajectory(wall, plan_for, clock):
    """OMP-7: the same seed, scene and request give the same trajectory to the last bit."""
    first, second = (
        plan_for(wall).plan(request(joint_goal(RIGHT), seed=5), wall, clock=clock)
        for _ in range(2))
    other = plan_for(wall).plan(request(joint_goal(RIGHT), seed=6), wall, clock=clock)
    assert np.array_equal(first.trajectory.positions(), second.trajectory.positions())
    assert np.array_equal(first.trajectory.times(), second.trajectory.times())
    assert not np.array_equal(first.trajectory.positions()[10], other.trajectory.positions()[10])


def test_seed_of_the_settings(wall, plan_for, clock):
    """OMP-7: ``planning_seed`` holds for requests without a seed."""
    settings = PlanningSettings(seed=3)
    first, second = (
        plan_for(wall, settings).plan(request(joint_goal(RIGHT), seed=-1), wall, clock=clock)
        for _ in range(2))
    assert np.array_equal(first.trajectory.positions(), second.trajectory.positions())


def test_best_of_several_attempts(wall, plan_for, clock):
    """REQ-4: of several attempts the shortest path is returned."""
    planner = plan_for(wall)
    one = planner.plan(request(joint_goal(RIGHT), seed=1), wall, clock=clock)
    many = planner.plan(
        request(joint_goal(RIGHT), seed=1, num_planning_attempts=6), wall, clock=clock)
    assert many.path_length <= one.path_length


def test_already_there(six_scene, plan_for, clock):
    """ADP-6: a goal that is the start gives one point at time 0."""
    response = plan_for(six_scene).plan(request(joint_goal(LEFT)), six_scene, clock=clock)
    assert response.success
    assert len(response.trajectory.points) == 1
    assert response.trajectory.duration == 0.0


def test_scaling_factors(six_scene, plan_for, clock):
    """REQ-6: speed and acceleration follow their factors."""
    response = plan_for(six_scene).plan(
        request(joint_goal(RIGHT), max_velocity_scaling_factor=0.25,
                max_acceleration_scaling_factor=0.1), six_scene, clock=clock)
    velocities = np.abs([point.velocities for point in response.trajectory.points])
    accelerations = np.abs([point.accelerations for point in response.trajectory.points])
    assert 0.7 < velocities.max() <= 0.751
    assert 0.78 < accelerations.max() <= 0.801


@pytest.mark.parametrize('factor', [0.0, -1.0, 1.5, math.nan])
def test_impossible_scaling_factors_count_as_one(six_scene, plan_for, clock, log, factor):
    """REQ-6: values outside (0, 1] count as 1, with a warning."""
    response = plan_for(six_scene).plan(
        request(joint_goal(RIGHT), max_velocity_scaling_factor=factor), six_scene, clock=clock)
    velocities = np.abs([point.velocities for point in response.trajectory.points])
    assert velocities.max() == pytest.approx(3.0, rel=0.01)
    assert 'max_velocity_scaling_factor' in log.recorder.text()


def test_link_speed_limit(six, six_scene, plan_for, clock):
    """REQ-12: the limited link is no faster than max_cartesian_speed."""
    response = plan_for(six_scene).plan(
        request(joint_goal(RIGHT), max_cartesian_speed=0.2,
                cartesian_speed_limited_link='tool'), six_scene, clock=clock)
    times = np.linspace(0.0, response.trajectory.duration, 600)
    places = np.array([
        poses(six.robot, dict(zip(SIX, between(response.trajectory, t), strict=True)))['tool']
        for t in times])[:, :3, 3]
    speed = np.linalg.norm(np.diff(places, axis=0), axis=1) / (times[1] - times[0])
    assert 0.19 < speed.max() <= 0.202


# ------------------------------------------------------------------ goals


def test_pose_goal(six, six_scene, plan_for, clock):
    """CON-7: a pose goal is reached within its tolerances, by forward kinematics of its own."""
    wanted = poses(six.robot, dict(zip(SIX, (0.4, 0.9, 0.8, 0.3, 0.5, -0.2), strict=True)))['tool']
    response = plan_for(six_scene).plan(request(pose_goal(wanted)), six_scene, clock=clock)
    assert response.success, response.message
    end = dict(zip(SIX, response.trajectory.points[-1].positions, strict=True))
    reached = poses(six.robot, end)['tool']
    assert np.linalg.norm(reached[:3, 3] - wanted[:3, 3]) < 1e-4
    assert reached[:3, :3] == pytest.approx(wanted[:3, :3], abs=1e-3)


def test_pose_goal_for_another_link(six, six_scene, plan_for, clock):
    """CON-7: the constrained link may be any link fixed to the tip, or one before it."""
    wanted = poses(six.robot, dict(zip(SIX, (0.4, 0.9, 0.8, 0.3, 0.5, 0.0), strict=True)))
    response = plan_for(six_scene).plan(
        request(pose_goal(wanted['segment6'], 'segment6')), six_scene, clock=clock)
    assert response.success, response.message
    end = dict(zip(SIX, response.trajectory.points[-1].positions, strict=True))
    assert poses(six.robot, end)['segment6'] == pytest.approx(wanted['segment6'], abs=1e-3)


def test_position_goal(six, six_scene, plan_for, clock):
    """CON-7: a position alone leaves the orientation free."""
    region = Region(Sphere(1e-3), pose_matrix((0.4, 0.2, 0.5)))
    goal = Constraints(position_constraints=(PositionConstraint('tool', (region,), 'base'),))
    response = plan_for(six_scene).plan(request(goal), six_scene, clock=clock)
    assert response.success, response.message
    end = dict(zip(SIX, response.trajectory.points[-1].positions, strict=True))
    assert poses(six.robot, end)['tool'][:3, 3] == pytest.approx((0.4, 0.2, 0.5), abs=1e-3)


def test_orientation_goal(six, six_scene, plan_for, clock):
    """CON-7: an orientation alone leaves the position free."""
    goal = Constraints(orientation_constraints=(
        OrientationConstraint('tool', (1.0, 0.0, 0.0, 0.0), (0.01,) * 3, 'base'),))
    response = plan_for(six_scene).plan(request(goal), six_scene, clock=clock)
    assert response.success, response.message
    end = dict(zip(SIX, response.trajectory.points[-1].positions, strict=True))
    down = poses(six.robot, end)['tool'][:3, :3]
    assert down == pytest.approx(np.diag([1.0, -1.0, -1.0]), abs=0.02)


def test_goal_of_some_joints(six_scene, plan_for, clock):
    """CON-7: joints that the goal does not name stay where they are if they can."""
    response = plan_for(six_scene).plan(
        request(joint_goal((0.5,), ('axis1',))), six_scene, clock=clock)
    assert response.trajectory.points[-1].positions == pytest.approx((0.5, *LEFT[1:]), abs=1e-9)


def test_wide_joint_goal_is_met_in_its_middle(six_scene, plan_for, clock):
    """CON-7: a goal for all joints is met at its positions where these are free."""
    response = plan_for(six_scene).plan(
        request(joint_goal(RIGHT, tolerance=0.05)), six_scene, clock=clock)
    assert response.trajectory.points[-1].positions == pytest.approx(RIGHT, abs=1e-9)


def test_wide_joint_goal_with_its_middle_blocked(six_scene, add_box, plan_for, clock):
    """CON-7: where the middle collides another state of the box is taken."""
    planner = plan_for(six_scene)
    model = six_scene.kinematic_model
    middle = model.vector(dict(zip(SIX, RIGHT, strict=True)))
    tip = model.link_pose(middle, 'tool')[:3, 3]
    add_box(six_scene, 'block', (0.12, 0.12, 0.12), tip)
    assert not planner.check_state(six_scene, middle, 'arm').valid
    response = planner.plan(
        request(joint_goal(RIGHT, tolerance=0.5)), six_scene, clock=clock)
    assert response.success, response.message
    assert np.abs(response.trajectory.points[-1].positions - np.array(RIGHT)).max() <= 0.5


def test_goals_are_alternatives(wall, add_box, plan_for, clock):
    """REQ-8: of several goals one that is free is enough."""
    add_box(wall, 'block', (0.2, 0.2, 0.2), (0.45, 0.55, 0.4))
    goals = (joint_goal((0.9, 1.2, 0.3, 0.0, 0.5, 0.0)), joint_goal((1.6, 0.4, 0.3, 0, 0.5, 0)))
    response = plan_for(wall).plan(request(goals), wall, clock=clock)
    assert response.success, response.message


def test_continuous_joints_take_the_short_way(turning, plan_for, clock):
    """CON-1: a continuous joint turns the short way to its goal, over half a turn if need be."""
    scene = PlanningScene(KinematicModel(turning))
    names = ('axis1', 'axis2', 'axis3')
    response = plan_for(scene).plan(MotionPlanRequest(
        'arm', (joint_goal((-3.0, 0.5, 0.0), names),), StartState(names, (3.0, 0.5, 0.0)), seed=1),
        scene, clock=clock)
    assert response.success, response.message
    assert response.path_length == pytest.approx(2 * math.pi - 6.0, abs=1e-6)


# ------------------------------------------------------------------ path constraints


def test_orientation_is_kept_on_the_way(six, six_scene, plan_for, clock):
    """REQ-9: a path constraint on orientation holds all along the trajectory."""
    start = (-0.7, 0.6, 1.0, 0.0, math.pi - 1.6, 0.0)
    goal = (0.8, 0.9, 0.9, 0.0, math.pi - 1.8, 0.0)
    keep = Constraints(orientation_constraints=(
        OrientationConstraint('tool', (0.0, 1.0, 0.0, 0.0), (0.05, 0.05, 3.1416), 'base'),))
    response = plan_for(six_scene).plan(
        request(joint_goal(goal), start, path_constraints=keep), six_scene, clock=clock)
    assert response.success, response.message
    for t in np.linspace(0.0, response.trajectory.duration, 200):
        named = dict(zip(SIX, between(response.trajectory, t), strict=True))
        tilt = poses(six.robot, named)['tool'][:3, 2]
        assert math.acos(min(1.0, -tilt[2])) < 0.0725


def test_start_that_breaks_path_constraints(six_scene, plan_for, clock):
    """E5: a start that breaks the path constraints is refused with -11 and the constraint."""
    keep = Constraints((JointConstraint('axis1', 0.0, 0.1, 0.1),))
    response = plan_for(six_scene).plan(
        request(joint_goal(RIGHT), path_constraints=keep), six_scene, clock=clock)
    assert response.error_code == -11
    assert "'axis1' is at -0.9000" in response.message


def test_goal_that_breaks_path_constraints(six_scene, plan_for, clock):
    """A goal pose that no state within the path constraints reaches is refused with -13."""
    keep = Constraints(position_constraints=(PositionConstraint(
        'tool', (Region(Box((2.0, 1.0, 2.0)), pose_matrix((0.0, -0.5, 0.5))),), 'base'),))
    response = plan_for(six_scene).plan(
        request(joint_goal(RIGHT), path_constraints=keep), six_scene, clock=clock)
    assert response.error_code == -13
    assert "'tool'" in response.message


# ------------------------------------------------------------------ refusals


@pytest.mark.parametrize(('changes', 'code', 'words'), [
    ({'group_name': 'amr'}, -15, "did you mean 'arm'"),
    ({'group_name': ''}, -15, 'known groups: arm'),
    ({'pipeline_id': 'chomp'}, 99999, 'known: ompl'),
    ({'goal_constraints': ()}, -16, 'goal_constraints is empty'),
    ({'goal_constraints': (joint_goal((0.0,), ('elbow',)),)}, -16, "'elbow'"),
    ({'start_state': StartState(('axis1', 'axis2'), (0.0,))}, -17, ''),
    ({'start_state': StartState(('axis9',), (0.0,))}, -17, 'axis9'),
    ({'start_state': StartState(('axis1',), (math.nan,))}, -17, 'axis1'),
    ({'start_state': StartState(('axis1',), (3.2,))}, -26, "'axis1' starts at 3.20000"),
    ({'has_trajectory_constraints': True}, -1, 'trajectory_constraints'),
    ({'max_cartesian_speed': 0.1, 'cartesian_speed_limited_link': 'tol'}, -18, "'tol'"),
])
def test_wrong_requests(six_scene, plan_for, clock, log, changes, code, words):
    """E1, E2, E3, E6, E13: each mistake has its code and a sentence, and is logged."""
    response = plan_for(six_scene).plan(
        replace(request(joint_goal(RIGHT)), **changes), six_scene, clock=clock)
    assert response.error_code == code
    assert words in response.message
    assert response.source
    assert not response.trajectory.points
    assert response.message in log.recorder.text()


def test_start_in_collision(wall, add_box, plan_for, clock):
    """ADP-4: a colliding start is refused with -10 and the pair."""
    add_box(wall, 'crate', (0.3, 0.3, 0.3), (0.45, -0.55, 0.4))
    response = plan_for(wall).plan(request(joint_goal(RIGHT)), wall, clock=clock)
    assert response.error_code == -10
    assert "'crate'" in response.message


def test_goal_in_collision(wall, add_box, plan_for, clock):
    """E8: a goal whose states all collide is refused with -12 and the pair."""
    add_box(wall, 'crate', (0.3, 0.3, 0.3), (0.45, 0.55, 0.4))
    response = plan_for(wall).plan(request(joint_goal(RIGHT)), wall, clock=clock)
    assert response.error_code == -12
    assert "'crate'" in response.message


def test_pose_out_of_reach(six_scene, plan_for, clock):
    """E7: a pose that cannot be reached is refused with -31, naming link and place."""
    response = plan_for(six_scene).plan(
        request(pose_goal(pose_matrix((2.0, 0.0, 0.5)))), six_scene, clock=clock)
    assert response.error_code == -31
    assert "'tool' at [2.0, 0.0, 0.5]" in response.message


def test_no_way(six_scene, add_box, plan_for, clock):
    """E9: where no path exists the search ends at the allowed time with -6."""
    add_box(six_scene, 'fence', (0.02, 3.0, 3.0), (0.0, 0.0, 1.9), (0.0, 0.0, math.pi / 2))
    add_box(six_scene, 'front', (3.0, 0.02, 3.0), (0.0, 0.0, 1.9), (0.0, 0.0, math.pi / 2))
    start = (-0.8, 1.4, 0.2, 0.0, 0.5, 0.0)
    narrow = replace(
        request(joint_goal((0.8, 1.4, 0.2, 0.0, 0.5, 0.0)), start, allowed_planning_time=0.3),
        path_constraints=Constraints((JointConstraint('axis2', 1.4, 0.02, 0.02),)))
    add_box(six_scene, 'post', (0.02, 0.02, 1.0), (0.45, 0.0, 0.4))
    add_box(six_scene, 'plate', (0.5, 0.02, 1.0), (0.4, 0.0, 0.4))
    response = plan_for(six_scene).plan(narrow, six_scene, clock=clock)
    assert response.error_code == -6
    assert 'allowed_planning_time' in response.message


def test_cancel(wall, plan_for, clock):
    """E18: a cancelled request ends with -7."""
    asked = itertools.count()
    response = plan_for(wall).plan(
        request(joint_goal(RIGHT)), wall, clock=clock, cancelled=lambda: next(asked) > 20)
    assert response.error_code == -7
    assert not response.trajectory.points


def test_the_next_request_works_after_a_failure(wall, plan_for, clock):
    """ERR-2: failures leave nothing behind."""
    planner = plan_for(wall)
    planner.plan(request(joint_goal(RIGHT)), wall, clock=clock, cancelled=lambda: True)
    planner.plan(request(joint_goal((9.0,), ('elbow',))), wall, clock=clock)
    assert planner.plan(request(joint_goal(RIGHT)), wall, clock=clock).success


def test_the_scene_is_not_changed(wall, plan_for, clock):
    """REQ-7: a start state of a request is for that request only."""
    before = wall.content
    plan_for(wall).plan(request(joint_goal(RIGHT)), wall, clock=clock)
    assert wall.content is before


def test_start_a_little_beyond_a_limit(six_scene, plan_for, clock, log):
    """SEED-10: ``start_state_max_bounds_error`` lets a start be moved back to the limit."""
    settings = PlanningSettings(start_state_max_bounds_error=0.05)
    response = plan_for(six_scene, settings).plan(
        request(joint_goal(RIGHT), (2.93, *LEFT[1:])), six_scene, clock=clock)
    assert response.success
    assert response.trajectory.points[0].positions[0] == pytest.approx(2.9)
    assert 'beyond its limit' in log.recorder.text()


def test_missing_acceleration_limits_are_assumed(six, plan_for, clock, log):
    """BOOT-5: without acceleration limits 1 rad/s^2 is assumed, with one warning a joint."""
    robot = six.robot
    joints = {
        name: replace(joint, limits=replace(joint.limits, acceleration=math.inf))
        for name, joint in robot.joints.items()}
    scene = PlanningScene(KinematicModel(replace(robot, joints=joints)))
    planner = plan_for(scene)
    for _ in range(2):
        response = planner.plan(request(joint_goal(RIGHT)), scene, clock=clock)
    accelerations = np.abs([point.accelerations for point in response.trajectory.points])
    assert accelerations.max() == pytest.approx(1.0, rel=0.01)
    assert log.recorder.text().count('joints have no acceleration limit: axis1, axis2') == 1


# ------------------------------------------------------------------ other questions


def test_goal_reached(six_scene, plan_for):
    """ACT-4: whether the scene's state satisfies one of the goals."""
    planner = plan_for(six_scene)
    six_scene.set_positions(dict(zip(SIX, RIGHT, strict=True)))
    assert planner.goal_reached(request((joint_goal(LEFT), joint_goal(RIGHT))), six_scene)
    assert not planner.goal_reached(request(joint_goal(LEFT)), six_scene)


def test_rest_of_a_path_when_the_world_changes(six_scene, add_box, plan_for, clock):
    """ACT-7: only what is left of a trajectory is looked at."""
    planner = plan_for(six_scene)
    six_scene.set_positions(dict(zip(SIX, LEFT, strict=True)))
    trajectory = planner.plan(request(joint_goal(RIGHT)), six_scene, clock=clock).trajectory
    assert planner.path_fault(trajectory, 0.0, six_scene, 'arm') == ''
    add_box(six_scene, 'late', (0.2, 0.02, 0.2), (0.5, 0.0, 0.4))
    assert "'late'" in planner.path_fault(trajectory, 0.0, six_scene, 'arm').replace('"', "'") \
        or 'late' in planner.path_fault(trajectory, 0.0, six_scene, 'arm')
    assert planner.path_fault(trajectory, 0.8 * trajectory.duration, six_scene, 'arm') == ''
