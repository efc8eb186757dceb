# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Results of goals that have ended are kept for those who ask late, but not all of them."""

from __future__ import annotations

from typing import Any

from action_msgs.msg import GoalStatus
from moveit_msgs.action import MoveGroup

from armsim_ros.nodes.move_group.context import MOST_RESULTS


def test_of_many_ended_goals_the_last_are_known(stack: Any) -> None:
    """Who asks for a result once more gets it, unless many goals have ended since."""
    goal = MoveGroup.Goal()
    goal.request.group_name, goal.planning_options.plan_only = 'nobody', True
    client, action = stack.client, stack.move_action
    assert action.wait_for_server(10.0)
    handles = []
    for _ in range(MOST_RESULTS + 1):
        handle = client.result(action.send_goal_async(goal), 30.0, 'answer to a goal')
        ended = client.result(handle.get_result_async(), 30.0, 'result')
        assert ended.status == GoalStatus.STATUS_ABORTED
        handles.append(handle)
    first, last = (
        client.result(handle.get_result_async(), 10.0, 'answer')
        for handle in (handles[0], handles[-1])
    )
    assert first.status == GoalStatus.STATUS_UNKNOWN
    assert last.status == GoalStatus.STATUS_ABORTED
    assert last.result.error_code.message
