# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How goals of move_group's actions end."""

import asyncio
from types import SimpleNamespace

from moveit_msgs.msg import MoveItErrorCodes, PlanningOptions
import pytest

from armsim_ros.nodes.move_group.planning.move_actions import plan_and_execute


@pytest.mark.parametrize('planned', [
    MoveItErrorCodes.SUCCESS, MoveItErrorCodes.FAILURE, MoveItErrorCodes.PLANNING_FAILED])
@pytest.mark.parametrize('replan', [False, True])
def test_a_goal_that_is_cancelled_while_it_is_planned(planned, replan):
    """
    It is PREEMPTED whatever planning returns, and is not planned again.

    Upstream: plan_execution.cpp, planAndExecuteHelper.
    """
    code, plans = MoveItErrorCodes(), []
    goal = SimpleNamespace(is_cancel_requested=False, request=SimpleNamespace(
        planning_options=PlanningOptions(replan=replan)))

    async def plan():
        plans.append(planned)
        goal.is_cancel_requested, code.val = True, planned

    async def execute(plan):
        pytest.fail('executed')

    asyncio.run(plan_and_execute(SimpleNamespace(), 'move_action', goal, code, plan, execute))
    assert code.val == MoveItErrorCodes.PREEMPTED
    assert plans == [planned]
