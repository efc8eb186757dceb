# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sequences of Pilz commands over the wire."""

from __future__ import annotations

import copy
import math
from typing import Any

from motions import target, until_at_rest, until_moving
from move_group_bench import CANCELED, Feedback, name_of, SUCCEEDED, TIMEOUT, xyz
from moveit_msgs.action import MoveGroupSequence
from moveit_msgs.msg import DisplayTrajectory, MotionSequenceItem, MotionSequenceRequest
from moveit_msgs.srv import GetMotionSequence
import pytest
from wire import box, pose_goal, quiet_diff, removal, robot_state, thing

from armsim_ros.clients.action_client import PatientActionClient

PILZ = 'pilz_industrial_motion_planner'


@pytest.fixture
def start(arm: Any) -> Any:
    """Give a bent state."""
    return list(arm.states.values())[1]


@pytest.fixture(scope='module')
def action(running: Any) -> Any:
    """Return a client of sequence_move_group, and the feedback that it gives."""
    name = running.name('sequence_move_group')
    client = PatientActionClient(running.client.node, MoveGroupSequence, name)
    feedback = Feedback(running.client, name, MoveGroupSequence)
    assert client.wait_for_server(TIMEOUT)
    yield client, feedback
    running.client.in_executor(client.destroy)


def item(arm: Any, pose: Any, offset: tuple[float, ...], radius: float = 0.0,
         **fields: Any) -> MotionSequenceItem:
    """Return a slow LIN of the tip to a pose that is moved [m]."""
    there = copy.deepcopy(pose)
    for axis, value in zip('xyz', offset, strict=True):
        setattr(there.pose.position, axis, getattr(there.pose.position, axis) + value)
    return MotionSequenceItem(blend_radius=radius, req=arm.request(
        pose_goal(arm.tip, there), pipeline_id=PILZ, planner_id='LIN',
        max_velocity_scaling_factor=0.05, max_acceleration_scaling_factor=0.1, **fields,
    ))


def two_lines(arm: Any, pose: Any, radius: float, **fields: Any) -> MotionSequenceRequest:
    """Return a request for two lines with a right angle between them."""
    return MotionSequenceRequest(items=[
        item(arm, pose, (-0.05, -0.05, -0.02), radius, **fields),
        item(arm, pose, (-0.08, -0.02, -0.02)),
    ])


def planned(arm: Any, request: MotionSequenceRequest) -> Any:
    """Return the answer of plan_sequence_path, which plans in the default pipeline."""
    wanted = GetMotionSequence.Request(request=request)
    return arm.client.call(
        arm.name('plan_sequence_path'), GetMotionSequence, wanted, TIMEOUT
    ).response


def send(arm: Any, action: Any, request: MotionSequenceRequest, **options: Any) -> Any:
    """Return the handle of a goal of sequence_move_group."""
    goal = MoveGroupSequence.Goal(request=request)
    goal.planning_options.planning_scene_diff = quiet_diff()
    for name, value in options.items():
        setattr(goal.planning_options, name, value)
    handle = arm.client.result(action[0].send_goal_async(goal), TIMEOUT, 'answer to a goal')
    assert handle.accepted
    return handle


def run(arm: Any, action: Any, request: MotionSequenceRequest, **options: Any) -> Any:
    """Return the end of a goal of sequence_move_group, and its feedback."""
    return arm.ended(send(arm, action, request, **options), action[1])


@pytest.mark.statement('IF-25', 'PLZ-8')
@pytest.mark.parametrize('radius', [0.0, 0.015])
def test_a_sequence_is_one_trajectory(
    arm: Any, action: Any, start: Any, radius: float
) -> None:
    """From the start state given, through or past the corner, to the last goal."""
    pose = arm.pose(start)
    request = two_lines(arm, pose, radius, start_state=robot_state(start))
    answer = run(arm, action, request, plan_only=True).result.response
    assert name_of(answer.error_code) == 'SUCCESS', answer.error_code
    assert answer.planning_time > 0.0
    (trajectory,) = [one.joint_trajectory for one in answer.planned_trajectories]
    states = [dict(zip(trajectory.joint_names, point.positions, strict=True))
              for point in trajectory.points]
    assert states[0] == pytest.approx(start, abs=1e-6)
    began = dict(zip(answer.sequence_start.joint_state.name,
                     answer.sequence_start.joint_state.position, strict=True))
    assert {name: began[name] for name in start} == pytest.approx(start, abs=1e-6)
    corner = [value + step for value, step in
              zip(xyz(pose.pose.position), (-0.05, -0.05, -0.02), strict=True)]
    nearest = min(math.dist(xyz(arm.pose(state).pose.position), corner) for state in states)
    if radius:
        assert 1e-3 < nearest < radius
    else:
        assert nearest < 1e-3


@pytest.mark.statement('R25')
def test_each_motion_of_a_sequence_is_displayed(arm: Any, action: Any, start: Any) -> None:
    """
    display_planned_path gets one message for each motion, from where it begins.

    Upstream: command_list_manager.cpp, solveSequenceItems; display_motion_path.cpp.
    """
    shown = arm.client.collect(arm.name('display_planned_path'), DisplayTrajectory)
    shown.wait_after(lambda: arm.planned(arm.near()))
    shown.clear()
    request = two_lines(arm, arm.pose(start), 0.01, start_state=robot_state(start))
    run(arm, action, request, plan_only=True)
    first, second = shown.wait(2)
    shown.close()
    ends = [part.trajectory[0].joint_trajectory.points for part in (first, second)]
    assert ends[0][-1].positions == pytest.approx(ends[1][0].positions, abs=1e-6)


@pytest.mark.statement('PLZ-8')
def test_an_empty_sequence_is_a_success(arm: Any, action: Any) -> None:
    """Nothing to do is done."""
    answer = planned(arm, MotionSequenceRequest())
    assert name_of(answer.error_code) == 'SUCCESS'
    assert not answer.planned_trajectories
    assert run(arm, action, MotionSequenceRequest()).status == SUCCEEDED


@pytest.mark.statement('PLZ-8')
@pytest.mark.parametrize(('case', 'code'), [
    ('negative', 'INVALID_MOTION_PLAN'),
    ('last', 'INVALID_MOTION_PLAN'),
    ('overlap', 'INVALID_MOTION_PLAN'),
    ('start', 'INVALID_ROBOT_STATE'),
    ('unreachable', 'FAILURE'),
])
def test_codes(arm: Any, action: Any, start: Any, case: str, code: str) -> None:
    """Each mistake has its code and a sentence, and no trajectory comes with it."""
    pose = arm.pose(start)
    request = two_lines(arm, pose, 0.0, start_state=robot_state(start))
    first, second = request.items
    if case == 'negative':
        first.blend_radius = -0.01
    elif case == 'last':
        second.blend_radius = 0.01
    elif case == 'overlap':
        first.blend_radius = second.blend_radius = 0.04
        request.items = [first, second, item(arm, pose, (0.0, 0.0, 0.0))]
        for one in request.items:
            one.req.max_acceleration_scaling_factor *= 0.5
    elif case == 'start':
        second.req.start_state = robot_state(start)
    else:
        request.items = [first, item(arm, pose, (9.0, 0.0, 0.0))]
    answer = run(arm, action, request, plan_only=True).result.response
    assert name_of(answer.error_code) == code, answer.error_code
    assert answer.error_code.message
    assert not answer.planned_trajectories


@pytest.mark.statement('M36')
def test_the_service_plans_in_the_default_pipeline(arm: Any, start: Any) -> None:
    """
    plan_sequence_path does not use the pipeline of its first motion, here OMPL plans.

    pilz, move_group_sequence_service.cpp, plan.
    """
    request = two_lines(arm, arm.pose(start), 0.0, start_state=robot_state(start))
    for each in request.items:
        each.req.max_velocity_scaling_factor = 0.0  # -2 for LIN, 1 for OMPL
    answer = planned(arm, request)
    assert name_of(answer.error_code) == 'SUCCESS', answer.error_code
    assert len(answer.planned_trajectories) == 1
    assert answer.planning_time > 0.0


@pytest.mark.statement('IF-3')
def test_a_sequence_is_executed(arm: Any, action: Any, start: Any) -> None:
    """Planned, run to its last goal without a stop; feedback as of move_action."""
    assert arm.move(start).code == 'SUCCESS'
    pose = arm.pose()
    request = two_lines(arm, pose, 0.015)
    ended = run(arm, action, request, plan_only=True)
    assert (ended.status, ended.feedback) == (SUCCEEDED, ['PLANNING', 'IDLE'])
    ended = run(arm, action, request)
    code = ended.result.response.error_code
    assert (ended.status, name_of(code)) == (SUCCEEDED, 'SUCCESS'), code
    assert ended.feedback == ['PLANNING', 'MONITOR', 'IDLE']
    goal = request.items[1].req.goal_constraints[0].position_constraints[0]
    wanted = goal.constraint_region.primitive_poses[0].position
    assert math.dist(xyz(arm.pose().pose.position), xyz(wanted)) < 5e-3


@pytest.mark.statement('ACT-6', 'REQ-15')
def test_a_sequence_is_planned_again(home: Any, action: Any) -> None:
    """
    With replan a sequence stops at what appears on its way, and is planned again.

    Upstream: move_group_sequence_action.cpp, executeSequenceCallbackPlanAndExecute.
    """
    goal = target(home)
    request = home.request(
        goal, pipeline_id=PILZ, planner_id='PTP', max_velocity_scaling_factor=0.08,
        max_acceleration_scaling_factor=0.3)
    handle = send(
        home, action, MotionSequenceRequest(items=[MotionSequenceItem(req=request)]),
        replan=True, replan_attempts=4, replan_delay=2.5)
    until_moving(home)
    place = home.pose(goal)
    home.add(thing('late', place.header.frame_id, [box(0.02, 0.02, 0.02)], pose=place.pose))
    until_at_rest(home)
    home.add(removal('late'))
    ended = home.ended(handle)
    assert ended.status == SUCCEEDED, ended.result.response.error_code
    assert home.distance(goal) < 0.01


@pytest.mark.statement('IF-3', 'ACT-5')
def test_a_sequence_is_cancelled(arm: Any, action: Any, start: Any) -> None:
    """
    A cancel stops the motion between its start and its last goal: CANCELED with PREEMPTED.

    Upstream: integrationtest_sequence_action_preemption.cpp, TestCancellingOfGoal.
    """
    assert arm.move(start).code == 'SUCCESS'
    began = arm.positions()
    request = two_lines(arm, arm.pose(), 0.0)
    handle = send(arm, action, request)
    while arm.distance(began) < 5e-3:
        pass
    arm.cancel(handle)
    ended = arm.ended(handle)
    assert (ended.status, name_of(ended.result.response.error_code)) == (CANCELED, 'PREEMPTED')
    wanted = request.items[1].req.goal_constraints[0].position_constraints[0]
    place = wanted.constraint_region.primitive_poses[0].position
    assert math.dist(xyz(arm.pose().pose.position), xyz(place)) > 0.02


@pytest.mark.statement('IF-3', 'ACT-5')
@pytest.mark.parametrize('plan_only', [False, True])
def test_a_sequence_is_cancelled_while_it_is_planned(
    arm: Any, action: Any, long_search: dict[str, Any], plan_only: bool
) -> None:
    """
    CANCELED with PREEMPTED, long before its time is over.

    Upstream: move_group_sequence_action.cpp, preemptMoveCallback; plan_execution.cpp,
    planAndExecuteHelper. *Differs*: upstream does not cancel where it only plans.
    """
    request = arm.request(**long_search)
    handle = send(arm, action, MotionSequenceRequest(items=[MotionSequenceItem(req=request)]),
                  plan_only=plan_only)
    arm.positions()
    arm.cancel(handle)
    ended = arm.ended(handle, timeout=20.0)
    assert (ended.status, name_of(ended.result.response.error_code)) == (CANCELED, 'PREEMPTED')
