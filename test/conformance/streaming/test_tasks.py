# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Solutions of MoveIt Task Constructor, executed by move_group."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from geometry_msgs.msg import Pose
from moveit_msgs.msg import (
    AttachedCollisionObject,
    CollisionObject,
    PlanningScene,
    PlanningSceneComponents,
)
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene, GetPositionFK
from moveit_task_constructor_msgs.action import ExecuteTaskSolution
from moveit_task_constructor_msgs.msg import Solution, SubTrajectory
import numpy as np
import pytest
from shape_msgs.msg import SolidPrimitive
from streaming_bench import beside, JOINTS, PLACE, Streamed
from trajectory_msgs.msg import JointTrajectoryPoint

from armsim_ros.clients.action_client import PatientActionClient

statement = pytest.mark.statement

SUCCESS, INVALID_MOTION_PLAN, ENVIRONMENT_CHANGE, CONTROL_FAILED, PREEMPTED = 1, -2, -3, -4, -7
TIP = 'link_6'


@pytest.fixture(scope='module')
def action(stack: Streamed) -> Iterator[PatientActionClient]:
    """Give a client of the action."""
    client = PatientActionClient(stack.client.node, ExecuteTaskSolution, '/execute_task_solution')
    yield client
    stack.client.in_executor(client.destroy)


def part(*ways: Any, seconds: float = 0.5, thing: str = '') -> SubTrajectory:
    """Return a part that goes through joint positions, then puts a box into the scene."""
    made = SubTrajectory()
    made.scene_diff.is_diff = made.scene_diff.robot_state.is_diff = True
    if ways:
        made.trajectory.joint_trajectory.joint_names = list(JOINTS)
    for number, positions in enumerate(ways):
        point = JointTrajectoryPoint(positions=[float(value) for value in positions])
        time_ns = int(number * seconds * 1e9)
        point.time_from_start.sec = time_ns // 10**9
        point.time_from_start.nanosec = time_ns % 10**9
        made.trajectory.joint_trajectory.points.append(point)
    if thing:
        box = CollisionObject(id=thing, operation=CollisionObject.ADD)
        box.header.frame_id = 'world'
        box.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.1, 0.1, 0.1])]
        box.pose = Pose()
        box.pose.position.x = 3.0
        box.primitive_poses = [Pose()]
        made.scene_diff.world.collision_objects = [box]
    return made


def send(arm: Streamed, action: PatientActionClient, *parts: SubTrajectory) -> Any:
    """Send parts; return the goal's handle and the numbers of its feedback."""
    seen: list[tuple[int, int]] = []
    goal = ExecuteTaskSolution.Goal(solution=Solution(sub_trajectory=list(parts)))
    assert action.wait_for_server(10.0)
    handle = arm.client.result(action.send_goal_async(
        goal, lambda m: seen.append((m.feedback.sub_id, m.feedback.sub_no))))
    assert handle.accepted
    return handle, seen


def ended(arm: Streamed, handle: Any) -> tuple[int, str]:
    """Return code and message of a goal."""
    result = arm.client.result(handle.get_result_async(), 30.0).result
    return result.error_code.val, result.error_code.message


def run(arm: Streamed, action: PatientActionClient, *parts: SubTrajectory) -> Any:
    """Execute parts; return code, message and the numbers of feedback."""
    handle, seen = send(arm, action, *parts)
    return *ended(arm, handle), seen


def tip_at(arm: Streamed, positions: Any) -> Pose:
    """Return the pose of the tip at joint positions."""
    request = GetPositionFK.Request(fk_link_names=[TIP])
    request.header.frame_id = 'world'
    request.robot_state.joint_state.name = list(JOINTS)
    request.robot_state.joint_state.position = [float(value) for value in positions]
    return arm.client.call('/compute_fk', GetPositionFK, request).pose_stamped[0].pose


def apply(arm: Streamed, scene: PlanningScene) -> bool:
    """Apply a scene message; return whether all of it was taken."""
    request = ApplyPlanningScene.Request(scene=scene)
    return bool(arm.client.call('/apply_planning_scene', ApplyPlanningScene, request).success)


def scene_of(arm: Streamed, components: int) -> PlanningScene:
    """Return components of the scene."""
    request = GetPlanningScene.Request()
    request.components.components = components
    return arm.client.call('/get_planning_scene', GetPlanningScene, request).scene


def objects(arm: Streamed) -> set[str]:
    """Return the names of the objects in the scene."""
    scene = scene_of(arm, PlanningSceneComponents.WORLD_OBJECT_NAMES)
    return {one.id for one in scene.world.collision_objects}


def attached(arm: Streamed) -> set[str]:
    """Return the names of the objects that the arm carries."""
    scene = scene_of(arm, PlanningSceneComponents.ROBOT_STATE_ATTACHED_OBJECTS)
    return {one.object.id for one in scene.robot_state.attached_collision_objects}


@statement('MTC-1', 'MTC-2', 'MTC-3')
def test_parts_in_order(arm: Streamed, action: PatientActionClient) -> None:
    """Parts run in order; each changes the scene after its motion and sends feedback."""
    there = beside(0.2)
    code, message, seen = run(
        arm, action, part(PLACE, there, thing='first'), part(thing='second'), part(there, PLACE)
    )
    assert code == SUCCESS, message
    assert seen == [(0, 3), (1, 3), (2, 3)]
    assert {'first', 'second'} <= objects(arm)


@statement('MTC-2')
def test_scene_differences_of_parts(arm: Streamed, action: PatientActionClient) -> None:
    """
    A default difference changes nothing; one that attaches keeps what is attached already.

    Upstream: execute_task_solution_capability.cpp, constructMotionPlan (effect_on_success).
    """
    parts = [part(thing=name) for name in ('grasped', 'held')]
    for one in parts:
        (box,) = one.scene_diff.world.collision_objects
        one.scene_diff.world.collision_objects = []
        one.scene_diff.robot_state.is_diff = False
        one.scene_diff.robot_state.attached_collision_objects = [
            AttachedCollisionObject(link_name=TIP, object=box)]
    before = objects(arm)
    code, message, _ = run(arm, action, *parts, SubTrajectory())
    assert code == SUCCESS, message
    assert attached(arm) == {'grasped', 'held'}
    assert objects(arm) == before
    drop = part()
    drop.scene_diff.robot_state.attached_collision_objects = [AttachedCollisionObject(
        object=CollisionObject(operation=CollisionObject.REMOVE))]
    assert run(arm, action, drop)[0] == SUCCESS
    assert not attached(arm)


@pytest.fixture
def cleared(arm: Streamed) -> Iterator[None]:
    """Take the obstacle out of the scene afterwards."""
    yield
    gone = CollisionObject(id='obstacle', operation=CollisionObject.REMOVE)
    scene = PlanningScene(is_diff=True)
    scene.robot_state.is_diff = True
    scene.world.collision_objects = [gone]
    assert apply(arm, scene)


@statement('MTC-2')
@pytest.mark.parametrize('when', ['before', 'by a part', 'meanwhile'])
@pytest.mark.usefixtures('cleared')
def test_an_obstacle_stops_a_part(arm: Streamed, action: PatientActionClient, when: str) -> None:
    """
    There before the goal, put there by an earlier part, or while the arm moves: -3.

    Upstream: plan_execution.cpp, executeAndMonitor and successfulTrajectorySegmentExecution.
    """
    there = beside(0.6)
    motion = part(PLACE, there, seconds=4.0)
    place = tip_at(arm, there)
    maker = part(thing='obstacle')
    maker.scene_diff.world.collision_objects[0].pose = place
    if when == 'before':
        assert run(arm, action, maker)[0] == SUCCESS
    parts = [maker, motion] if when == 'by a part' else [motion]
    handle, _ = send(arm, action, *parts)
    if when == 'meanwhile':
        begin = arm.positions[0]
        arm.until(lambda: abs(arm.positions[0] - begin) > 0.02, 'the arm moves')
        assert apply(arm, maker.scene_diff)
    code, message = ended(arm, handle)
    assert code == ENVIRONMENT_CHANGE, message
    assert "'obstacle'" in message


@statement('MTC-2')
def test_a_refused_change_of_the_scene_ends_a_task(
    arm: Streamed, action: PatientActionClient
) -> None:
    """
    What should follow it is not executed: -7.

    Upstream: plan_execution.cpp, successfulTrajectorySegmentExecution (effect_on_success).
    """
    first = part(thing='gone')
    first.scene_diff.world.collision_objects[0].operation = CollisionObject.REMOVE
    code, message, seen = run(arm, action, first, part(thing='never'))
    assert code == PREEMPTED, message
    assert 'part 0' in message
    assert seen == [(0, 2)]
    assert 'never' not in objects(arm)


@statement('MTC-3')
def test_empty_solution(arm: Streamed, action: PatientActionClient) -> None:
    """Nothing to do is a success."""
    assert run(arm, action)[0] == SUCCESS


@statement('MTC-3')
@pytest.mark.parametrize('wrong', ['joint', 'controller'])
def test_all_parts_are_checked_first(
    arm: Streamed, action: PatientActionClient, wrong: str
) -> None:
    """A part that cannot be executed is named before anything moves."""
    there = beside(0.3)
    second = part(there, PLACE, thing='never')
    if wrong == 'joint':
        second.trajectory.joint_trajectory.joint_names = [*JOINTS[:5], 'stranger']
    else:
        second.execution_info.controller_names = ['nobody']
    before = arm.positions
    code, message, seen = run(arm, action, part(PLACE, there), second)
    assert code == (INVALID_MOTION_PLAN if wrong == 'joint' else CONTROL_FAILED)
    assert 'part 1 of 2' in message
    assert not seen
    np.testing.assert_allclose(arm.positions, before, atol=2e-3)


@statement('MTC-4')
def test_a_failing_part_ends_the_task(arm: Streamed, action: PatientActionClient) -> None:
    """Its code is the result's; what came before stays, what would follow does not happen."""
    there = beside(0.1)
    elsewhere = beside(1.0)
    code, message, _ = run(
        arm, action,
        part(PLACE, there, thing='kept'), part(elsewhere, PLACE), part(thing='too late'),
    )
    assert code == CONTROL_FAILED
    assert 'part 1 of 3' in message
    assert 'kept' in objects(arm)
    assert 'too late' not in objects(arm)


@statement('PAR-1')
def test_newer_motion_takes_over(arm: Streamed, action: PatientActionClient) -> None:
    """
    One that begins where the arm is takes its controller from an older one, which gets -4.

    Upstream: plan_execution.cpp, executeAndMonitor: stopped, but not by the client.
    """
    slow = ExecuteTaskSolution.Goal(
        solution=Solution(sub_trajectory=[part(PLACE, beside(0.3), seconds=100.0)]))
    handle = arm.client.result(action.send_goal_async(slow))
    arm.until(lambda: arm.positions[0] > 0.002, 'the arm moves')
    code, message, _ = run(arm, action, part(arm.positions, beside(-0.1)))
    assert code == SUCCESS, message
    outcome = arm.client.result(handle.get_result_async()).result
    assert outcome.error_code.val == CONTROL_FAILED
    assert 'newer' in outcome.error_code.message
    assert abs(arm.positions[0] + 0.1) < 5e-3


@statement('MTC-4')
def test_cancel(arm: Streamed, action: PatientActionClient) -> None:
    """A cancel stops the arm; the goal is canceled with code -7."""
    there = beside(1.0)
    goal = ExecuteTaskSolution.Goal(
        solution=Solution(sub_trajectory=[part(PLACE, there, seconds=4.0)]))
    handle = arm.client.result(action.send_goal_async(goal))
    arm.until(lambda: arm.positions[0] > 0.02, 'the arm moves')
    arm.client.result(handle.cancel_goal_async())
    outcome = arm.client.result(handle.get_result_async())
    assert outcome.result.error_code.val == PREEMPTED
    assert outcome.status == 5  # canceled
    arm.rest(0.2)
    assert arm.positions[0] < 0.8
