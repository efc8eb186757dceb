# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a request to /plan_kinematic_path to its response, between a robot's named states."""

from __future__ import annotations

from itertools import permutations
from statistics import median
import time

from moveit_msgs.msg import Constraints, JointConstraint
from moveit_msgs.srv import GetMotionPlan

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.model.loading import load_robot_model
from benchmarks.options import Options
from benchmarks.stack import running_stack


def main(options: Options) -> None:
    """Print round trips, and what they cost beside the planner's own time."""
    model = load_robot_model(load_robot_settings(options.robot))
    with running_stack(f'robot:={options.robot}') as stack:
        print(f'{"from":>14} {"to":>14} {"solved":>7} {"round trip ms":>14} {"beside ms":>10}')
        for group, states in model.semantic.named_states.items():
            for start, goal in permutations(states, 2):
                request = GetMotionPlan.Request()
                wanted = request.motion_plan_request
                wanted.group_name = group
                wanted.allowed_planning_time = 5.0
                wanted.start_state.joint_state.name = list(states[start])
                wanted.start_state.joint_state.position = list(states[start].values())
                wanted.goal_constraints = [Constraints(joint_constraints=[
                    JointConstraint(joint_name=name, position=value, tolerance_above=1e-4,
                                    tolerance_below=1e-4, weight=1.0)
                    for name, value in states[goal].items()])]
                trips, beside, solved = [], [], 0
                for _ in range(options.runs):
                    began = time.monotonic()
                    answer = stack.client.call(
                        '/plan_kinematic_path', GetMotionPlan, request).motion_plan_response
                    trips.append(1000.0 * (time.monotonic() - began))
                    beside.append(trips[-1] - 1000.0 * answer.planning_time)
                    solved += answer.error_code.val == 1
                print(f'{start:>14} {goal:>14} {solved:>3}/{options.runs:<3} '
                      f'{median(trips):>14.1f} {median(beside):>10.1f}')
