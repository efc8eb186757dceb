# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pause, steps, resets and pace, with controllers active."""

from __future__ import annotations

import time
from typing import Any

import pytest
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import EntityInfo, EntityState
from world_user import (
    FAILED,
    HERE,
    JOINTS,
    OK,
    PAUSED,
    PLAYING,
    pose,
    STOPPED,
    UNSUPPORTED,
    WorldUser,
)

from armsim_ros.clients.action_client import PatientActionClient
from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.clients.trajectory import ABORTED, SUCCEEDED, trajectory_message
from armsim_ros.nodes.conversions.time import ns_from_time

statement = pytest.mark.statement

TIME, STATE, SPAWNED, ALL = 1, 2, 4, 255
ALREADY, INCORRECT = 101, 103
STEP_NS = 1_000_000


@statement('A14', 'A15')
def test_a_goal_outlives_a_pause(world: WorldUser) -> None:
    """Time stands, /clock repeats it, and the goal ends as if nothing had happened."""
    goal = world.move(0.5)
    assert world.become(PAUSED)[0] == OK
    assert world.state == PAUSED
    assert world.become(PAUSED)[0] == ALREADY
    before = world.time_ns()
    stamps = {ns_from_time(message.clock) for message in world.clock().wait(3)[-2:]}
    assert stamps == {before}
    assert world.time_ns() == before
    assert world.become(PLAYING)[0] == OK
    assert goal.result().status == SUCCEEDED
    assert world.become(PLAYING)[0] == ALREADY


@statement('A15')
def test_goals_are_taken_while_paused(world: WorldUser) -> None:
    """A goal is accepted and one is cancelled; both without a step."""
    assert world.become(PAUSED)[0] == OK
    before = world.time_ns()
    goal = world.move(0.3)
    goal.cancel()
    assert goal.result().status == 5
    second = world.move(0.3)
    assert world.time_ns() == before
    assert world.become(PLAYING)[0] == OK
    assert second.result().status == SUCCEEDED


@statement('A14')
@pytest.mark.parametrize('state', [4, 5, 77])
def test_states_that_cannot_be_asked_for(world: WorldUser, state: int) -> None:
    """INCORRECT_TRANSITION, and what is allowed."""
    code, words = world.become(state)
    assert code == INCORRECT
    assert 'playing (1)' in words
    assert world.state == PLAYING


@statement('A14', 'A18')
def test_stopped_is_paused_at_the_start(world: WorldUser) -> None:
    """
    Objects and arm are back and what was spawned has gone; pause and play lead on.

    simulation_interfaces SimulationState.msg, STATE_STOPPED.
    """
    world.spawn('x')
    assert world.result('delete_entity', entity='star')[0] == OK
    world.result('set_entity_state', entity='cube', state=EntityState(pose=pose((1, 1, 2))))
    assert world.become(STOPPED)[0] == OK
    assert world.state == STOPPED
    assert 'x' not in world.entities()
    assert 'star' in world.entities()
    assert world.position('cube') == pytest.approx((0.16, 0.25, 1.04))
    assert world.become(STOPPED)[0] == ALREADY
    assert world.become(PAUSED)[0] == OK
    assert world.state == PAUSED
    assert world.become(PLAYING)[0] == OK


@statement('A16')
def test_steps_are_counted_exactly(world: WorldUser) -> None:
    """Only while time stands; /clock has the new time when the answer is there."""
    code, words = world.result('step_simulation', steps=1)
    assert code == FAILED
    assert 'pause' in words
    assert world.become(PAUSED)[0] == OK
    before = world.time_ns()
    clock = world.clock()
    for steps in (1, 7, 1500):
        assert world.result('step_simulation', steps=steps)[0] == OK
    assert world.time_ns() == before + 1508 * STEP_NS
    clock.wait_for(lambda message: ns_from_time(message.clock) == before + 8 * STEP_NS)
    clock.wait_for(lambda message: ns_from_time(message.clock) == before + 1508 * STEP_NS)
    assert world.result('step_simulation', steps=0)[0] == FAILED
    assert world.result('step_simulation', steps=10**9 + 1)[0] == FAILED
    assert world.time_ns() == before + 1508 * STEP_NS


def simulate(world: WorldUser, steps: int) -> Any:
    """Send a goal of the action; return its handle."""
    client = PatientActionClient(world.client.node, SimulateSteps, '/simulate_steps')
    assert client.wait_for_server(10.0)
    sent = world.client.in_executor(lambda: client.send_goal_async(
        SimulateSteps.Goal(steps=steps)))
    handle = world.client.result(sent)
    assert handle.accepted
    return handle


@statement('A17')
def test_the_action_steps_and_tells_how_far(world: WorldUser) -> None:
    """The last feedback has nothing left; while playing the goal is accepted and fails."""
    feedback = world.client.collect(
        '/simulate_steps/_action/feedback', SimulateSteps.Impl.FeedbackMessage)
    handle = simulate(world, 5)
    result = world.client.result(handle.get_result_async()).result
    assert result.result.result == FAILED
    assert world.become(PAUSED)[0] == OK
    before = world.time_ns()
    handle = simulate(world, 500)
    outcome = world.client.result(handle.get_result_async())
    assert (outcome.status, outcome.result.result.result) == (SUCCEEDED, OK)
    assert world.time_ns() == before + 500 * STEP_NS
    last = feedback.wait_for(lambda message: message.feedback.remaining_steps == 0)
    assert last.feedback.completed_steps == 500


@statement('A17')
def test_a_cancel_ends_the_steps(world: WorldUser) -> None:
    """CANCELED long before they are done; time has moved by what was done."""
    assert world.become(PAUSED)[0] == OK
    handle = simulate(world, 10**9)
    world.client.result(handle.cancel_goal_async())
    outcome = world.client.result(handle.get_result_async(), 5.0)
    assert outcome.status == 5
    assert world.state == PAUSED


@statement('A18', 'A19')
@pytest.mark.parametrize('gazebo', [False, True])
def test_a_reset_ends_goals_and_keeps_controllers(world: WorldUser, gazebo: bool) -> None:
    """ABORTED with the reason; arm and objects are back; the next goal works; time goes on."""
    world.spawn('x')
    before = world.time_ns()
    goal = world.move(20.0, 1.0)
    if gazebo:
        world.gazebo('reset_world')
    else:
        assert world.result('reset_simulation', scope=STATE)[0] == OK
    outcome = goal.result(timeout=15.0)
    assert outcome.status == ABORTED
    assert 'reset' in outcome.error_string
    assert 'x' in world.entities()
    assert world.time_ns() > before
    assert world.arm.send(
        trajectory_message(JOINTS, [(0.2, [0.0] * 6)])).result().status == SUCCEEDED


@statement('A18', 'A21')
def test_what_was_spawned_goes(world: WorldUser) -> None:
    """SPAWNED alone ends no goal; Gazebo's reset_simulation does both."""
    world.spawn('x')
    goal = world.move(0.3)
    assert world.result('reset_simulation', scope=SPAWNED)[0] == OK
    assert 'x' not in world.entities()
    assert goal.result().status == SUCCEEDED
    world.spawn('y')
    world.gazebo('reset_simulation')
    assert 'y' not in world.entities()


@statement('A18')
def test_a_reset_of_all_is_a_new_start(world: WorldUser) -> None:
    """
    What was deleted is there again, and infos are those of the start.

    simulation_interfaces ResetSimulation.srv, SCOPE_ALL.
    """
    before = world.call('get_entity_info', entity='cube').info
    assert world.result('set_entity_info', entity='cube', info=EntityInfo(
        category=before.category, tags=['red']))[0] == OK
    assert world.result('delete_entity', entity='star')[0] == OK
    assert world.result('reset_simulation', scope=SPAWNED | STATE)[0] == OK
    assert 'star' not in world.entities()
    assert world.result('reset_simulation', scope=ALL)[0] == OK
    assert 'star' in world.entities()
    assert world.call('get_entity_info', entity='cube').info == before


@statement('A18')
def test_time_is_not_reset_in_real_time(world: WorldUser) -> None:
    """TIME alone is unsupported; with ALL it is left out and said."""
    code, words = world.result('reset_simulation', scope=TIME)
    assert code == UNSUPPORTED
    assert 'time' in words
    before = world.time_ns()
    code, words = world.result('reset_simulation', scope=ALL)
    assert code == OK
    assert 'time' in words
    assert world.time_ns() > before
    assert world.result('reset_simulation', scope=8)[0] == UNSUPPORTED


@statement('A21')
def test_gazebos_names_pause_and_play(world: WorldUser) -> None:
    """Those who type them find them."""
    world.gazebo('pause_physics')
    assert world.state == PAUSED
    world.gazebo('unpause_physics')
    assert world.state == PLAYING


@statement('A22')
def test_the_pace_is_a_live_parameter(world: WorldUser) -> None:
    """0.1 to 100 and 0 are taken, others refused; a goal is kept through every change."""
    parameters = ParameterClient(world.client, '/simulation')
    goal = world.move(1.0)
    try:
        for factor in (0.5, 2.0, 0.0, 0.1, 100.0):
            assert parameters.set('real_time_factor', factor) == ''
        for factor in (0.05, 101.0, -1.0):
            assert 'factor' in parameters.set('real_time_factor', factor)
        parameters.set('real_time_factor', 0.0)
        wall, before = time.monotonic(), world.time_ns()
        assert goal.result().status == SUCCEEDED
        assert world.state == PLAYING
        assert world.become(PAUSED)[0] == OK
        passed, elapsed = world.time_ns() - before, time.monotonic() - wall
        assert passed * 1e-9 > 0.0
        assert elapsed < 30.0
    finally:
        assert parameters.set('real_time_factor', 1.0) == ''
    assert world.call('get_current_world').world.name == HERE
