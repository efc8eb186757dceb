# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Forward and inverse kinematics as a user of pymoveit2 asks for them."""

from __future__ import annotations

import math
from typing import Any

from arm_user import angle, until, xyz
from pymoveit2 import MoveIt2
import pytest


@pytest.mark.statement('PM-9', 'SRV-10', 'SRV-11')
def test_fk_of_the_present_of_states_and_of_several_links(user: Any, planner: MoveIt2) -> None:
    """compute_fk gives the end effector's pose now, in a state, and those of named links."""
    assert planner.compute_fk().header.frame_id == planner.base_link_name
    goal = list(user.description.joint_positions('left'))
    poses = planner.compute_fk(goal, fk_link_names=['l3', planner.end_effector_name])
    assert len(poses) == 2
    assert xyz(poses[1].pose.position) == xyz(planner.compute_fk(goal).pose.position)
    assert planner.compute_fk(goal, fk_link_names=['no_such_link']) is None


@pytest.mark.statement('PM-9', 'SRV-6')
def test_ik_reaches_the_pose(user: Any, planner: MoveIt2) -> None:
    """compute_ik gives joints whose forward kinematics is the pose, also in the background."""
    wanted = planner.compute_fk(list(user.description.joint_positions('left')))
    place = xyz(wanted.pose.position), wanted.pose.orientation
    future = planner.compute_ik_async(*place)
    until(future.done, 'the solution')
    for solution in (planner.compute_ik(*place), planner.get_compute_ik_result(future)):
        assert solution is not None
        values = dict(zip(solution.name, solution.position, strict=True))
        pose = planner.compute_fk([values[name] for name in planner.joint_names]).pose
        assert math.dist(xyz(pose.position), xyz(wanted.pose.position)) < 1e-4
        assert angle(pose.orientation, wanted.pose.orientation) < 1e-3


@pytest.mark.statement('PM-9', 'E21')
def test_ik_out_of_reach_gives_none(user: Any, planner: MoveIt2) -> None:
    """A pose out of reach has no solution, an unknown link neither."""
    assert planner.compute_ik((5.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)) is None
    near = planner.compute_fk()
    place = xyz(near.pose.position), near.pose.orientation
    assert planner.compute_ik(*place, ik_link_name='no_such_link') is None


@pytest.mark.statement('PM-9', 'SRV-5')
def test_ik_avoids_what_is_in_the_way(user: Any, planner: MoveIt2) -> None:
    """With a box where the end effector would be, there is no solution."""
    wanted = planner.compute_fk(list(user.description.joint_positions('left')))
    place = xyz(wanted.pose.position), wanted.pose.orientation
    planner.add_collision_box(
        'box', (0.1, 0.1, 0.1), position=place[0], quat_xyzw=(0.0, 0.0, 0.0, 1.0)
    )
    until(lambda: planner.compute_ik(*place) is None, 'the box in the way')
