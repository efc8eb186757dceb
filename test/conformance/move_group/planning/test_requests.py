# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a motion plan request means, and the code of each mistake in one."""

from __future__ import annotations

from itertools import pairwise
import math
import time
from typing import Any

from move_group_bench import name_of, seconds, xyz
from moveit_msgs.msg import Constraints, JointConstraint, RobotState
import pytest
from wire import at, box, joint_goal, pose_goal, robot_state, thing


def beyond(arm: Any) -> dict[str, float]:
    """Return a state whose first joint is 0.3 beyond its limit."""
    now = arm.positions()
    name = arm.group_joints[0]
    return {**{joint: now[joint] for joint in arm.group_joints}, name: arm.limits[name][1] + 0.3}


def wrap(arm: Any, state: Any) -> Any:
    """Return a box about the tip in a state."""
    pose = arm.pose(state)
    return thing('wrap', pose.header.frame_id, [box(0.02, 0.02, 0.02)], pose=pose.pose)


@pytest.mark.statement('REQ-1', 'E1')
@pytest.mark.parametrize('group', ['', 'no_such_group'])
def test_unknown_group(arm: Any, group: str) -> None:
    """An unknown or empty group is -15, and the message names it."""
    assert name_of(arm.refused(arm.near(), group_name=group)) == 'INVALID_GROUP_NAME'


@pytest.mark.statement('REQ-2', 'E2')
def test_unknown_pipeline(arm: Any) -> None:
    """An unknown pipeline is 99999, and the message lists those there are."""
    code = arm.refused(arm.near(), pipeline_id='chomp')
    assert name_of(code) == 'FAILURE'
    assert 'ompl' in code.message


@pytest.mark.statement('REQ-2')
def test_pipeline_by_name_and_by_default(arm: Any) -> None:
    """'' is the default pipeline, and it can be named."""
    for pipeline in ('', 'ompl'):
        arm.planned(arm.near(), pipeline_id=pipeline)


@pytest.mark.statement('REQ-3', 'M27')
@pytest.mark.parametrize('planner', [
    '', 'RRTConnect', 'RRTConnectkConfigDefault', '{group}[RRTConnect]', 'no_such_planner',
])
def test_planner_ids(arm: Any, planner: str) -> None:
    """Configurations of the group, alone and with its name, and unknown ids all plan."""
    arm.planned(arm.near(), planner_id=planner.format(group=arm.group))


@pytest.mark.statement('REQ-4', 'REQ-5')
@pytest.mark.parametrize(('attempts', 'time'), [(0, 5.0), (-1, 5.0), (4, 5.0), (1, 0.0), (1, -1)])
def test_attempts_and_times_that_are_none(arm: Any, attempts: int, time: float) -> None:
    """0 and negative numbers are replaced, not refused; planning_time is above 0."""
    answer = arm.plan(arm.near(), num_planning_attempts=attempts,
                      allowed_planning_time=float(time))
    assert name_of(answer.error_code) == 'SUCCESS'
    assert answer.planning_time > 0.0


@pytest.mark.statement('REQ-6', 'PM-3')
def test_scaling_factors(arm: Any) -> None:
    """A half of the speed takes longer; 0 and 2 count as 1."""
    goal = arm.near(0.6)
    durations = {
        factor: seconds(arm.planned(
            goal, max_velocity_scaling_factor=factor, max_acceleration_scaling_factor=factor
        ).points[-1].time_from_start)
        for factor in (1.0, 0.5, 0.0, 2.0, -1.0)
    }
    assert durations[0.5] > 1.3 * durations[1.0]
    for factor in (0.0, 2.0, -1.0):
        assert durations[factor] == pytest.approx(durations[1.0], rel=0.02)


@pytest.mark.statement('REQ-7')
def test_start_states(arm: Any) -> None:
    """Empty, diff with some joints, no diff with some joints, no diff with nothing."""
    now, name = arm.positions(), arm.group_joints[0]
    moved = now[name] + 0.3
    for start, first in (
        (RobotState(is_diff=True), now[name]),
        (robot_state({name: moved}), moved),
        (robot_state({name: moved}, is_diff=False), moved),
        (RobotState(is_diff=False), now[name]),
    ):
        trajectory = arm.planned(arm.near(), start_state=start)
        place = trajectory.joint_names.index(name)
        assert trajectory.points[0].positions[place] == pytest.approx(first, abs=5e-3)


@pytest.mark.statement('REQ-7', 'E13')
def test_start_states_that_are_none(arm: Any) -> None:
    """REQ-7e, f: lengths that differ and unknown joints are -17, by name."""
    start = robot_state({'no_such_joint': 0.0})
    code = arm.refused(arm.near(), start_state=start)
    assert name_of(code) == 'INVALID_ROBOT_STATE'
    assert 'no_such_joint' in code.message
    start = robot_state({arm.group_joints[0]: 0.0})
    start.joint_state.position = [0.0, 1.0]
    assert name_of(arm.refused(arm.near(), start_state=start)) == 'INVALID_ROBOT_STATE'


@pytest.mark.statement('REQ-8', 'E6')
@pytest.mark.parametrize('case', ['none', 'empty', 'unknown joint', 'negative tolerance'])
def test_goals_that_are_none(arm: Any, case: str) -> None:
    """No usable goal constraint is -16."""
    joint = JointConstraint(joint_name='no_such_joint')
    if case == 'negative tolerance':
        joint = JointConstraint(joint_name=arm.group_joints[0], tolerance_above=-1.0)
    goals = {'none': [], 'empty': [Constraints()]}.get(
        case, [Constraints(joint_constraints=[joint])]
    )
    assert name_of(arm.refused(goals)) == 'INVALID_GOAL_CONSTRAINTS'


@pytest.mark.statement('REQ-8')
def test_goals_are_alternatives(arm: Any) -> None:
    """A goal that cannot be used does not spoil the other one."""
    trajectory = arm.planned([Constraints(), joint_goal(arm.near())])
    assert trajectory.points


@pytest.mark.statement('REQ-9', 'E5')
def test_a_start_off_the_path_constraints(arm: Any) -> None:
    """-11, and the message names the constraint."""
    name = arm.group_joints[0]
    kept = joint_goal({name: arm.positions()[name] + 0.5}, 0.1)
    code = arm.refused(arm.near(), path_constraints=kept)
    assert name_of(code) == 'START_STATE_VIOLATES_PATH_CONSTRAINTS'
    assert name in code.message


@pytest.mark.statement('REQ-9', 'UT-2')
def test_path_constraints_hold_along_the_path(arm: Any) -> None:
    """Every point of the path keeps a joint's interval."""
    goal = arm.near(0.6)
    name = arm.group_joints[1]
    now = arm.positions()[name]
    goal[name] = now + 0.1
    trajectory = arm.planned(goal, path_constraints=joint_goal({name: now}, 0.15))
    place = trajectory.joint_names.index(name)
    assert all(abs(point.positions[place] - now) < 0.152 for point in trajectory.points)


@pytest.mark.statement('REQ-10')
def test_trajectory_constraints(arm: Any) -> None:
    """
    OMPL's pipeline plans without them, Pilz's refuses them.

    Upstream: planning_context_manager.cpp; pilz_industrial_motion_planner.cpp.
    """
    request = arm.request(arm.near())
    request.trajectory_constraints.constraints = [joint_goal(arm.near())]
    constrained = {'trajectory_constraints': request.trajectory_constraints}
    arm.planned(arm.near(), **constrained)
    answer = arm.refused(arm.near(), **constrained, planner_id='PTP',
                         pipeline_id='pilz_industrial_motion_planner')
    assert 'trajectory_constraints' in answer.message


@pytest.mark.statement('REQ-11', 'PM-3')
def test_the_workspace_does_not_limit_an_arm(arm: Any) -> None:
    """A tiny box, and one inside out, change nothing."""
    for low, high in ((-0.001, 0.001), (1.0, -1.0)):
        workspace = arm.request().workspace_parameters
        for axis in 'xyz':
            setattr(workspace.min_corner, axis, low)
            setattr(workspace.max_corner, axis, high)
        arm.planned(arm.near(), workspace_parameters=workspace)


@pytest.mark.statement('REQ-12')
def test_max_cartesian_speed(arm: Any) -> None:
    """The link is no faster than max_cartesian_speed [m/s] between any two points."""
    trajectory = arm.planned(arm.near(0.5), max_cartesian_speed=0.1,
                             cartesian_speed_limited_link=arm.tip)
    places = [
        (seconds(point.time_from_start), xyz(arm.pose(
            dict(zip(arm.group_joints, point.positions, strict=True))).pose.position))
        for point in trajectory.points]
    for (before, start), (after, end) in pairwise(places):
        assert math.dist(start, end) <= 0.103 * (after - before)


@pytest.mark.statement('REQ-13', 'REQ-18', 'RVZ-7', 'MGI-3')
def test_plan_only_does_not_move(arm: Any) -> None:
    """plan_only fills trajectory, start state and time, and the arm stays."""
    before = arm.positions()
    ended = arm.move(arm.near(0.4), plan_only=True)
    assert ended.code == 'SUCCESS'
    assert ended.result.planned_trajectory.joint_trajectory.points
    assert ended.result.planning_time > 0.0
    start = ended.result.trajectory_start
    assert not start.is_diff
    assert set(start.joint_state.name) >= set(arm.joints)
    assert not ended.result.executed_trajectory.joint_trajectory.points
    assert arm.positions() == pytest.approx(before, abs=2e-3)


@pytest.mark.statement('REQ-17', 'ADP-6')
def test_the_trajectory_is_legal(arm: Any) -> None:
    """Names, frame, times, rest at both ends, and the start where the robot is."""
    trajectory = arm.planned(arm.near(0.5))
    assert list(trajectory.joint_names) == arm.group_joints
    assert trajectory.header.frame_id == arm.frame
    assert (trajectory.header.stamp.sec, trajectory.header.stamp.nanosec) == (0, 0)
    times = [seconds(point.time_from_start) for point in trajectory.points]
    assert times[0] == 0.0
    assert all(a < b for a, b in pairwise(times))
    count = len(arm.group_joints)
    for point in trajectory.points:
        assert len(point.positions) == len(point.velocities) == len(point.accelerations) == count
        assert not point.effort
    now = arm.positions()
    assert list(trajectory.points[0].positions) == pytest.approx(
        [now[name] for name in trajectory.joint_names], abs=5e-3
    )
    for point in (trajectory.points[0], trajectory.points[-1]):
        assert list(point.velocities) == pytest.approx([0.0] * count, abs=1e-6)


@pytest.mark.statement('REQ-19', 'SRV-40', 'PM-5')
def test_the_planning_service(arm: Any) -> None:
    """plan_kinematic_path answers all parts and does not move."""
    before = arm.positions()
    answer = arm.plan(arm.near(0.4))
    assert name_of(answer.error_code) == 'SUCCESS'
    assert answer.group_name == arm.group
    assert answer.planning_time > 0.0
    assert set(answer.trajectory_start.joint_state.name) >= set(arm.joints)
    assert arm.positions() == pytest.approx(before, abs=2e-3)


@pytest.mark.statement('ADP-3', 'E3')
def test_a_start_beyond_the_limits(arm: Any) -> None:
    """-26, and the message names joint, value and limits."""
    code = arm.refused(arm.near(), start_state=robot_state(beyond(arm)))
    assert name_of(code) == 'START_STATE_INVALID'
    assert arm.group_joints[0] in code.message


@pytest.mark.statement('ADP-4', 'E4')
def test_a_start_in_collision(arm: Any) -> None:
    """-10, and the message names the pair."""
    arm.add(wrap(arm, None))
    code = arm.refused(arm.near(0.6))
    assert name_of(code) == 'START_STATE_IN_COLLISION'
    assert 'wrap' in code.message


@pytest.mark.statement('OMP-6', 'E8')
def test_a_goal_in_collision(arm: Any) -> None:
    """-12 when every goal state collides, and the message names the pair."""
    goal = arm.near(0.6)
    arm.add(wrap(arm, goal))
    code = arm.refused(goal)
    assert name_of(code) == 'GOAL_IN_COLLISION'
    assert 'wrap' in code.message


@pytest.mark.statement('OMP-6', 'E7')
def test_a_goal_out_of_reach(arm: Any) -> None:
    """-31 when no joint positions reach a pose."""
    pose = arm.pose()
    pose.pose.position.x += 50.0
    code = arm.refused(pose_goal(arm.tip, pose))
    assert name_of(code) in ('NO_IK_SOLUTION', 'GOAL_STATE_INVALID')


@pytest.mark.statement('E9', 'OMP-5')
def test_no_path_in_time(arm: Any) -> None:
    """A goal on the other side of an endless wall: -6 or -1 soon after the allowed time."""
    start, middle, goal = swing(arm)
    tip = arm.pose(middle).pose.position
    half = 0.5 * math.atan2(tip.y, tip.x)
    pose = at()
    pose.orientation.w, pose.orientation.z = math.cos(half), math.sin(half)
    arm.add(thing('wall', arm.frame, [box(8.0, 0.01, 8.0)], pose=pose))
    standing = {
        name for state in (start, goal) for contact in arm.validity(state, '').contacts
        for name in (contact.contact_body_1, contact.contact_body_2)
    } - {'wall'}
    assert arm.tip not in standing
    assert arm.allow('wall', standing)
    assert arm.validity(start, '').valid
    assert arm.validity(goal, '').valid
    began = time.monotonic()
    code = arm.refused(goal, start_state=robot_state(start), allowed_planning_time=0.3)
    assert time.monotonic() - began < 5.0
    assert name_of(code) in ('TIMED_OUT', 'PLANNING_FAILED')


def swing(arm: Any) -> list[dict[str, float]]:
    """Return three states that the first joint joins, with the arm off its axis."""
    now = arm.start
    bent = {joint: now[joint] for joint in arm.group_joints}
    for joint in arm.group_joints[1:3]:
        bent[joint] += 0.6
    first = arm.group_joints[0]
    return [{**bent, first: bent[first] + turn} for turn in (0.0, 0.4, 0.8)]


@pytest.mark.statement('OMP-1', 'CFG-7')
@pytest.mark.parametrize('planner', [
    'AnytimePathShortening', 'BFMT', 'BiEST', 'BiTRRT', 'BKPIECE', 'EST', 'FMT', 'KPIECE',
    'LazyPRM', 'LazyPRMstar', 'LazyRRT', 'LBKPIECE', 'LBTRRT', 'PDST', 'PRM', 'PRMstar',
    'ProjEST', 'RRT', 'RRTConnect', 'RRTstar', 'SBL', 'SPARS', 'SPARStwo', 'STRIDE', 'TRRT',
])
def test_planner_types(arm: Any, planner: str) -> None:
    """Every planner of the reference is understood, by its own name or the nearest one."""
    arm.planned(arm.near(), planner_id=planner, allowed_planning_time=2.0)


@pytest.mark.statement('OMP-4')
def test_a_thin_obstacle_is_not_jumped(arm: Any) -> None:
    """A plate of 1 mm in the way is gone round or refused, never passed through."""
    start, middle, goal = swing(arm)
    plate = thing('plate', arm.frame, [box(0.4, 0.001, 0.4)], pose=arm.pose(middle).pose)
    arm.add(plate)
    answer = arm.plan(goal, start_state=robot_state(start))
    if name_of(answer.error_code) == 'SUCCESS':
        trajectory = answer.trajectory.joint_trajectory
        for a, b in pairwise(trajectory.points):
            for part in (0.0, 0.25, 0.5, 0.75):
                state = {
                    joint: p + part * (q - p)
                    for joint, p, q in zip(
                        trajectory.joint_names, a.positions, b.positions, strict=True
                    )
                }
                assert arm.validity(state).valid
    else:
        assert 'plate' in answer.error_code.message


@pytest.mark.statement('OMP-7')
def test_plans_are_repeatable_with_a_seed(arm: Any) -> None:
    """The same scene, state and request give the same path."""
    assert arm.parameters.set('planning_seed', 5) == ''
    now = arm.start
    start = robot_state(now)
    bent = {name: now[name] + 0.9 for name in arm.group_joints[:3]}
    middle = arm.pose({name: now[name] + 0.45 for name in arm.group_joints[:3]}).pose
    arm.add(thing('ball', arm.frame, [box(0.1, 0.1, 0.1)], pose=middle))
    plans = [arm.planned(bent, start_state=start) for _ in range(2)]
    assert arm.parameters.set('planning_seed', -1) == ''
    assert plans[0] == plans[1]


@pytest.mark.statement('ERR-0.1', 'ERR-2')
def test_move_action_fails_with_message_and_source(arm: Any) -> None:
    """A failing goal of the action carries the sentence too, and no trajectory."""
    ended = arm.move(arm.near(), group_name='no_such_group', plan_only=True)
    assert ended.code == 'INVALID_GROUP_NAME'
    assert ended.result.error_code.message
    assert ended.result.error_code.source
    assert not ended.result.planned_trajectory.joint_trajectory.points
