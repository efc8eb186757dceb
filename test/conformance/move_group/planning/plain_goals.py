# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A client of rclpy and moveit_msgs alone, that fills in nothing of its goals but ``request``.

``python plain_goals.py JSON`` sends a joint goal to every endpoint that takes one, and prints one
line for each: ``NAME code message``. The JSON has ``group``, ``goal`` (joint -> position) and
``namespace``.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from moveit_msgs.action import MoveGroup, MoveGroupSequence
from moveit_msgs.msg import Constraints, JointConstraint, MotionPlanRequest, MotionSequenceItem
from moveit_msgs.srv import GetMotionPlan, GetMotionSequence
import rclpy
from rclpy.action import ActionClient

TIMEOUT = 30.0


def main(text: str) -> None:
    """Send the goals one after the other."""
    wanted = json.loads(text)
    rclpy.init()
    node = rclpy.create_node('plain_goals')

    def result(future: Any) -> Any:
        rclpy.spin_until_future_complete(node, future, timeout_sec=TIMEOUT)
        return future.result()

    def run(kind: Any, name: str, goal: Any) -> Any:
        client = ActionClient(node, kind, f"{wanted['namespace']}/{name}")
        assert client.wait_for_server(TIMEOUT)
        handle = result(client.send_goal_async(goal))
        return result(handle.get_result_async()).result

    def call(kind: Any, name: str, request: Any) -> Any:
        client = node.create_client(kind, f"{wanted['namespace']}/{name}")
        assert client.wait_for_service(TIMEOUT)
        return result(client.call_async(request))

    plan = MotionPlanRequest(group_name=wanted['group'], goal_constraints=[Constraints(
        joint_constraints=[JointConstraint(joint_name=name, position=value, weight=1.0)
                           for name, value in wanted['goal'].items()])])
    codes = {}
    for name in ('move_action', 'move_group'):
        codes[name] = run(MoveGroup, name, MoveGroup.Goal(request=plan)).error_code
    answer = call(GetMotionPlan, 'plan_kinematic_path',
                  GetMotionPlan.Request(motion_plan_request=plan))
    codes['plan_kinematic_path'] = answer.motion_plan_response.error_code
    plan.pipeline_id, plan.planner_id = 'pilz_industrial_motion_planner', 'PTP'
    plan.max_velocity_scaling_factor = plan.max_acceleration_scaling_factor = 1.0  # none: refused
    sequence = MoveGroupSequence.Goal()
    sequence.request.items = [MotionSequenceItem(req=plan)]
    codes['sequence_move_group'] = run(
        MoveGroupSequence, 'sequence_move_group', sequence).response.error_code
    codes['plan_sequence_path'] = call(
        GetMotionSequence, 'plan_sequence_path',
        GetMotionSequence.Request(request=sequence.request)).response.error_code
    for name, code in codes.items():
        print(name, code.val, code.message, flush=True)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == '__main__':
    main(sys.argv[1])
