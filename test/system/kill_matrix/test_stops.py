# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Programs of a stack stopped and continued, while others are at work."""

from __future__ import annotations

import re

from moveit_msgs.msg import MoveItErrorCodes
import pytest
from stacks_to_kill import Stack


def test_an_answer_that_never_comes_ends_the_motion(stack: Stack) -> None:
    """The simulation is stopped before it gets a goal: the motion ends, and the next one goes."""
    arm = stack.arm
    start = arm.position()
    with stack.stopped('simulation'):
        error = arm.result(arm.move(0.1, 1.0, start), 15.0).error_code
    assert error.val == MoveItErrorCodes.CONTROL_FAILED
    reasons = 'has not answered|gone|not connected|no joint state newer'
    assert re.search(reasons, error.message), error.message
    arm.works()


@pytest.mark.parametrize('victim', ['bringup', 'simulation'])
def test_a_program_that_was_stopped_works_when_it_goes_on(victim: str, stack: Stack) -> None:
    """It is stopped while it plans and moves; others take it for gone, and find it again."""
    arm = stack.arm
    goals = arm.move(0.02, 1.0), arm.long_plan(1.0)
    with stack.stopped(victim):
        if victim == 'bringup':  # no client's server: the others end their work meanwhile
            for goal in goals:
                assert arm.result(goal, 20.0).error_code.val
    arm.works()
    assert stack.program.process.poll() is None
