# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Planning and execution through the actions and services, from outside."""

from __future__ import annotations

import itertools
from typing import Any

from geometry_msgs.msg import PoseStamped
from moveit_msgs.msg import (
    CollisionObject,
    Constraints,
    MoveItErrorCodes,
    OrientationConstraint,
    PlanningScene,
    PositionConstraint,
)
from moveit_msgs.srv import (
    GetCartesianPath,
    GetMotionPlan,
    GetPositionFK,
    GetPositionIK,
    GetStateValidity,
)
import pytest
from shape_msgs.msg import SolidPrimitive
from std_msgs.msg import String

GROUP = 'manipulator'
TIP = 'link_6'
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


def seconds(duration: Any) -> float:
    """Return a duration message as [s]."""
    return duration.sec + duration.nanosec * 1e-9


def error(stack: Any, state: str) -> float:
    """Return the largest distance of a joint from a named state [rad]."""
    measured = stack.positions()
    return max(abs(measured[joint] - value) for joint, value in stack.states[state].items())


def fk(stack: Any, state: str, link: str = TIP) -> PoseStamped:
    """Return a link's pose in a named state."""
    request = GetPositionFK.Request(fk_link_names=[link])
    request.robot_state.joint_state.name = list(stack.states[state])
    request.robot_state.joint_state.position = list(stack.states[state].values())
    answer = stack.client.call('/compute_fk', GetPositionFK, request)
    assert answer.error_code.val == MoveItErrorCodes.SUCCESS
    return answer.pose_stamped[0]


def pose_goal(pose: PoseStamped) -> Constraints:
    """Return a pose as MoveIt's clients write it: a small sphere and a small rotation."""
    position = PositionConstraint(header=pose.header, link_name=TIP, weight=1.0)
    position.constraint_region.primitives = [
        SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[1e-3])
    ]
    position.constraint_region.primitive_poses = [pose.pose]
    orientation = OrientationConstraint(
        header=pose.header,
        orientation=pose.pose.orientation,
        link_name=TIP,
        absolute_x_axis_tolerance=1e-2,
        absolute_y_axis_tolerance=1e-2,
        absolute_z_axis_tolerance=1e-2,
        weight=1.0,
    )
    return Constraints(position_constraints=[position], orientation_constraints=[orientation])


def box(name: str, xyz: tuple[float, float, float], size: tuple[float, float, float]) -> Any:
    """Return a scene diff that adds a box."""
    item = CollisionObject(id=name, operation=CollisionObject.ADD)
    item.header.frame_id = 'world'
    item.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(size))]
    item.pose.position.x, item.pose.position.y, item.pose.position.z = xyz
    item.pose.orientation.w = 1.0
    scene = PlanningScene(is_diff=True)
    scene.robot_state.is_diff = True
    scene.world.collision_objects = [item]
    return scene


def test_plan_and_execute_reaches_a_named_state(stack: Any) -> None:
    """SEED-1: a named state as the goal, planned and executed, is where the arm then stands."""
    for state in ('scan_food', 'home'):
        answer = stack.move(state)
        assert answer.status == SUCCEEDED, answer.result.error_code
        assert answer.result.error_code.val == MoveItErrorCodes.SUCCESS
        assert error(stack, state) < 0.01


def test_plan_only_does_not_move_and_gives_a_legal_trajectory(stack: Any) -> None:
    """REQ-13, REQ-17: times increase from 0, rest at both ends, the arm stays."""
    before = stack.positions()
    answer = stack.move('scan_face', plan_only=True)
    assert answer.status == SUCCEEDED
    trajectory = answer.result.planned_trajectory.joint_trajectory
    times = [seconds(point.time_from_start) for point in trajectory.points]
    assert times[0] == 0.0
    assert all(later > earlier for earlier, later in itertools.pairwise(times))
    for point in (trajectory.points[0], trajectory.points[-1]):
        assert list(point.velocities) == pytest.approx([0.0] * 6, abs=1e-9)
    goal = [stack.states['scan_face'][name] for name in trajectory.joint_names]
    assert list(trajectory.points[-1].positions) == pytest.approx(goal, abs=2e-4)
    assert stack.positions() == pytest.approx(before, abs=1e-4)


def test_a_pose_goal_is_reached(stack: Any) -> None:
    """CON-7: position and orientation of a link as the goal."""
    wanted = fk(stack, 'scan_food')
    request = GetMotionPlan.Request()
    plan = request.motion_plan_request
    plan.group_name, plan.allowed_planning_time = GROUP, 5.0
    plan.start_state.is_diff = True
    plan.goal_constraints = [pose_goal(wanted)]
    answer = stack.client.call('/plan_kinematic_path', GetMotionPlan, request, 20.0)
    answer = answer.motion_plan_response
    assert answer.error_code.val == MoveItErrorCodes.SUCCESS, answer.error_code
    trajectory = answer.trajectory.joint_trajectory
    check = GetPositionFK.Request(fk_link_names=[TIP])
    check.robot_state.joint_state.name = trajectory.joint_names
    check.robot_state.joint_state.position = trajectory.points[-1].positions
    reached = stack.client.call('/compute_fk', GetPositionFK, check).pose_stamped[0].pose.position
    for axis in 'xyz':
        assert getattr(reached, axis) == pytest.approx(
            getattr(wanted.pose.position, axis), abs=2e-3
        )


def test_an_executed_plan_can_be_cancelled(stack: Any) -> None:
    """ACT-5: cancelling a motion ends in canceled with PREEMPTED, and the arm stands still."""
    assert stack.move('home').status == SUCCEEDED
    handle = stack.send_move('scan_face2', max_velocity_scaling_factor=0.03)
    start = stack.positions()
    while max(abs(stack.positions()[name] - start[name]) for name in start) < 0.02:
        pass
    stack.client.result(handle.cancel_goal_async(), 10.0, 'cancel answer')
    answer = stack.wait(handle)
    assert answer.status == CANCELED
    assert answer.result.error_code.val == MoveItErrorCodes.PREEMPTED
    first, second = stack.positions(), stack.positions()
    assert second == pytest.approx(first, abs=2e-3)
    assert stack.move('home').status == SUCCEEDED


def test_a_search_can_be_cancelled(stack: Any) -> None:
    """E18: a goal that is still planned ends with PREEMPTED, long before its time is over."""
    assert stack.move('home').status == SUCCEEDED
    home, away = stack.states['home'], stack.states['scan_food']
    half = GetPositionFK.Request(fk_link_names=[TIP])
    half.robot_state.joint_state.name = list(home)
    half.robot_state.joint_state.position = [0.5 * (home[name] + away[name]) for name in home]
    place = stack.client.call('/compute_fk', GetPositionFK, half).pose_stamped[0].pose.position
    assert stack.apply(box('obstacle', (place.x, place.y, place.z), (0.05, 0.05, 0.05)))
    handle = stack.send_move(
        'scan_food', plan_only=True, planner_id='RRTstar', allowed_planning_time=300.0)
    stack.positions()
    stack.client.result(handle.cancel_goal_async(), 10.0, 'cancel answer')
    answer = stack.wait(handle)
    assert answer.status == CANCELED
    assert answer.result.error_code.val == MoveItErrorCodes.PREEMPTED


def test_execute_trajectory_runs_a_plan_and_stop_ends_it(stack: Any) -> None:
    """SRV-72: the event "stop" ends a motion; the plan can be made anew and executed."""
    assert stack.move('home').status == SUCCEEDED
    slow = stack.move('scan_face2', plan_only=True, max_velocity_scaling_factor=0.03)
    handle = stack.execute(slow.result.planned_trajectory)
    publisher = stack.client.node.create_publisher(String, '/trajectory_execution_event', 1)
    start = stack.positions()
    while max(abs(stack.positions()[name] - start[name]) for name in start) < 0.02:
        pass
    publisher.publish(String(data='stop'))
    answer = stack.wait(handle)
    assert answer.status == ABORTED
    assert answer.result.error_code.val == MoveItErrorCodes.PREEMPTED
    again = stack.move('home', plan_only=True)
    done = stack.wait(stack.execute(again.result.planned_trajectory))
    assert done.status == SUCCEEDED
    assert error(stack, 'home') < 0.01


def test_a_trajectory_that_starts_elsewhere_is_refused(stack: Any) -> None:
    """EXE-5: the first point must be where the robot is; the message names joint and values."""
    assert stack.move('home').status == SUCCEEDED
    plan = stack.move('scan_food', plan_only=True).result.planned_trajectory
    for point in plan.joint_trajectory.points:
        point.positions[1] += 0.1
    answer = stack.wait(stack.execute(plan))
    assert answer.result.error_code.val == MoveItErrorCodes.CONTROL_FAILED
    assert 'joint_2' in answer.result.error_code.message


def test_unknown_group_and_empty_goal_give_their_codes(stack: Any) -> None:
    """E1, E6: the specific code, a sentence and a source instead of a plain failure."""
    answer = stack.move('home', plan_only=True, group_name='manipulater')
    assert answer.status == ABORTED
    assert answer.result.error_code.val == MoveItErrorCodes.INVALID_GROUP_NAME
    assert 'manipulator' in answer.result.error_code.message
    assert answer.result.error_code.source
    answer = stack.move('home', plan_only=True, goal_constraints=[])
    assert answer.result.error_code.val == MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS


def test_a_goal_inside_an_obstacle_names_the_pair(stack: Any) -> None:
    """E8: a goal state in collision is GOAL_IN_COLLISION, naming what touches."""
    assert stack.move('home').status == SUCCEEDED
    tip = fk(stack, 'scan_food').pose.position
    assert stack.apply(box('obstacle', (tip.x, tip.y, tip.z), (0.1, 0.1, 0.1)))
    answer = stack.move('scan_food', plan_only=True)
    assert answer.result.error_code.val == MoveItErrorCodes.GOAL_IN_COLLISION
    assert 'obstacle' in answer.result.error_code.message


def test_ik_gives_back_the_pose_that_fk_takes(stack: Any) -> None:
    """SRV-6: FK of the solution is the pose asked for, to 1e-4 m."""
    wanted = fk(stack, 'scan_face')
    request = GetPositionIK.Request()
    request.ik_request.group_name = GROUP
    request.ik_request.pose_stamped = wanted
    request.ik_request.avoid_collisions = True
    answer = stack.client.call('/compute_ik', GetPositionIK, request)
    assert answer.error_code.val == MoveItErrorCodes.SUCCESS, answer.error_code
    check = GetPositionFK.Request(fk_link_names=[TIP], robot_state=answer.solution)
    reached = stack.client.call('/compute_fk', GetPositionFK, check).pose_stamped[0].pose.position
    for axis in 'xyz':
        assert getattr(reached, axis) == pytest.approx(
            getattr(wanted.pose.position, axis), abs=1e-4
        )


def test_ik_out_of_reach_is_no_solution(stack: Any) -> None:
    """E21: a pose that no joint position reaches is NO_IK_SOLUTION."""
    wanted = fk(stack, 'home')
    wanted.pose.position.x += 3.0
    request = GetPositionIK.Request()
    request.ik_request.group_name = GROUP
    request.ik_request.pose_stamped = wanted
    answer = stack.client.call('/compute_ik', GetPositionIK, request)
    assert answer.error_code.val == MoveItErrorCodes.NO_IK_SOLUTION


def test_fk_names_the_links_it_does_not_know(stack: Any) -> None:
    """SRV-10: known poses come back, the unknown link gives INVALID_LINK_NAME."""
    request = GetPositionFK.Request(fk_link_names=['link_3', 'link_77'])
    answer = stack.client.call('/compute_fk', GetPositionFK, request)
    assert answer.error_code.val == MoveItErrorCodes.INVALID_LINK_NAME
    assert answer.fk_link_names == ['link_3']
    assert len(answer.pose_stamped) == 1


def test_state_validity_names_the_contact(stack: Any) -> None:
    """SRV-20, SRV-21: a box at the tip makes the state invalid, with both bodies named."""
    request = GetStateValidity.Request(group_name=GROUP)
    assert stack.client.call('/check_state_validity', GetStateValidity, request).valid
    tip = fk(stack, 'scan_food').pose.position
    stack.apply(box('thing', (tip.x, tip.y, tip.z), (0.05, 0.05, 0.05)))
    request.robot_state.joint_state.name = list(stack.states['scan_food'])
    request.robot_state.joint_state.position = list(stack.states['scan_food'].values())
    answer = stack.client.call('/check_state_validity', GetStateValidity, request)
    assert not answer.valid
    bodies = {answer.contacts[0].contact_body_1, answer.contacts[0].contact_body_2}
    assert 'thing' in bodies


def test_a_cartesian_path_is_straight(stack: Any) -> None:
    """SRV-32, SRV-33: 5 cm down from scan_food is reached in full."""
    assert stack.move('scan_food').status == SUCCEEDED
    target = fk(stack, 'scan_food')
    target.pose.position.z -= 0.05
    request = GetCartesianPath.Request(
        group_name=GROUP, link_name=TIP, max_step=0.01, avoid_collisions=True
    )
    request.header.frame_id = 'world'
    request.start_state.is_diff = True
    request.waypoints = [target.pose]
    answer = stack.client.call('/compute_cartesian_path', GetCartesianPath, request, 20.0)
    assert answer.error_code.val == MoveItErrorCodes.SUCCESS, answer.error_code
    assert answer.fraction == pytest.approx(1.0)
    assert len(answer.solution.joint_trajectory.points) > 2
