# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Goals in a row through /move_action: how many succeed, how far each process grows."""

from __future__ import annotations

import random
import time

from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import Constraints, JointConstraint
from moveit_msgs.srv import GetStateValidity

from armsim_ros.clients.action_client import PatientActionClient
from benchmarks.options import Options
from benchmarks.stack import median, resident_mib, running_stack, Stack

LIMITS = ((-2.0, 2.0), (-1.0, 1.0), (-2.0, 2.0), (-2.0, 2.0), (-2.0, 2.0), (-2.0, 2.0))
WARM_UP = 5


def main(options: Options) -> None:
    """Print successes, times and growth."""
    generator = random.Random(1)
    with running_stack() as stack:
        client = PatientActionClient(stack.client.node, MoveGroup, '/move_action')
        client.wait_for_server(10.0)
        processes, before = stack.processes(), {}
        succeeded, planning, whole = 0, [], []
        for index in range(WARM_UP + options.goals):
            if index == WARM_UP:
                before = {name: resident_mib(pid) for name, pid in processes.items()}
            began = time.monotonic()
            result = go(stack, client, free_state(stack, generator))
            if index < WARM_UP:
                continue
            whole.append(time.monotonic() - began)
            if result.error_code.val == 1:
                succeeded += 1
                planning.append(result.planning_time)
            else:
                print(f'goal {index}: {result.error_code.val} {result.error_code.message}')
        print(f'{succeeded} of {options.goals} goals succeeded')
        print(f'planning time median {median(planning) * 1e3:.0f} ms, worst '
              f'{max(planning, default=0.0) * 1e3:.0f} ms; goal to result median '
              f'{median(whole):.2f} s')
        for name, pid in processes.items():
            after = resident_mib(pid)
            print(f'{name}: {after:.0f} MiB, grown by {after - before[name]:+.1f} MiB')


def free_state(stack: Stack, generator: random.Random) -> list[float]:
    """Return random joint positions without a collision."""
    while True:
        values = [generator.uniform(*limit) for limit in LIMITS]
        request = GetStateValidity.Request(group_name='manipulator')
        request.robot_state.joint_state.name = [f'joint_{i + 1}' for i in range(6)]
        request.robot_state.joint_state.position = values
        if stack.client.call('/check_state_validity', GetStateValidity, request).valid:
            return values


def go(stack: Stack, client: PatientActionClient, values: list[float]) -> MoveGroup.Result:
    """Plan and execute to joint positions [rad]."""
    goal = MoveGroup.Goal()
    goal.request.group_name = 'manipulator'
    goal.request.allowed_planning_time = 5.0
    goal.request.max_velocity_scaling_factor = 1.0
    goal.request.max_acceleration_scaling_factor = 1.0
    goal.request.start_state.is_diff = True
    goal.request.goal_constraints = [Constraints(joint_constraints=[
        JointConstraint(joint_name=f'joint_{i + 1}', position=value, tolerance_above=1e-4,
                        tolerance_below=1e-4, weight=1.0)
        for i, value in enumerate(values)])]
    handle = stack.client.result(client.send_goal_async(goal), 30.0, 'answer to the goal')
    result: MoveGroup.Result = stack.client.result(
        handle.get_result_async(), 120.0, 'result').result
    return result
