# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From the cancel of a goal of /move_action that is being planned to its result."""

from __future__ import annotations

import time

from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import CollisionObject, Constraints, JointConstraint
import numpy as np
from rclpy.action import ActionClient
from shape_msgs.msg import SolidPrimitive

from benchmarks.options import Options
from benchmarks.planning.planned_robot import kinematics_of, states_of
from benchmarks.stack import median, percentile, running_stack

PLANNERS = ('RRTstar', 'PRM')
"""Planners that use up the time that they are allowed, one of them with threads."""

PREEMPTED = -7


def main(options: Options) -> None:
    """Print a line a planner; ``--runs`` says how many goals are cancelled for each."""
    model = kinematics_of(options.robot)
    group, states = states_of(model)
    start, goal = list(states.values())[:2]
    ends = [model.vector(state, model.default()) for state in (start, goal)]
    tip = model.robot.semantic.groups[group].links[-1]
    obstacle = model.link_pose(0.5 * (ends[0] + ends[1]), tip)
    with running_stack(f'robot:={options.robot}') as stack:
        client = stack.client
        action = ActionClient(client.node, MoveGroup, '/move_action')
        assert action.wait_for_server(10.0)
        for planner in PLANNERS:
            waits = []
            for number in range(options.runs):
                wanted = plan_goal(group, planner, start, goal)
                block(wanted, obstacle)
                handle = client.result(
                    client.in_executor(lambda: action.send_goal_async(wanted)))  # noqa: B023
                ended = client.in_executor(handle.get_result_async)
                time.sleep(0.1 + 0.03 * number)
                began = time.monotonic()
                client.in_executor(handle.cancel_goal_async)
                code = client.result(ended, 20.0).result.error_code.val
                if code == PREEMPTED:
                    waits.append(1000.0 * (time.monotonic() - began))
            if waits:
                print(f'{planner}: {len(waits)} of {options.runs} goals cancelled, result after '
                      f'{median(waits):.1f} ms, 95 % below {percentile(waits, 0.95):.1f}, worst '
                      f'{max(waits):.1f}')
            else:
                print(f'{planner}: all {options.runs} goals were planned before the cancel came')


def plan_goal(
    group: str, planner: str, start: dict[str, float], goal: dict[str, float]
) -> MoveGroup.Goal:
    """Return a goal that is planned with a planner, from one state to another."""
    message = MoveGroup.Goal()
    message.planning_options.plan_only = True
    request = message.request
    request.group_name, request.planner_id = group, planner
    request.allowed_planning_time = 5.0
    request.num_planning_attempts = 1
    request.start_state.joint_state.name = list(start)
    request.start_state.joint_state.position = list(start.values())
    request.goal_constraints = [Constraints(joint_constraints=[
        JointConstraint(joint_name=name, position=value, tolerance_above=1e-4,
                        tolerance_below=1e-4, weight=1.0)
        for name, value in goal.items()])]
    return message


def block(goal: MoveGroup.Goal, pose: np.ndarray) -> None:
    """Put a box into the straight way, so that there has to be a search."""
    box = CollisionObject(id='in the way', operation=CollisionObject.ADD)
    box.primitives = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.05] * 3)]
    box.pose.position.x, box.pose.position.y, box.pose.position.z = map(float, pose[:3, 3])
    scene = goal.planning_options.planning_scene_diff
    scene.is_diff = scene.robot_state.is_diff = True
    scene.world.collision_objects = [box]
