# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sequences whose motions are of different planning groups."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from armsim_ros.config.pipeline_defaults import PILZ
from armsim_ros.errors import MoveItErrorCode
from armsim_ros.planning.pilz.sequence import SequenceItem
from armsim_ros.planning.request import Constraints, MotionPlanRequest
from armsim_ros.planning.scene.update import StartState


def ptp(side: str, first: float, radius: float = 0.0, **options: Any) -> SequenceItem:
    """Return a PTP of an arm's first joint [rad]."""
    goal = Constraints.of_joints({f'{side}_axis1': first})
    return SequenceItem(MotionPlanRequest(
        side, (goal,), pipeline_id=PILZ, planner_id='PTP', **options), radius)


def planned(planner: Any, scene: Any, *items: SequenceItem) -> Any:
    """Return the answer to a sequence."""
    return planner.plan_sequence(items, scene.snapshot(), clock=time.monotonic)


def test_each_change_of_group_begins_a_trajectory(pair_scene: Any, plan_for: Any) -> None:
    """
    Motions of one group in a row are one trajectory; a group goes on where it ended.

    pilz, plan_components_builder.cpp, append; command_list_manager.cpp, setStartState.
    """
    answer = planned(plan_for(pair_scene), pair_scene, ptp('left', 0.5), ptp('left', 0.7),
                     ptp('right', 0.5), ptp('left', 0.9))
    assert answer.error_code == MoveItErrorCode.SUCCESS, answer.message
    names = [trajectory.joint_names[0] for trajectory in answer.trajectories]
    assert names == ['left_axis1', 'right_axis1', 'left_axis1']
    assert [request.group_name for request in answer.requests] == ['left', 'right', 'left']
    ends = [trajectory.positions[[0, -1], 0]
            for trajectory in answer.trajectories]
    assert np.concatenate(ends) == pytest.approx([0.3, 0.7, 0.3, 0.5, 0.7, 0.9])


def test_radius_at_a_change_of_group_is_a_stop(
    pair_scene: Any, plan_for: Any, log: Any
) -> None:
    """
    There is no blend between groups: a warning, and a stop.

    pilz, command_list_manager.cpp, extractBlendRadii.
    """
    answer = planned(plan_for(pair_scene), pair_scene, ptp('left', 0.5, 0.1), ptp('right', 0.5))
    assert answer.error_code == MoveItErrorCode.SUCCESS, answer.message
    assert len(answer.trajectories) == 2
    assert "motion 0 of group 'left' ends with a stop" in log.recorder.text()


def test_each_group_may_have_its_own_start_state(pair_scene: Any, plan_for: Any) -> None:
    """
    The first motion of a group may give a start state, later ones of that group not.

    pilz, command_list_manager.cpp, checkStartStatesOfGroup.
    """
    planner = plan_for(pair_scene)
    there = {'start_state': StartState(('right_axis1',), (0.1,), is_diff=True)}
    answer = planned(planner, pair_scene, ptp('left', 0.5), ptp('right', 0.5, **there))
    assert answer.error_code == MoveItErrorCode.SUCCESS, answer.message
    assert answer.trajectories[1].positions[0, 0] == pytest.approx(0.1)
    answer = planned(planner, pair_scene, ptp('right', 0.4), ptp('left', 0.5),
                     ptp('right', 0.5, **there))
    assert answer.error_code == MoveItErrorCode.INVALID_ROBOT_STATE


def test_group_without_solver_has_no_command(pair_scene: Any, plan_for: Any) -> None:
    """
    A motion of a group without solver fails, and the sequence with it.

    pilz, pilz_industrial_motion_planner.cpp, canServiceRequest.
    """
    goal = Constraints.of_joints({'left_axis1': 0.5})
    item = SequenceItem(MotionPlanRequest(
        'both', (goal,), pipeline_id=PILZ, planner_id='PTP'))
    answer = planned(plan_for(pair_scene), pair_scene, item)
    assert answer.error_code == MoveItErrorCode.FAILURE
    assert 'PLANNING_FAILED' in answer.message
