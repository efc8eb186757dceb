# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Controllers that fail, answer late or never, or give up: what their goals become."""

from __future__ import annotations

from copy import deepcopy

from move_group_bench import ABORTED, CANCELED
from played_stand import allowed, LOWER, Stand, START, UPPER, wait_for
import pytest


@pytest.mark.statement('EXE-7', 'E16')
def test_a_goal_that_a_controller_rejects(stand: Stand) -> None:
    """-4, and the message names the controller."""
    stand.whole.behaviour = 'reject'
    ended = stand.arm.execute(stand.trajectory(*LOWER, *UPPER))
    assert ended.code == 'CONTROL_FAILED'
    assert 'whole' in ended.result.error_code.message


@pytest.mark.statement('EXE-10', 'E16')
def test_a_part_that_fails_ends_the_others(stand: Stand) -> None:
    """-4 with the controller's own sentence; the other part is cancelled."""
    stand.lower.behaviour, stand.upper.behaviour = 'hold', 'abort'
    ended = stand.arm.execute(stand.trajectory(*LOWER, *UPPER), ['lower', 'upper'])
    assert ended.code == 'CONTROL_FAILED'
    assert stand.upper.error_string in ended.result.error_code.message
    assert stand.lower.cancelled.wait(2.0)


@pytest.mark.statement('EXE-8', 'E17')
def test_a_controller_that_takes_too_long(stand: Stand) -> None:
    """-6 with the time that was allowed, and the controller is cancelled."""
    stand.upper.behaviour = 'hold'
    trajectory = stand.trajectory(*UPPER)
    ended = stand.arm.execute(trajectory)
    assert ended.code == 'TIMED_OUT'
    assert f'{allowed(trajectory):.2f} s' in ended.result.error_code.message
    assert stand.upper.cancelled.is_set()


@pytest.mark.statement('EXE-8')
def test_a_result_that_is_late(stand: Stand) -> None:
    """An arm that is where it should be has not failed: the result is waited for a little."""
    stand.upper.behaviour = 'late'
    trajectory = stand.trajectory(*UPPER)
    handle = stand.arm.send_execute(trajectory)
    with pytest.raises(AssertionError, match='no result'):
        stand.arm.ended(handle, timeout=allowed(trajectory) + 0.3)
    stand.upper.release()
    assert stand.arm.ended(handle).code == 'SUCCESS'


def test_an_arm_that_does_not_come_to_rest(stand: Stand) -> None:
    """
    The result is delayed by a second and still a success; the log has a warning.

    trajectory_execution_manager.cpp: waitForRobotToStop, whose result executeThread ignores.
    """
    name = 'trajectory_execution.execution_duration_monitoring'
    assert stand.arm.execution_parameters.set(name, False) == ''
    stand.lower.behaviour = 'late'
    handle = stand.arm.send_execute(stand.trajectory(*LOWER))
    wait_for(stand.lower.waits)
    stand.played.shaking = {'joint_1': 0.3}
    stand.lower.release()
    with pytest.raises(AssertionError, match='no result'):
        stand.arm.ended(handle, timeout=0.7)
    ended = stand.arm.ended(handle)
    stand.played.shaking = {}
    assert ended.code == 'SUCCESS'
    stand.program.wait_for_line('the robot still moves 1 s after the trajectory has ended')
    assert stand.arm.execution_parameters.set(name, True) == ''


@pytest.mark.statement('EXE-8', 'PAR-5')
def test_the_duration_monitor_can_be_switched_off(stand: Stand) -> None:
    """Without it a slow controller is waited for."""
    name = 'trajectory_execution.execution_duration_monitoring'
    assert stand.arm.execution_parameters.set(name, False) == ''
    stand.upper.behaviour = 'hold'
    trajectory = stand.trajectory(*UPPER)
    handle = stand.arm.send_execute(trajectory)
    with pytest.raises(AssertionError, match='no result'):
        stand.arm.ended(handle, timeout=allowed(trajectory) + 0.5)
    stand.arm.cancel(handle)
    assert stand.arm.execution_parameters.set(name, True) == ''


@pytest.mark.statement('EXE-7')
def test_a_controller_that_never_answers(stand: Stand) -> None:
    """-4 after some seconds; the next motion runs, and a late answer leads to a cancel."""
    stand.upper.behaviour = 'mute'
    ended = stand.arm.execute(stand.trajectory(*UPPER))
    assert (ended.status, ended.code) == (ABORTED, 'CONTROL_FAILED')
    assert "'upper' has not answered" in ended.result.error_code.message
    assert stand.arm.execute(stand.trajectory(*LOWER)).code == 'SUCCESS'
    stand.upper.release()
    assert stand.upper.cancelled.wait(20.0)


@pytest.mark.statement('EXE-7', 'ACT-5')
def test_a_goal_is_cancelled_before_its_controller_answers(stand: Stand) -> None:
    """The cancel ends it; what the controller accepts after that is cancelled there."""
    stand.upper.behaviour = 'mute'
    handle = stand.arm.send_execute(stand.trajectory(*UPPER))
    wait_for(lambda: stand.upper.goals)
    stand.arm.cancel(handle)
    assert stand.arm.ended(handle, timeout=20.0).status == CANCELED
    stand.upper.release()
    assert stand.upper.cancelled.wait(20.0)


@pytest.mark.statement('ACT-5', 'ACT-10')
def test_a_goal_is_cancelled_while_it_waits_for_another(stand: Stand) -> None:
    """The second one ends at once, and never reaches its controller; the first goes on."""
    stand.lower.behaviour = 'hold'
    there = stand.trajectory(*LOWER)
    first = stand.arm.send_execute(there)
    wait_for(lambda: stand.lower.goals)
    back = deepcopy(there)
    for point, mirrored in zip(back.points, reversed(there.points), strict=True):
        point.positions = mirrored.positions
        point.velocities = [-value for value in mirrored.velocities]
        point.accelerations = mirrored.accelerations
    second = stand.arm.send_execute(back)
    stand.arm.cancel(second)
    assert stand.arm.ended(second, timeout=20.0).status == CANCELED
    assert not stand.lower.cancelled.is_set()
    stand.arm.cancel(first)
    assert stand.arm.ended(first).status == CANCELED
    assert len(stand.lower.goals) == 1


@pytest.mark.statement('S13', 'M28')
def test_a_gripper_that_closed_on_an_object(stand: Stand) -> None:
    """
    The status of the goal decides: stalled and succeeded is success, aborted is -4.

    Upstream: action_based_controller_handle.hpp, finishControllerExecution.
    """
    stand.hand.behaviour = 'stall'
    trajectory = stand.trajectory('joint_6')
    assert stand.arm.execute(trajectory).code == 'SUCCESS'
    stand.hand.behaviour = 'abort'
    assert stand.arm.execute(trajectory).code == 'CONTROL_FAILED'


@pytest.mark.statement('M30')
def test_a_goal_that_the_controller_cancels(stand: Stand) -> None:
    """
    execute_trajectory ends with -7, move_action with -4, both aborted.

    Upstream: trajectory_execution_manager.cpp, executePart; plan_execution.cpp,
    executeAndMonitor.
    """
    stand.whole.behaviour = 'give up'
    handles = (lambda: stand.arm.send_execute(stand.trajectory(*LOWER, *UPPER)),
               lambda: stand.arm.send_move(dict.fromkeys(START, 0.3)))
    for send, code in zip(handles, ('PREEMPTED', 'CONTROL_FAILED'), strict=True):
        handle = send()
        wait_for(stand.whole.waits)
        stand.whole.release()
        ended = stand.arm.ended(handle, timeout=20.0)
        assert (ended.status, ended.code) == (ABORTED, code)


@pytest.mark.statement('EXE-7')
def test_a_controller_that_is_not_there(stand: Stand) -> None:
    """-4 within seconds, and the message names its action."""
    ended = stand.arm.execute(stand.trajectory('joint_2', 'joint_3'))
    assert ended.code == 'CONTROL_FAILED'
    assert "'absent/follow_joint_trajectory'" in ended.result.error_code.message
