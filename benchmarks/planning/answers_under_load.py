# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How long everybody else waits for an answer while one plan of a minute is being made."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
import time
from typing import Any

from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import CollisionObject, PlanningScene, RobotState
from moveit_msgs.srv import (
    ApplyPlanningScene,
    GetPlanningScene,
    GetPositionFK,
    GetPositionIK,
    GetStateValidity,
    SetPlannerParams,
)
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.action.client import ClientGoalHandle
from sensor_msgs.msg import JointState
from shape_msgs.msg import SolidPrimitive
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from armsim_ros.clients.action_client import PatientActionClient
from armsim_ros.clients.client_node import ClientNode
from benchmarks.options import Options
from benchmarks.planning.planned_robot import kinematics_of, states_of
from benchmarks.planning.planning_cancel import block, plan_goal
from benchmarks.stack import joint_states_of, median, percentile, running_stack, Stack


def main(options: Options) -> None:
    """Print a line a kind of request; ``--runs`` rounds of them, a tenth of that of motions."""
    model = kinematics_of(options.robot)
    group, states = states_of(model)
    start, goal = list(states.values())[:2]
    middle = 0.5 * (model.vector(start, model.default()) + model.vector(goal, model.default()))
    tip = model.robot.semantic.groups[group].links[-1]
    with running_stack(f'robot:={options.robot}') as stack:
        client = stack.client
        action = PatientActionClient(client.node, MoveGroup, '/move_action')
        assert action.wait_for_server(10.0)
        wanted = plan_goal(group, 'RRTstar', start, goal)
        wanted.request.allowed_planning_time = 60.0
        block(wanted, model.link_pose(middle, tip))
        requests = _requests(stack, group, tip)
        for call in requests.values():
            call()
        handle = client.result(action.send_goal_async(wanted))
        ended = client.in_executor(handle.get_result_async)
        time.sleep(0.5)
        waits = {name: [_took(call) for _ in range(options.runs)]
                 for name, call in requests.items()}
        motions = _cancelled(
            stack, joint_states_of(options.robot), goal, max(1, options.runs // 10))
        planning = 'was at work to the end'
        if ended.done():
            planning = f'HAD ENDED after {ended.result().result.planning_time:.1f} s'
        cancel = _took(lambda: client.result(client.in_executor(handle.cancel_goal_async)))
        result = _took(lambda: client.result(ended))
        for name, values in {**waits, **motions}.items():
            print(f'{name}: {median(values):.1f} ms, 95 % below {percentile(values, 0.95):.1f}, '
                  f'worst {max(values):.1f}')
        print(f'the plan itself {planning}: cancel answered after {cancel:.1f} ms, result '
              f'{result:.1f} ms later')


def _requests(stack: Stack, group: str, tip: str) -> dict[str, Callable[[], Any]]:
    """Return the calls that are timed, by name."""
    client, state = stack.client, RobotState(is_diff=True)
    box = CollisionObject(id='box', operation=CollisionObject.ADD)
    box.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.1] * 3)]
    box.pose.position.x = 3.0
    scene = PlanningScene(is_diff=True)
    scene.robot_state.is_diff = True
    scene.world.collision_objects = [box]
    params = SetPlannerParams.Request(planner_config='RRTConnect')
    params.params.keys, params.params.values, params.params.descriptions = ['range'], ['1'], ['']
    value = ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=-1)
    ik = GetPositionIK.Request()
    ik.ik_request.group_name, ik.ik_request.robot_state = group, state
    ik.ik_request.ik_link_name = tip
    fk = GetPositionFK.Request(fk_link_names=[tip], robot_state=state)
    ik.ik_request.pose_stamped = client.call('/compute_fk', GetPositionFK, fk).pose_stamped[0]
    calls: dict[str, tuple[type, str, Any]] = {
        'set_parameters': (SetParameters, '/move_group/set_parameters', SetParameters.Request(
            parameters=[Parameter(name='planning_seed', value=value)])),
        'set_planner_params': (SetPlannerParams, '/set_planner_params', params),
        'apply_planning_scene': (ApplyPlanningScene, '/apply_planning_scene',
                                 ApplyPlanningScene.Request(scene=scene)),
        'get_planning_scene': (GetPlanningScene, '/get_planning_scene', None),
        'compute_fk': (GetPositionFK, '/compute_fk', fk),
        'compute_ik': (GetPositionIK, '/compute_ik', ik),
        'check_state_validity': (GetStateValidity, '/check_state_validity',
                                 GetStateValidity.Request(group_name=group, robot_state=state)),
    }
    return {
        name: partial(client.call, service, kind, request)
        for name, (kind, service, request) in calls.items()}


def _cancelled(
    stack: Stack, topic: str, goal: dict[str, float], runs: int
) -> dict[str, list[float]]:
    """Start motions and cancel them; return the times to the answer and to standstill [ms]."""
    client = stack.client
    states = client.collect(topic, JointState)
    action = PatientActionClient(client.node, ExecuteTrajectory, '/execute_trajectory')
    assert action.wait_for_server(10.0)
    answers, stops = [], []
    for _ in range(runs):
        states.clear()
        now = states.wait(1)[-1]
        here = dict(zip(now.name, now.position, strict=True))
        names = [name for name in goal if name in here]
        trajectory = JointTrajectory(joint_names=names, points=[
            JointTrajectoryPoint(positions=[here[name] for name in names]),
            JointTrajectoryPoint(positions=[here[name] + 0.3 for name in names]),
        ])
        trajectory.points[1].time_from_start.sec = 5
        message = ExecuteTrajectory.Goal()
        message.trajectory.joint_trajectory = trajectory
        handle = client.result(action.send_goal_async(message))
        ended = client.in_executor(handle.get_result_async)
        time.sleep(1.0)
        began = time.monotonic()
        answers.append(_took(partial(_cancel, client, handle)))
        states.clear()
        while max(map(abs, states.wait(1)[-1].velocity)) > 0.01:
            states.clear()
        stops.append(1000.0 * (time.monotonic() - began))
        client.result(ended)
    return {'cancel of a motion, answer': answers, 'cancel of a motion, standstill': stops}


def _cancel(client: ClientNode, handle: ClientGoalHandle) -> None:
    client.result(client.in_executor(handle.cancel_goal_async))


def _took(call: Callable[[], Any]) -> float:
    """Return how long a call takes [ms]."""
    began = time.monotonic()
    call()
    return 1000.0 * (time.monotonic() - began)
