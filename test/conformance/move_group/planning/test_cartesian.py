# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""compute_cartesian_path."""

from __future__ import annotations

import copy
from itertools import pairwise
import math
from typing import Any

from move_group_bench import name_of, seconds, turn, xyz
from moveit_msgs.msg import DisplayTrajectory
import pytest
from wire import at, box, carried, joint_goal, robot_state, thing


@pytest.fixture
def start(arm: Any) -> Any:
    """Give a bent state from which the tip can go in every direction."""
    return list(arm.states.values())[1]


def shifted(pose: Any, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    """Return a pose moved [m]."""
    moved = copy.deepcopy(pose)
    moved.position.x += x
    moved.position.y += y
    moved.position.z += z
    return moved


def tips(arm: Any, answer: Any, parts: int = 4) -> list[Any]:
    """Return the tip's poses along a solution, between its points too."""
    trajectory = answer.solution.joint_trajectory
    poses = []
    for a, b in pairwise(trajectory.points):
        for k in range(parts):
            values = [p + k / parts * (q - p)
                      for p, q in zip(a.positions, b.positions, strict=True)]
            state = dict(zip(trajectory.joint_names, values, strict=True))
            poses.append(arm.pose(state).pose)
    return poses


def off_line(point: Any, a: Any, b: Any) -> float:
    """Return how far a point is from the line through two others [m]."""
    way = [q - p for p, q in zip(a, b, strict=True)]
    length = math.hypot(*way)
    out = [q - p for p, q in zip(a, point, strict=True)]
    along = sum(p * q for p, q in zip(out, way, strict=True)) / length
    return math.sqrt(max(0.0, sum(p * p for p in out) - along * along))


@pytest.mark.statement('SRV-32', 'SRV-33', 'SRV-35', 'PM-5', 'RVZ-9')
def test_a_straight_line(arm: Any, start: Any) -> None:
    """Fraction 1; the tip keeps to the line within 1 mm, its orientation stays."""
    first = arm.pose(start).pose
    last = shifted(first, 0.0, -0.08, -0.05)
    answer = arm.cartesian([last], start_state=robot_state(start))
    assert name_of(answer.error_code) == 'SUCCESS'
    assert answer.fraction == 1.0
    a, b = xyz(first.position), xyz(last.position)
    poses = tips(arm, answer)
    assert max(off_line(xyz(pose.position), a, b) for pose in poses) < 2e-3
    assert max(turn(pose.orientation, first.orientation) for pose in poses) < 0.02


@pytest.mark.statement('SRV-32')
def test_precision_does_not_depend_on_max_step(arm: Any, start: Any) -> None:
    """With a step of 1 m the path is as straight."""
    first = arm.pose(start).pose
    last = shifted(first, 0.0, -0.08, -0.05)
    answer = arm.cartesian([last], start_state=robot_state(start), max_step=1.0)
    assert answer.fraction == 1.0
    a, b = xyz(first.position), xyz(last.position)
    assert max(off_line(xyz(pose.position), a, b) for pose in tips(arm, answer)) < 2e-3


@pytest.mark.statement('SRV-33')
def test_the_solution_starts_at_the_start(arm: Any, start: Any) -> None:
    """The first point is the start state, which comes back whole."""
    last = shifted(arm.pose(start).pose, 0.0, -0.05)
    answer = arm.cartesian([last], start_state=robot_state(start))
    trajectory = answer.solution.joint_trajectory
    assert list(trajectory.points[0].positions) == pytest.approx(
        [start[name] for name in trajectory.joint_names], abs=1e-6
    )
    assert set(answer.start_state.joint_state.name) >= set(arm.joints)


@pytest.mark.statement('SRV-33')
def test_a_path_that_goes_only_half_way(arm: Any, start: Any) -> None:
    """A waypoint out of reach: SUCCESS with the part that can be followed."""
    first = arm.pose(start).pose
    answer = arm.cartesian(
        [shifted(first, 0.0, -0.05), shifted(first, 0.0, -30.0)], start_state=robot_state(start)
    )
    assert name_of(answer.error_code) == 'SUCCESS'
    assert 0.5 <= answer.fraction < 1.0
    assert answer.solution.joint_trajectory.points


@pytest.mark.statement('SRV-33', 'SRV-36')
def test_collisions_end_the_path(arm: Any, start: Any) -> None:
    """An obstacle cuts the path; with avoid_collisions false it does not."""
    first = arm.pose(start).pose
    last = shifted(first, 0.0, -0.2)
    wall = thing('wall', arm.frame, [box(0.01, 0.01, 0.01)], pose=shifted(first, 0.0, -0.17))
    arm.add(wall)
    answer = arm.cartesian([last], start_state=robot_state(start))
    assert answer.fraction < 1.0
    free = arm.cartesian([last], start_state=robot_state(start), avoid_collisions=False)
    assert free.fraction == 1.0


@pytest.mark.statement('SRV-36')
def test_path_constraints_end_the_path(arm: Any, start: Any) -> None:
    """A joint that leaves its interval cuts the path, collisions avoided or not."""
    kept = joint_goal(start, 0.02)
    last = shifted(arm.pose(start).pose, 0.0, -0.2)
    for avoid in (True, False):
        answer = arm.cartesian([last], start_state=robot_state(start), path_constraints=kept,
                               avoid_collisions=avoid)
        assert answer.fraction < 1.0


@pytest.mark.statement('SRV-31', 'E23')
def test_codes(arm: Any, start: Any) -> None:
    """-15 group, -21 frame, -18 link, 99999 step; a message each, no solution."""
    last = shifted(arm.pose(start).pose, 0.0, -0.05)
    lost = arm.pose().header
    lost.frame_id = 'the_moon'
    for fields, code in (
        ({'group_name': 'no_such_group'}, 'INVALID_GROUP_NAME'),
        ({'header': lost}, 'FRAME_TRANSFORM_FAILURE'),
        ({'link_name': 'third_hand'}, 'INVALID_LINK_NAME'),
        ({'max_step': 0.0}, 'FAILURE'),
        ({'max_step': -1.0}, 'FAILURE'),
        ({'max_step': math.nan}, 'FAILURE'),
        ({'start_state': robot_state({'no_such_joint': 0.0})}, 'INVALID_ROBOT_STATE'),
    ):
        answer = arm.cartesian([last], **{'start_state': robot_state(start), **fields})
        assert name_of(answer.error_code) == code, fields
        assert answer.error_code.message
        assert not answer.solution.joint_trajectory.points


@pytest.mark.statement('SRV-31')
def test_no_waypoints(arm: Any) -> None:
    """SUCCESS, fraction 0, nothing else."""
    answer = arm.cartesian([])
    assert name_of(answer.error_code) == 'SUCCESS'
    assert answer.fraction == 0.0
    assert not answer.solution.joint_trajectory.points
    assert not answer.start_state.joint_state.name


@pytest.mark.statement('SRV-31')
def test_waypoints_in_the_links_own_frame(arm: Any, start: Any) -> None:
    """With the link's frame each waypoint is relative to the one before."""
    header = arm.pose().header
    header.frame_id = arm.tip
    step = at(0.0, 0.0, -0.02)
    answer = arm.cartesian([step, step], start_state=robot_state(start), header=header,
                           link_name=arm.tip)
    assert answer.fraction == 1.0
    trajectory = answer.solution.joint_trajectory
    last = dict(zip(trajectory.joint_names, trajectory.points[-1].positions, strict=True))
    gone = math.dist(xyz(arm.pose(start).pose.position), xyz(arm.pose(last).pose.position))
    assert gone == pytest.approx(0.04, abs=5e-4)


@pytest.mark.statement('SRV-34')
def test_jump_thresholds_have_no_effect(arm: Any, start: Any) -> None:
    """
    Jazzy's service passes no threshold on: joints cannot jump between states 1 mm apart.

    moveit_ros, cartesian_path_service_capability.cpp, computeService.
    """
    last = shifted(arm.pose(start).pose, 0.0, -0.05)
    for fields in ({'jump_threshold': 1e-3}, {'jump_threshold': math.nan},
                   {'revolute_jump_threshold': 1e-3, 'prismatic_jump_threshold': 1e-3}):
        answer = arm.cartesian([last], start_state=robot_state(start), **fields)
        assert (name_of(answer.error_code), answer.fraction) == ('SUCCESS', 1.0)


@pytest.mark.statement('M24')
def test_the_start_state_is_not_checked(arm: Any, start: Any) -> None:
    """A start in contact, or with a joint beyond its limit, is no error."""
    first = arm.pose(start).pose
    arm.add(thing('pad', arm.frame, [box(0.01, 0.01, 0.01)], pose=first))
    assert not arm.validity(start).valid
    last = arm.group_joints[-1]
    beyond = {**start, last: arm.limits[last][1] + 0.02}
    for state in (start, beyond):
        answer = arm.cartesian([shifted(first, 0.0, -0.1)], start_state=robot_state(state))
        assert name_of(answer.error_code) == 'SUCCESS'
        assert answer.solution.joint_trajectory.points


@pytest.mark.statement('SRV-35')
def test_timing(arm: Any, start: Any) -> None:
    """Scaling slows the path, 0 counts as 1, max_cartesian_speed is kept."""
    first = arm.pose(start).pose
    last = shifted(first, 0.0, -0.1)
    durations = {}
    for name, fields in {
        'whole': {'max_velocity_scaling_factor': 1.0, 'max_acceleration_scaling_factor': 1.0},
        'zero': {},
        'half': {'max_velocity_scaling_factor': 0.5, 'max_acceleration_scaling_factor': 0.5},
        'slow': {'max_cartesian_speed': 0.02, 'cartesian_speed_limited_link': arm.tip},
    }.items():
        answer = arm.cartesian([last], start_state=robot_state(start), **fields)
        durations[name] = seconds(answer.solution.joint_trajectory.points[-1].time_from_start)
    assert durations['zero'] == pytest.approx(durations['whole'], rel=1e-3)
    assert durations['half'] > 1.2 * durations['whole']
    assert durations['slow'] >= 0.1 / 0.02


@pytest.mark.statement('SRV-35', 'IF-41a', 'R25')
def test_the_path_is_displayed(arm: Any, start: Any) -> None:
    """display_planned_path gets Cartesian paths too."""
    heard = arm.client.collect(arm.name('display_planned_path'), DisplayTrajectory)
    down = [shifted(arm.pose(start).pose, 0.0, -0.05)]
    message = heard.wait_after(lambda: arm.cartesian(down, start_state=robot_state(start)))
    assert message.trajectory[0].joint_trajectory.points
    heard.close()


@pytest.mark.statement('MGI-5', 'UT-2')
def test_a_path_of_a_carried_objects_frame(arm: Any, start: Any) -> None:
    """link_name may be a subframe of what the robot carries."""
    item = thing('pen', arm.tip, [box(0.01, 0.01, 0.1)], pose=at(0.0, 0.0, 0.1))
    item.subframe_names, item.subframe_poses = ['point'], [at(0.0, 0.0, 0.05)]
    arm.attach(carried(item, arm.tip, arm.links))
    last = shifted(arm.pose(start, 'pen/point').pose, 0.0, -0.05)
    answer = arm.cartesian([last], start_state=robot_state(start), link_name='pen/point')
    assert answer.fraction == 1.0


@pytest.mark.statement('RVZ-9', 'UT-2')
def test_a_cartesian_path_is_executed(arm: Any) -> None:
    """The solution runs through execute_trajectory and ends at the pose."""
    state = list(arm.states.values())[1]
    assert arm.move(state).code == 'SUCCESS'
    last = shifted(arm.pose().pose, 0.0, -0.05, -0.03)
    answer = arm.cartesian([last])
    assert answer.fraction == 1.0
    assert arm.execute(answer.solution.joint_trajectory).code == 'SUCCESS'
    assert math.dist(xyz(arm.pose().pose.position), xyz(last.position)) < 5e-3
