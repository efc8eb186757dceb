# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a controller does when it is activated, deactivated, and while it holds."""

from __future__ import annotations

from collections.abc import Callable

from control_msgs.action import GripperCommand
from control_msgs.srv import QueryTrajectoryState
from controller_bench import Bench, Result, TrajectoryController
import pytest

from armsim_ros.clients.trajectory import ABORTED, SUCCEEDED

statement = pytest.mark.statement
upstream = pytest.mark.upstream


@statement('C1', 'P1')
@upstream('activate', 'cleanup', 'cleanup_after_configure', 'load_controller',
          'list_controllers_srv')
def test_the_life_of_a_controller(bench: Bench, load: Callable[..., bool]) -> None:
    """Unconfigured, inactive, active, inactive, unconfigured, and gone."""
    manager = bench.manager
    assert load('mortal')
    assert manager.states()['mortal'] == 'unconfigured'
    assert not manager.switch(activate=['mortal']).ok
    assert manager.configure('mortal')
    assert manager.states()['mortal'] == 'inactive'
    bench.activate('mortal')
    assert manager.states()['mortal'] == 'active'
    assert not manager.configure('mortal')
    assert not manager.unload('mortal')
    bench.activate()
    assert manager.states()['mortal'] == 'inactive'
    assert manager.configure('mortal')
    assert manager.cleanup('mortal')
    assert manager.states()['mortal'] == 'unconfigured'
    assert manager.unload('mortal')
    assert 'mortal' not in manager.states()


@statement('C19')
def test_endpoints_come_with_the_life_cycle(bench: Bench, load: Callable[..., bool]) -> None:
    """
    A trajectory controller is there once it is configured, a gripper's action once it is active.

    joint_trajectory_controller.cpp, on_configure; gripper_action_controller_impl.hpp, on_activate.
    """
    gripper = {'joint': 'finger', 'joints': None, 'command_interfaces': None,
               'state_interfaces': None}
    query, action = bench.name('late/query_state'), bench.name('later/gripper_cmd')
    send_goal = f'{action}/_action/send_goal'
    assert load('late')
    assert load('later', 'position_controllers/GripperActionController', **gripper)
    assert bench.manager.configure('later')
    assert bench.manager.configure('late')
    bench.client.connect({query: QueryTrajectoryState})
    services = dict(bench.client.node.get_service_names_and_types())
    assert send_goal not in services
    bench.activate('later')
    bench.client.connect({send_goal: GripperCommand.Impl.SendGoalService})
    bench.activate()


@statement('C3', 'B11')
@upstream('hold_on_startup', 'test_hw_states_has_offset_first_controller_start',
          'test_hw_states_has_offset_later_controller_start',
          'test_set_last_command_interface_on_activation_false')
@pytest.mark.parametrize(('name', 'expected'), [('remembering', 0.3), ('forgetful', 0.4)])
def test_activation_holds(
    bench: Bench, arm: TrajectoryController, bias: Callable[[float], None], name: str,
    expected: float,
) -> None:
    """It holds the last command where there is one, or the measured state if told so."""
    arm.go([0.3, 0.2])
    bias(0.1)
    arm.next_state(lambda s: abs(s.feedback.positions[0] - 0.4) < 1e-3)
    next_one = bench.use(name, home=False)
    state = next_one.newest()
    assert state.reference.positions[0] == pytest.approx(expected, abs=1e-3)
    assert list(state.reference.velocities) == [0.0, 0.0]
    bias(0.0)
    next_one.home()


@statement('C4')
def test_a_push_while_holding_does_nothing(
    bench: Bench, bias: Callable[[float], None]
) -> None:
    """While it holds nothing is checked: far off, the reference stays, the next goal works."""
    c = bench.use('constrained')
    bias(0.5)
    c.next_state(lambda s: abs(s.error.positions[0]) > 0.4)
    assert {tuple(s.reference.positions) for s in c.watch(5)} == {(0.0, 0.0)}
    bias(0.0)
    c.settle()
    assert c.run(c.to([0.1, 0.1], 0.2)).status == SUCCEEDED


@statement('C5', 'H12')
def test_after_success_the_last_waypoint_is_held(
    arm: TrajectoryController, bias: Callable[[float], None]
) -> None:
    """The reference stays on the waypoint, not on the measured position."""
    bias(0.05)
    assert arm.run(arm.to([0.3, 0.2], 0.2)).status == SUCCEEDED
    arm.next_state(lambda s: abs(s.feedback.positions[0] - 0.35) < 1e-3)
    assert {tuple(s.reference.positions) for s in arm.watch(4)} == {(0.3, 0.2)}


@statement('C6')
def test_after_a_cancel_the_measured_position_is_held(
    arm: TrajectoryController, bias: Callable[[float], None]
) -> None:
    """The reference becomes the position that was measured at that moment."""
    bias(0.2)
    goal = arm.goal(arm.to([0.0, 0.0], 1.0))
    arm.next_state(lambda s: abs(s.feedback.positions[0] - 0.2) < 1e-3)
    assert goal.cancel()
    goal.result()
    held = arm.next_state(lambda s: s.reference.positions[0] != 0.0)
    assert held.reference.positions[0] == pytest.approx(0.2, abs=1e-2)


@statement('C7', 'D1')
@upstream('deactivate_controller_aborts_action')
def test_deactivation_aborts_the_goal(bench: Bench, arm: TrajectoryController) -> None:
    """ABORTED with -1 and a word on it; inactive, it takes neither goals nor messages."""
    goal = arm.goal(arm.to([1.0, 1.0], 1.0))
    goal.wait_for_feedback()
    assert bench.manager.switch(deactivate=['arm']).ok
    outcome = goal.result()
    assert outcome.status == ABORTED
    assert outcome.error_code == Result.INVALID_GOAL
    assert 'deactivat' in outcome.error_string
    assert not arm.goal(arm.to([0.0, 0.0])).accepted()
    arm.publish(arm.to([1.0, 1.0], 0.1))
    bench.activate('arm')
    arm.settle()
    held = arm.newest().reference.positions
    assert held[0] < 0.9
    assert all(list(s.reference.positions) == list(held) for s in arm.watch(15))


@statement('C7')
@pytest.mark.parametrize(('name', 'field'), [('velocity_drives', 'velocities'),
                                             ('effort_drives', 'effort')])
def test_deactivation_stops_drives(bench: Bench, name: str, field: str) -> None:
    """Velocity and effort commands end with the deactivation: the joints do not run away."""
    c = bench.use(name)
    goal = c.goal(c.to([2.0, 2.0], 1.0))
    c.next_state(lambda s: getattr(s.output, field)[0] > 0.1)
    bench.activate()
    assert goal.result().status == ABORTED
    bench.activate(name)
    c.settle()
    assert c.newest().feedback.positions[0] < 1.9


@statement('C8')
@upstream('correct_initialization_using_parameters')
def test_a_trajectory_is_not_resumed(bench: Bench, arm: TrajectoryController) -> None:
    """Activated again before the old end it holds where it is."""
    goal = arm.goal(arm.to([1.0, 1.0], 1.5))
    goal.wait_for_feedback(2)
    bench.activate()
    bench.activate('arm')
    arm.settle()
    held = arm.newest()
    assert held.reference.positions[0] < 0.8
    for state in arm.watch(20):
        assert list(state.reference.positions) == list(held.reference.positions)
    assert goal.result().status == ABORTED


@statement('C9')
def test_integrators_are_cleared(
    bench: Bench, load: Callable[..., bool], fault: Callable[..., None]
) -> None:
    """What an integrator has gathered is gone at the next activation."""
    gains = {joint: {'p': 1.0, 'i': 20.0, 'i_clamp': 100.0} for joint in ('drive_1', 'drive_2')}
    assert load(
        'integral', joints=['drive_1', 'drive_2'], command_interfaces=['velocity'], gains=gains
    )
    assert bench.manager.configure('integral')
    c = bench.use('integral', home=False)
    fault('drive_1', 'blocked', True)
    first, second = c.newest().reference.positions
    goal = c.goal(c.to([first + 0.5, second], 0.2))
    c.next_state(lambda s: s.output.velocities[0] > 3.0)
    bench.activate()
    goal.result()
    bench.activate('integral')
    state = c.newest()
    assert abs(state.output.velocities[0]) < 1.0 + abs(state.error.positions[0])
    fault('drive_1', 'blocked', False)
    bench.activate()
