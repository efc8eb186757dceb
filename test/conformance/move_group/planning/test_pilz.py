# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""PTP, LIN and CIRC over the wire."""

from __future__ import annotations

import copy
from itertools import pairwise
import math
from typing import Any

from move_group_bench import name_of, seconds, xyz
from moveit_msgs.msg import Constraints
import pytest
from visualization_msgs.msg import Marker, MarkerArray
from wire import box, joint_goal, pose_goal, position_goal, robot_state, thing

PILZ = 'pilz_industrial_motion_planner'


@pytest.fixture
def start(arm: Any) -> Any:
    """Give a bent state."""
    return list(arm.states.values())[1]


def command(arm: Any, start: Any, name: str, goal: Any, **fields: Any) -> dict[str, Any]:
    """Return the fields of a request for a command from a state."""
    return {
        'goal': goal, 'pipeline_id': PILZ, 'planner_id': name, 'start_state': robot_state(start),
        'max_velocity_scaling_factor': 0.1, 'max_acceleration_scaling_factor': 0.1, **fields,
    }


def moved(pose: Any, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    """Return a stamped pose moved [m]."""
    there = copy.deepcopy(pose)
    there.pose.position.x += x
    there.pose.position.y += y
    there.pose.position.z += z
    return there


def tips(arm: Any, trajectory: Any) -> list[tuple[float, float, float]]:
    """Return where the tip is at every point."""
    return [
        xyz(arm.pose(dict(zip(trajectory.joint_names, p.positions, strict=True))).pose.position)
        for p in trajectory.points
    ]


@pytest.mark.statement('PLZ-5', 'PLZ-9', 'M33')
def test_ptp(arm: Any, start: Any) -> None:
    """All joints are at the same share of their way; a point every 0.1 s at least."""
    goal = {name: start[name] + 0.3 * (k + 1) / 6 for k, name in enumerate(arm.group_joints)}
    trajectory = arm.planned(**command(arm, start, 'PTP', goal))
    for point in trajectory.points:
        shares = [
            (p - start[name]) / (goal[name] - start[name])
            for name, p in zip(trajectory.joint_names, point.positions, strict=True)
        ]
        assert max(shares) - min(shares) < 1e-6
    times = [seconds(point.time_from_start) for point in trajectory.points]
    assert all(0.0 < b - a <= 0.1 + 1e-6 for a, b in pairwise(times))


@pytest.mark.statement('PLZ-3', 'M31', 'M32')
def test_lin(arm: Any, start: Any) -> None:
    """Every point lies on the line, and the last one at the goal."""
    first = arm.pose(start)
    goal = moved(first, -0.05, -0.05, -0.02)
    trajectory = arm.planned(**command(arm, start, 'LIN', pose_goal(arm.tip, goal)))
    a, b = xyz(first.pose.position), xyz(goal.pose.position)
    places = tips(arm, trajectory)
    assert math.dist(places[-1], b) < 1e-3
    for place in places:
        assert math.dist(a, place) + math.dist(place, b) < math.dist(a, b) + 2e-5


@pytest.mark.statement('PLZ-4', 'M35')
def test_circ(arm: Any, start: Any) -> None:
    """Every point is on the circle about the centre, which needs a pose but no primitive."""
    first = arm.pose(start)
    center, goal = moved(first, -0.05), moved(first, -0.05, 0.0, -0.05)
    kept = Constraints(name='center', position_constraints=[position_goal(arm.tip, center)])
    kept.position_constraints[0].constraint_region.primitives = []
    trajectory = arm.planned(
        **command(arm, start, 'CIRC', pose_goal(arm.tip, goal), path_constraints=kept)
    )
    for place in tips(arm, trajectory):
        assert math.dist(place, xyz(center.pose.position)) == pytest.approx(0.05, abs=1e-3)


@pytest.mark.statement('PLZ-1', 'PLZ-2', 'PLZ-3', 'M34', 'M37')
@pytest.mark.parametrize(('fields', 'code'), [
    ({'max_velocity_scaling_factor': 0.0}, 'INVALID_MOTION_PLAN'),
    ({'max_acceleration_scaling_factor': 1.1}, 'INVALID_MOTION_PLAN'),
    ({'group_name': 'no_such_group'}, 'PLANNING_FAILED'),
    ({'planner_id': 'SPLINE'}, 'PLANNING_FAILED'),
    ({'goals': 0}, 'INVALID_GOAL_CONSTRAINTS'),
    ({'goals': 2}, 'INVALID_GOAL_CONSTRAINTS'),
    ({'joint': 'no_such_joint'}, 'INVALID_GOAL_CONSTRAINTS'),
    ({'mixed': True}, 'INVALID_GOAL_CONSTRAINTS'),
    ({'link': 'third_hand'}, 'NO_IK_SOLUTION'),
    ({'far': True}, 'NO_IK_SOLUTION'),
    ({'moving': True}, 'INVALID_ROBOT_STATE'),
])
def test_codes(arm: Any, start: Any, fields: dict[str, Any], code: str) -> None:
    """Each broken precondition has its code, and a message."""
    pose = moved(arm.pose(start), -0.05, -0.05)
    if fields.get('far'):
        pose = moved(pose, 50.0)
    goal = pose_goal(fields.get('link', arm.tip), pose)
    if 'joint' in fields:
        goal = joint_goal({fields['joint']: 0.0})
    if fields.get('mixed'):
        goal.joint_constraints = joint_goal({arm.group_joints[0]: 0.0}).joint_constraints
    state = robot_state(start)
    if fields.get('moving'):
        state.joint_state.velocity = [0.5] * len(start)
    own = {key: value for key, value in fields.items()
           if key not in ('goals', 'joint', 'mixed', 'link', 'far', 'moving')}
    wanted = command(arm, start, 'LIN', [goal] * fields.get('goals', 1), start_state=state)
    assert name_of(arm.refused(**{**wanted, **own})) == code


@pytest.mark.statement('PLZ-4')
@pytest.mark.parametrize(('case', 'code'), [
    ('name', 'INVALID_MOTION_PLAN'), ('count', 'INVALID_MOTION_PLAN'),
    ('colinear', 'INVALID_MOTION_PLAN'), ('radius', 'INVALID_MOTION_PLAN'),
])
def test_circ_codes(arm: Any, start: Any, case: str, code: str) -> None:
    """What is no circle is refused with the code of its mistake."""
    first = arm.pose(start)
    goal = moved(first, -0.05, 0.0, -0.05)
    point = moved(first, *{'colinear': (-0.025, 0.0, -0.025), 'radius': (-0.01, 0.0, 0.0)}.get(
        case, (-0.05, 0.0, 0.0)
    ))
    kept = Constraints(name='interim' if case == 'colinear' else 'center')
    kept.position_constraints = [position_goal(arm.tip, point)]
    if case == 'name':
        kept.name = 'somewhere'
    elif case == 'count':
        kept.position_constraints = []
    wanted = command(arm, start, 'CIRC', pose_goal(arm.tip, goal), path_constraints=kept)
    assert name_of(arm.refused(**wanted)) == code


@pytest.mark.statement('PLZ-6', 'ADP-8', 'R26')
def test_an_obstacle_in_the_way(arm: Any, start: Any) -> None:
    """The command is not bent round it: -2 with its contacts, and -10 where the start is in it."""
    shown = arm.client.collect(arm.name('display_contacts'), MarkerArray)
    first = arm.pose(start)
    goal = moved(first, 0.0, -0.15)
    cube = box(0.02, 0.02, 0.02)
    arm.add(thing('post', arm.frame, [cube], pose=moved(first, 0.0, -0.12).pose))
    wanted = command(arm, start, 'LIN', pose_goal(arm.tip, goal))
    code = arm.refused(**wanted)
    assert name_of(code) == 'INVALID_MOTION_PLAN'
    assert 'post' in code.message
    erased, *spheres = shown.wait_after(lambda: arm.refused(**wanted)).markers
    shown.close()
    assert erased.action == Marker.DELETEALL
    assert all('post' in sphere.ns.split('=') for sphere in spheres)
    assert spheres[0].id == 0
    arm.add(thing('post', arm.frame, [cube], pose=first.pose))
    assert name_of(arm.refused(**wanted)) == 'START_STATE_IN_COLLISION'


@pytest.mark.statement('PLZ-7', 'CFG-10')
def test_cartesian_limits_are_parameters(arm: Any) -> None:
    """The tool's limits are declared under their names."""
    prefix = 'robot_description_planning.cartesian_limits'
    for name in ('max_trans_vel', 'max_trans_acc', 'max_trans_dec', 'max_rot_vel'):
        assert isinstance(arm.parameters.get(f'{prefix}.{name}'), float)


@pytest.mark.statement('PLZ-3')
def test_lin_is_executed(arm: Any, start: Any) -> None:
    """A line through move_action ends at its goal."""
    assert arm.move(start).code == 'SUCCESS'
    goal = moved(arm.pose(), -0.05, -0.05, -0.02)
    ended = arm.move(
        pose_goal(arm.tip, goal), pipeline_id=PILZ, planner_id='LIN',
        max_velocity_scaling_factor=0.1, max_acceleration_scaling_factor=0.1,
    )
    assert ended.code == 'SUCCESS', ended.result.error_code
    assert math.dist(xyz(arm.pose().pose.position), xyz(goal.pose.position)) < 5e-3
