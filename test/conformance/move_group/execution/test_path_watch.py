# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The rest of a path as it is watched while the arm moves."""

from __future__ import annotations

from typing import Any

from motions import SLOW, target, until_at_rest, until_moving
from move_group_bench import ABORTED
import pytest
from wire import box, quiet_diff, removal, thing


@pytest.mark.statement('ACT-7', 'ACT-6', 'E19')
def test_an_object_on_the_rest_of_the_path(home: Any) -> None:
    """The arm stops before it: -3."""
    goal = target(home)
    handle = home.send_move(goal, **SLOW)
    until_moving(home)
    place = home.pose(goal)
    home.add(thing('late', place.header.frame_id, [box(0.02, 0.02, 0.02)], pose=place.pose))
    ended = home.ended(handle)
    assert ended.code == 'MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE'
    assert 'late' in ended.result.error_code.message
    assert ended.status == ABORTED
    assert home.validity(home.positions()).valid


@pytest.mark.statement('ACT-7', 'E19')
def test_an_object_that_came_while_the_plan_was_made(arm: Any, long_plan: Any, log: Any) -> None:
    """
    A plan that knows nothing of it is not executed to its end: -3.

    Upstream: plan_execution.cpp, planAndExecuteHelper (new_scene_update_).
    """
    goal, diff = target(arm), quiet_diff()
    diff.world.collision_objects = [thing('refused', 'no_such_frame', [box(0.1, 0.1, 0.1)])]
    handle = arm.send_move(goal, planning_scene_diff=diff, **SLOW)
    log.wait_for_line('no_such_frame', 20.0)  # the scene of the plan is fixed, the plan waits
    place = arm.pose(goal)
    arm.add(thing('late', place.header.frame_id, [box(0.02, 0.02, 0.02)], pose=place.pose))
    arm.cancel(long_plan)
    ended = arm.ended(handle)
    assert ended.code == 'MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE', ended.result
    assert 'late' in ended.result.error_code.message
    assert arm.validity(arm.positions()).valid


@pytest.mark.statement('ACT-7')
def test_an_object_beside_the_path(home: Any) -> None:
    """The motion goes on."""
    goal = target(home)
    handle = home.send_move(goal, **{**SLOW, 'max_velocity_scaling_factor': 0.08})
    until_moving(home)
    place = home.pose(goal)
    place.pose.position.x += 5.0
    home.add(thing('beside', place.header.frame_id, [box(0.1, 0.1, 0.1)], pose=place.pose))
    assert home.ended(handle).code == 'SUCCESS'


@pytest.mark.statement('M23')
def test_the_goals_own_changes_of_the_scene_count(home: Any) -> None:
    """
    An object that the goal's scene difference removes is not in the way after a change either.

    Upstream: plan_execution.cpp, isRemainingPathValid.
    """
    goal = target(home)
    place = home.pose(goal)
    known = thing('known', place.header.frame_id, [box(0.02, 0.02, 0.02)], pose=place.pose)
    home.add(known)
    without = quiet_diff()
    gone = thing('known', place.header.frame_id, [])
    gone.operation = gone.REMOVE
    without.world.collision_objects = [gone]
    handle = home.send_move(goal, planning_scene_diff=without,
                            **{**SLOW, 'max_velocity_scaling_factor': 0.08})
    until_moving(home)
    place.pose.position.x += 5.0
    home.add(thing('beside', place.header.frame_id, [box(0.1, 0.1, 0.1)], pose=place.pose))
    assert home.ended(handle).code == 'SUCCESS'


@pytest.mark.statement('ACT-6', 'REQ-15')
def test_replanning(home: Any) -> None:
    """With replan the arm stops, plans again and arrives once the object is gone."""
    goal = target(home)
    handle = home.send_move(goal, replan=True, replan_attempts=4, replan_delay=2.5,
                            **{**SLOW, 'max_velocity_scaling_factor': 0.08})
    until_moving(home)
    place = home.pose(goal)
    home.add(thing('late', place.header.frame_id, [box(0.02, 0.02, 0.02)], pose=place.pose))
    until_at_rest(home)
    home.add(removal('late'))
    ended = home.ended(handle)
    assert ended.code == 'SUCCESS', ended.result.error_code
    assert home.distance(goal) < 0.01
