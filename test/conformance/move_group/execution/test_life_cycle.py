# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Goals of move_action and execute_trajectory from their acceptance to their end."""

from __future__ import annotations

from collections.abc import Callable
import itertools
from typing import Any

from arm_user import until
from motions import SLOW, target, until_at_rest, until_moving
from move_group_bench import ABORTED, CANCELED, seconds, SUCCEEDED
import pytest
from std_msgs.msg import String
from wire import quiet_diff, robot_state

from armsim_ros.clients.client_node import ClientNode


@pytest.fixture(scope='module')
def publish_event(running: Any) -> Callable[[str], None]:
    """Give a function that publishes a word on trajectory_execution_event."""
    publisher = running.client.node.create_publisher(
        String, running.name('trajectory_execution_event'), 10
    )
    until(publisher.get_subscription_count, 'a subscriber of the event')
    return lambda word: publisher.publish(String(data=word))


@pytest.mark.statement('SEED-1', 'RVZ-7', 'RVZ-8', 'ACT-1', 'ACT-3', 'MGI-4')
def test_plan_and_execute(home: Any) -> None:
    """A named state planned and executed as RViz does it: the arm stands there at the end."""
    for name in (*list(home.states)[1:], next(iter(home.states))):
        ended = home.move(name, allowed_planning_time=5.0, num_planning_attempts=10)
        assert (ended.status, ended.code) == (SUCCEEDED, 'SUCCESS'), ended.result.error_code
        assert home.distance(name) < 0.01
        assert ended.result.planning_time > 0.0


@pytest.mark.statement('SEED-1')
def test_the_posts_last_step(arm: Any) -> None:
    """Goal state scan_food, Plan & Execute: the simulated arm moves there."""
    if 'scan_food' not in arm.states:
        pytest.skip('the robot under test has no state scan_food')
    assert arm.move('home').code == 'SUCCESS'
    ended = arm.move('scan_food', max_velocity_scaling_factor=0.5,
                     max_acceleration_scaling_factor=0.5)
    assert (ended.status, ended.code) == (SUCCEEDED, 'SUCCESS')
    assert arm.distance('scan_food') < 0.01


@pytest.mark.statement('ACT-1')
def test_feedback_of_plan_only(arm: Any) -> None:
    """PLANNING, then IDLE."""
    assert arm.move(arm.near(), plan_only=True).feedback == ['PLANNING', 'IDLE']


@pytest.mark.statement('ACT-1')
def test_feedback_of_a_motion(home: Any) -> None:
    """PLANNING, MONITOR, IDLE; of an execution MONITOR, a sentence, IDLE."""
    ended = home.move(home.near())
    assert ended.feedback == ['PLANNING', 'MONITOR', 'IDLE']
    ended = home.execute(home.planned(home.near()))
    assert ended.feedback[0] == 'MONITOR'
    assert ended.feedback[-1] == 'IDLE'
    assert len(ended.feedback) == 3


@pytest.mark.statement('RVZ-7', 'MGI-3', 'PM-6')
def test_plan_then_execute(home: Any) -> None:
    """RViz's two buttons: the plan of the one is run by the other."""
    goal = target(home)
    ended = home.move(goal, plan_only=True)
    ended = home.execute(ended.result.planned_trajectory.joint_trajectory)
    assert (ended.status, ended.code) == (SUCCEEDED, 'SUCCESS')
    assert home.distance(goal) < 0.01


@pytest.mark.statement('ACT-3', 'MGI-4')
def test_a_failing_goal_is_aborted(arm: Any) -> None:
    """A goal without a plan ends aborted, with code and message."""
    ended = arm.move(arm.near(), group_name='no_such_group')
    assert (ended.status, ended.code) == (ABORTED, 'INVALID_GROUP_NAME')
    assert ended.result.error_code.message


@pytest.mark.statement('ACT-4')
def test_already_there(home: Any) -> None:
    """A goal that is satisfied already: SUCCESS at once, no trajectory."""
    ended = home.move(home.positions())
    assert ended.code == 'SUCCESS'
    assert not ended.result.planned_trajectory.joint_trajectory.points


@pytest.mark.statement('REQ-7', 'REQ-13')
def test_a_start_state_is_discarded_when_the_arm_moves(home: Any) -> None:
    """REQ-7h: a motion begins where the robot is."""
    goal = home.near(0.3)
    ended = home.move(goal, start_state=robot_state(target(home)))
    assert ended.code == 'SUCCESS'
    assert home.distance(goal) < 0.01


@pytest.mark.statement('ACT-5', 'UT-1')
def test_cancel_before_the_plan(home: Any) -> None:
    """A goal cancelled at once ends; the resent goal succeeds."""
    for plan_only in (True, False):
        handle = home.send_move(target(home), plan_only=plan_only)
        home.cancel(handle)
        ended = home.ended(handle)
        assert (ended.status, ended.code) in (
            (CANCELED, 'PREEMPTED'), (SUCCEEDED, 'SUCCESS')
        )
        assert home.move(target(home), plan_only=True).code == 'SUCCESS'


@pytest.mark.alone
@pytest.mark.statement('ACT-5', 'ACT-3', 'E18')
def test_cancel_of_a_motion(home: Any) -> None:
    """The controllers are cancelled: -7, canceled, and the arm is at rest within 0.5 s."""
    handle = home.send_move(target(home), **SLOW)
    until_moving(home)
    home.cancel(handle)
    assert until_at_rest(home) < 0.5
    ended = home.ended(handle)
    assert (ended.status, ended.code) == (CANCELED, 'PREEMPTED')
    assert home.distance(target(home)) > 0.05
    assert home.move(next(iter(home.states))).code == 'SUCCESS'


@pytest.mark.alone
@pytest.mark.statement('ACT-10', 'ACT-3')
def test_cancel_of_an_execution(home: Any) -> None:
    """execute_trajectory stops the arm: at rest within 0.5 s, -7, canceled."""
    trajectory = home.planned(target(home), **SLOW)
    handle = home.send_execute(trajectory)
    until_moving(home)
    home.cancel(handle)
    assert until_at_rest(home) < 0.5
    ended = home.ended(handle)
    assert (ended.status, ended.code) == (CANCELED, 'PREEMPTED')
    assert home.distance(target(home)) > 0.05


@pytest.mark.statement('ACT-8', 'SRV-72', 'E20', 'MGI-3', 'PM-6', 'RVZ-10', 'M30')
@pytest.mark.parametrize(('action', 'code'), [
    ('move_action', 'CONTROL_FAILED'), ('execute_trajectory', 'PREEMPTED')])
def test_the_stop_event(
    publish_event: Callable[[str], None], home: Any, action: str, code: str
) -> None:
    """
    'stop' ends the motion of either action: a plan has failed, an execution is preempted.

    Upstream: plan_execution.cpp, executeAndMonitor; trajectory_execution_manager.cpp.
    """
    if action == 'move_action':
        handle = home.send_move(target(home), **SLOW)
    else:
        handle = home.send_execute(home.planned(target(home), **SLOW))
    until_moving(home)
    publish_event('stop')
    ended = home.ended(handle)
    assert (ended.status, ended.code) == (ABORTED, code)
    assert home.distance(target(home)) > 0.05


@pytest.mark.statement('SRV-72', 'IF-35')
def test_other_events_and_needless_stops(
    publish_event: Callable[[str], None], home: Any, log: Any
) -> None:
    """Another word is a warning, a stop of nothing does no harm."""
    publish_event('sing')
    log.wait_for_line("'sing' is not known")
    publish_event('stop')
    assert home.move(home.near()).code == 'SUCCESS'


@pytest.mark.statement('ACT-9')
def test_a_second_goal_while_the_first_moves(home: Any) -> None:
    """It plans and is then refused with -4; the first one arrives."""
    goal = target(home)
    first = home.send_move(goal, **{**SLOW, 'max_velocity_scaling_factor': 0.07})
    until_moving(home)
    second = home.move(next(iter(home.states)))
    assert second.code == 'CONTROL_FAILED'
    assert second.result.error_code.message
    assert home.ended(first).code == 'SUCCESS'
    assert home.distance(goal) < 0.01


@pytest.mark.statement('ACT-9')
def test_plans_beside_each_other(arm: Any) -> None:
    """Goals that only plan all succeed, also beside a motion."""
    handles = [arm.send_move(arm.near(0.1 * k), plan_only=True) for k in range(1, 6)]
    assert [arm.ended(handle).code for handle in handles] == ['SUCCESS'] * 5


@pytest.mark.statement('ACT-9')
def test_executions_queue(home: Any) -> None:
    """Two trajectories sent at once run one after the other."""
    there = home.planned(home.near(0.2))
    end = dict(zip(there.joint_names, there.points[-1].positions, strict=True))
    back = home.planned(next(iter(home.states)), start_state=robot_state(end))
    handles = [home.send_execute(there), home.send_execute(back)]
    assert [home.ended(handle).code for handle in handles] == ['SUCCESS', 'SUCCESS']
    assert home.distance(next(iter(home.states))) < 0.01


@pytest.mark.statement('ACT-13', 'EXE-2')
def test_trajectories_that_move_nothing(arm: Any) -> None:
    """An empty one is SUCCESS at once, unknown joints are -4."""
    trajectory = arm.planned(arm.near())
    empty = type(trajectory)()
    assert arm.execute(empty).code == 'SUCCESS'
    trajectory.joint_names = [f'no_{name}' for name in trajectory.joint_names]
    ended = arm.execute(trajectory)
    assert (ended.status, ended.code) == (ABORTED, 'CONTROL_FAILED')
    assert 'no_' in ended.result.error_code.message


@pytest.mark.statement('EXE-6')
def test_sizes_that_differ(arm: Any) -> None:
    """A point with fewer positions than names is -4."""
    trajectory = arm.planned(arm.near())
    trajectory.points[1].positions = trajectory.points[1].positions[:-1]
    ended = arm.execute(trajectory)
    assert ended.code == 'CONTROL_FAILED'
    assert ended.result.error_code.message


@pytest.mark.statement('EXE-5', 'E15', 'UT-4')
def test_a_trajectory_from_elsewhere(home: Any) -> None:
    """Not started: -4, with joint, expected and actual position; the arm stays."""
    before = home.positions()
    trajectory = home.planned(home.near(), start_state=robot_state(target(home)))
    ended = home.execute(trajectory)
    assert (ended.status, ended.code) == (ABORTED, 'CONTROL_FAILED')
    assert 'start point deviates from current robot state' in ended.result.error_code.message
    assert home.positions() == pytest.approx(before, abs=2e-3)


@pytest.mark.statement('EXE-5', 'PAR-5', 'UT-4')
def test_the_start_tolerance_is_a_parameter(home: Any) -> None:
    """A joint's own tolerance lets a start pass; 0 leaves it unchecked."""
    name = 'trajectory_execution.allowed_start_tolerance'
    usual = home.execution_parameters.get(name)
    shifted = home.near(0.05)
    trajectory = home.planned(home.near(0.2), start_state=robot_state(shifted))
    assert home.execute(trajectory).code == 'CONTROL_FAILED'
    assert home.execution_parameters.set(name, 0.0) == ''
    ended = home.execute(trajectory)
    assert home.execution_parameters.set(name, usual) == ''
    assert ended.code in ('SUCCESS', 'CONTROL_FAILED')
    assert 'start point deviates' not in ended.result.error_code.message


@pytest.mark.statement('ACT-12', 'EXE-3')
def test_controllers_by_name(home: Any) -> None:
    """A named controller is used, an unknown one is -4."""
    (known,) = home.parameters.get('moveit_simple_controller_manager.controller_names')[:1]
    assert home.execute(home.planned(home.near(0.1)), [known]).code == 'SUCCESS'
    ended = home.execute(home.planned(home.near(0.1)), ['nobody'])
    assert ended.code == 'CONTROL_FAILED'
    assert 'nobody' in ended.result.error_code.message


@pytest.mark.statement('ACT-11', 'CAP-3', 'PAR-4')
def test_execution_switched_off(home: Any) -> None:
    """execute_trajectory is -4, move_action plans only and says SUCCESS."""
    trajectory = home.planned(home.near(0.2))
    before = home.positions()
    assert home.parameters.set('allow_trajectory_execution', False) == ''
    try:
        assert home.execute(trajectory).code == 'CONTROL_FAILED'
        assert home.move(home.near(0.3)).code == 'SUCCESS'
    finally:
        assert home.parameters.set('allow_trajectory_execution', True) == ''
    assert home.positions() == pytest.approx(before, abs=2e-3)


@pytest.mark.statement('EXE-15')
def test_everything_goes_on_during_a_motion(home: Any) -> None:
    """Joint states flow, services answer and others plan while the arm moves."""
    handle = home.send_move(target(home), **SLOW)
    until_moving(home)
    assert home.scene().robot_model_name
    assert home.planned(home.near(0.1)).points
    assert home.apply(quiet_diff())
    home.cancel(handle)
    assert home.ended(handle).code == 'PREEMPTED'


@pytest.mark.statement('PAR-6')
def test_executed_trajectory(home: Any) -> None:
    """
    Empty at frequency 0; with a frequency it holds the measured states from the start on.

    moveit_ros trajectory_monitor.cpp, recordStates.
    """
    name = 'plan_execution.record_trajectory_state_frequency'
    ended = home.move(home.near(0.2))
    assert ended.code == 'SUCCESS'
    assert not ended.result.executed_trajectory.joint_trajectory.points
    assert home.parameters.set(name, 10.0) == ''
    begin = home.positions()
    ended = home.move(next(iter(home.states)), max_velocity_scaling_factor=0.1)
    assert home.parameters.set(name, 0.0) == ''
    trajectory = ended.result.executed_trajectory.joint_trajectory
    assert list(trajectory.joint_names) == home.group_joints
    assert list(trajectory.points[0].positions) == pytest.approx(
        [begin[joint] for joint in home.group_joints], abs=0.02)
    times = [seconds(point.time_from_start) for point in trajectory.points]
    assert times[0] == 0.0
    assert len(times) > 2
    assert all(later - earlier >= 0.1 - 1e-6 for earlier, later in itertools.pairwise(times))


@pytest.mark.statement('ACT-14')
def test_a_client_that_leaves(home: Any) -> None:
    """The motion of a client that goes away is finished, and then the next one runs."""
    goal = home.near(0.3)
    domain = home.client.context.get_domain_id()
    with ClientNode(domain, 'guest') as guest:
        other = type(home)(guest, home.namespace, home.joint_states.topic)
        other.send_move(goal, max_velocity_scaling_factor=0.3)
    for _ in range(1000):
        if home.distance(goal) < 0.01:
            break
    assert home.distance(goal) < 0.01
    # What comes while the first motion ends is refused.
    assert any(home.move(target(home)).code == 'SUCCESS' for _ in range(20))


@pytest.mark.statement('EXE-9', 'EXE-11')
def test_at_rest_at_the_end(home: Any) -> None:
    """When the goal ends the arm stands still."""
    assert home.move(target(home)).code == 'SUCCESS'
    first = home.positions()
    home.joint_states.clear()
    home.joint_states.wait(10)
    assert home.positions() == pytest.approx(first, abs=2e-3)
