# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Programs of a stack killed, ended or stopped: when their clients know, which is promised."""

from __future__ import annotations

import os
import signal

from action_msgs.msg import GoalStatus
import pytest
from stacks_to_kill import KNOWN, PROGRAMS, runs, Stack, wait_until

pytestmark = pytest.mark.alone


def test_a_move_group_that_was_stopped_works_when_it_goes_on(stack: Stack) -> None:
    """It is stopped while it plans and moves; its clients take it for gone, and find it again."""
    arm = stack.arm
    arm.move(0.02, 1.0)
    arm.long_plan(1.0)
    with stack.stopped('move_group'):
        wait_until(
            lambda: not any(each.server_is_ready() for each in (arm.motions, arm.plans)),
            KNOWN, 'the stopped program is taken for gone')
    arm.works()
    assert stack.program.process.poll() is None


@pytest.mark.parametrize('number', [signal.SIGKILL, signal.SIGTERM])
@pytest.mark.parametrize('victim', PROGRAMS)
def test_who_waits_learns_of_the_end(victim: str, number: int, stack: Stack) -> None:
    """A plan and a motion get a result or see their server gone; nothing stays behind."""
    arm = stack.arm
    pending = {
        arm.motions: arm.move(0.3, 20.0).get_result_async(),
        arm.plans: arm.long_plan(60.0).get_result_async(),
    }
    os.kill(stack.pids[victim], number)
    wait_until(
        lambda: all(result.done() or not actions.server_is_ready()
                    for actions, result in pending.items()),
        KNOWN, 'every client knows')
    status = stack.program.wait(10.0)
    if victim == 'bringup':
        assert status == (0 if number == signal.SIGTERM else -signal.SIGKILL)
    else:
        assert status == 1
        assert f'[bringup] {victim} (pid {stack.pids[victim]}) ' in stack.program.text
    wait_until(lambda: not any(map(runs, stack.pids.values())), 2.0, 'no process is left')
    answers = [result.result() for result in pending.values() if result.done()]
    for answer in answers:
        assert answer.status == GoalStatus.STATUS_ABORTED
        assert answer.result.error_code.message
    # What is killed takes its goals along; bringup's end is that of the others, too.
    if number == signal.SIGTERM or victim == 'simulation':
        assert answers, stack.program.text
