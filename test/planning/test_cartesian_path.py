# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of Cartesian paths."""

from itertools import pairwise
import math

import numpy as np
import pytest

from armsim_ros.model.transforms import pose_matrix, rotation_angle
from armsim_ros.planning.cartesian_curves import Line
from armsim_ros.planning.request import CartesianRequest, Constraints, JointConstraint
from armsim_ros.planning.scene.update import StartState

SIX = tuple(f'axis{k}' for k in range(1, 7))
BENT = (0.3, 0.7, 1.2, 0.2, 0.9, 0.1)


@pytest.fixture
def scene(six_scene):
    """Return a scene with the arm bent, away from singularities."""
    six_scene.set_positions(dict(zip(SIX, BENT, strict=True)))
    return six_scene


@pytest.fixture
def tool(scene):
    """Return the tool's pose at the start."""
    return scene.frame_pose('tool')


def moved(pose, xyz=(0.0, 0.0, 0.0), rpy=(0.0, 0.0, 0.0)):
    """Return a pose shifted in the base frame and turned about its own axes."""
    result = pose @ pose_matrix((0.0, 0.0, 0.0), rpy)
    result[:3, 3] += xyz
    return result


def states(response, model):
    """Return the full state at every point."""
    return [model.vector(dict(zip(SIX, positions, strict=True)))
            for positions in response.trajectory.positions]


def test_straight_line(scene, tool, six, plan_for):
    """SRV-32: the link stays on the line within 1 mm and reaches its end; fraction 1."""
    goal = moved(tool, (0.0, 0.15, -0.1))
    response = plan_for(scene).cartesian_path(CartesianRequest('arm', (goal,), 0.01), scene)
    assert response.error_code == 1
    assert response.fraction == pytest.approx(1.0)
    line = goal[:3, 3] - tool[:3, 3]
    length = np.linalg.norm(line)
    for q in states(response, six):
        off = six.link_pose(q, 'tool')[:3, 3] - tool[:3, 3]
        assert np.linalg.norm(off - line * (off @ line) / length**2) < 1e-3
    assert six.link_pose(q, 'tool') == pytest.approx(goal, abs=1e-5)


@pytest.mark.parametrize('max_step', [0.2, 0.0025])
def test_precision_does_not_depend_on_max_step(scene, tool, six, plan_for, max_step):
    """SRV-32: steps are halved until the middle is within 1 mm, however large max_step is."""
    goal = moved(tool, (-0.05, 0.2, 0.0))
    response = plan_for(scene).cartesian_path(CartesianRequest('arm', (goal,), max_step), scene)
    assert response.fraction == pytest.approx(1.0)
    heights = [six.link_pose(q, 'tool')[2, 3] for q in states(response, six)]
    assert len(heights) > 20
    assert np.ptp(heights) < 2e-3


def test_rotation_is_even(scene, tool, six, plan_for):
    """SRV-32: orientation goes the short way from one to the other."""
    goal = moved(tool, rpy=(0.3, -0.4, 0.2))
    response = plan_for(scene).cartesian_path(CartesianRequest('arm', (goal,), 0.01), scene)
    assert response.fraction == pytest.approx(1.0)
    turn = rotation_angle(tool, goal)
    for q in states(response, six):
        here = six.link_pose(q, 'tool')
        assert rotation_angle(tool, here) + rotation_angle(here, goal) == pytest.approx(
            turn, abs=0.011)
        assert np.linalg.norm(here[:3, 3] - tool[:3, 3]) < 1.5e-3


@pytest.mark.parametrize(('xyz', 'rpy'), [
    ((0.0, 0.0, 0.0), (0.9, -1.2, 0.6)), ((0.0, 0.2, 0.0), (0.0, 0.0, 0.0)),
    ((-0.05, 0.1, 0.0), (0.3, 0.3, -0.5))])
def test_the_middle_of_a_step_is_on_the_path(scene, tool, six, plan_for, xyz, rpy):
    """SRV-32: the joints' middle between two points is within 1 mm and 0.01 rad of the path."""
    goal = moved(tool, xyz, rpy)
    path = Line(tool, goal)
    response = plan_for(scene).cartesian_path(CartesianRequest('arm', (goal,), 10.0), scene)
    points = states(response, six)
    assert np.allclose(six.link_pose(points[-1], 'tool'), goal, atol=1e-5)
    for q in (0.5 * (a + b) for a, b in pairwise(points)):
        here = six.link_pose(q, 'tool')
        assert min(
            max(np.linalg.norm(here[:3, 3] - wanted[:3, 3]) / 1.1e-3,
                rotation_angle(here, wanted) / 1.1e-2)
            for wanted in map(path.pose, np.linspace(0.0, 1.0, 2000))) < 1.0


def test_several_waypoints(scene, tool, six, plan_for):
    """SRV-31: all waypoints are passed in their order."""
    corners = [moved(tool, xyz) for xyz in ((0, 0.1, 0), (0, 0.1, -0.1), (0, 0, -0.1))]
    response = plan_for(scene).cartesian_path(
        CartesianRequest('arm', tuple(corners), 0.01), scene)
    assert response.fraction == pytest.approx(1.0)
    path = np.array([six.link_pose(q, 'tool')[:3, 3] for q in states(response, six)])
    nearest = [np.linalg.norm(path - corner[:3, 3], axis=1) for corner in corners]
    assert all(each.min() < 4e-3 for each in nearest)
    order = [int(each.argmin()) for each in nearest]
    assert order == sorted(order)


def test_waypoints_relative_to_the_link(scene, tool, six, plan_for):
    """SRV-31: with the link as frame each waypoint counts from where the link is then."""
    step = pose_matrix((0.0, 0.0, -0.05))
    response = plan_for(scene).cartesian_path(
        CartesianRequest('arm', (step, step), 0.01, 'tool', 'tool'), scene)
    assert response.fraction == pytest.approx(1.0)
    end = six.link_pose(states(response, six)[-1], 'tool')
    assert end == pytest.approx(tool @ step @ step, abs=1e-5)


def test_other_link(scene, six, plan_for):
    """SRV-30: another link of the group may be led."""
    goal = moved(scene.frame_pose('segment6'), (0.0, 0.0, -0.05))
    response = plan_for(scene).cartesian_path(
        CartesianRequest('arm', (goal,), 0.01, 'segment6'), scene)
    assert response.fraction == pytest.approx(1.0)
    end = six.link_pose(states(response, six)[-1], 'segment6')
    assert end[:3, 3] == pytest.approx(goal[:3, 3], abs=1e-5)


def test_a_path_that_leaves_the_reach(scene, tool, plan_for):
    """SRV-33: a path that cannot be finished is a success with its feasible part."""
    goals = (moved(tool, (0.0, 0.1, 0.0)), moved(tool, (2.0, 0.1, 0.0)))
    response = plan_for(scene).cartesian_path(CartesianRequest('arm', goals, 0.01), scene)
    assert response.error_code == 1
    assert 0.5 < response.fraction < 0.8
    assert 'waypoint 2' in response.message
    assert response.trajectory.positions[0] == pytest.approx(BENT)


def test_collision_ends_the_path(scene, tool, add_box, plan_for):
    """SRV-33, SRV-36: an obstacle ends the path where collisions are avoided, and only there."""
    centre = tool[:3, 3] + (0.0, 0.17, 0.0)
    add_box(scene, 'block', (0.3, 0.02, 0.3), centre)
    goal = moved(tool, (0.0, 0.2, 0.0))
    planner = plan_for(scene)
    response = planner.cartesian_path(CartesianRequest('arm', (goal,), 0.01), scene)
    assert response.error_code == 1
    assert 0.1 < response.fraction < 0.9
    assert 'block' in response.message
    through = planner.cartesian_path(
        CartesianRequest('arm', (goal,), 0.01, avoid_collisions=False), scene)
    assert through.fraction == pytest.approx(1.0)


def test_path_constraints_end_the_path(scene, tool, plan_for):
    """SRV-36: path constraints are kept whether collisions are avoided or not."""
    keep = Constraints((JointConstraint('axis1', 0.3, 0.1, 0.1),))
    response = plan_for(scene).cartesian_path(
        CartesianRequest('arm', (moved(tool, (0.0, 0.3, 0.0)),), 0.01, path_constraints=keep,
                         avoid_collisions=False), scene)
    assert response.error_code == 1
    assert 0.0 < response.fraction < 1.0
    assert "'axis1'" in response.message


def test_start_in_contact_is_left(scene, tool, add_box, plan_for):
    """
    The start state is not checked: a path that leaves a contact succeeds.

    moveit_ros, cartesian_path_service_capability.cpp, computeService: collisions are checked in
    the solutions of inverse kinematics.
    """
    end = (scene.frame_pose('segment6') @ (0.0, 0.0, 0.06, 1.0))[:3]
    add_box(scene, 'table', (0.3, 0.3, 0.02), end - (0.0, 0.0, 0.01))
    planner = plan_for(scene)
    assert not planner.check_state(scene, scene.q, 'arm').valid
    up = planner.cartesian_path(
        CartesianRequest('arm', (moved(tool, (0.0, 0.0, 0.1)),), 0.025), scene)
    assert (up.error_code, up.fraction) == (1, 1.0), up.message
    down = planner.cartesian_path(
        CartesianRequest('arm', (moved(tool, (0.0, 0.0, -0.05)),), 0.01), scene)
    assert (down.error_code, down.fraction) == (1, 0.0)
    assert "'table'" in down.message


def test_start_outside_constraints_and_limits(scene, tool, plan_for):
    """
    A start that violates the path constraints or a limit is not an error.

    moveit_ros, cartesian_path_service_capability.cpp, computeService.
    """
    keep = Constraints((JointConstraint('axis1', 0.5, 0.15, 0.15),))
    response = plan_for(scene).cartesian_path(CartesianRequest(
        'arm', (moved(tool, (-0.05, 0.1, 0.0)),), 0.2, path_constraints=keep), scene)
    assert (response.error_code, response.fraction) == (1, 1.0), response.message
    beyond = StartState(('axis6',), (3.0,))
    response = plan_for(scene).cartesian_path(
        CartesianRequest('arm', (moved(tool, (0.0, 0.1, 0.0)),), 0.01, start_state=beyond), scene)
    assert response.error_code == 1
    assert response.start['axis6'] == 3.0


def test_fraction_counts_whole_steps(scene, tool, add_box, plan_for):
    """
    The fraction is that of the steps of ``max_step`` that were finished.

    moveit_core, cartesian_interpolator.cpp, computeCartesianPath.
    """
    add_box(scene, 'block', (0.3, 0.02, 0.3), tool[:3, 3] + (0.0, 0.17, 0.0))
    goal = moved(tool, (0.0, 0.2, 0.0))
    response = plan_for(scene).cartesian_path(CartesianRequest('arm', (goal,), 0.03), scene)
    assert 0.0 < response.fraction < 1.0
    assert response.fraction * 7 == pytest.approx(round(response.fraction * 7))


def test_link_that_the_solver_does_not_position(scene, tool, plan_for):
    """
    A link that is not fixed to the solver's tip has no path: a success with fraction 0.

    moveit_core, cartesian_interpolator.cpp, computeCartesianPath.
    """
    response = plan_for(scene).cartesian_path(
        CartesianRequest('arm', (tool,), 0.01, 'segment3'), scene)
    assert (response.error_code, response.fraction) == (1, 0.0)
    assert "'segment3' is not rigidly fixed to 'tool'" in response.message


def test_waypoints_in_the_frame_of_a_link(scene, tool, six, plan_for):
    """
    A link as frame means where it is now, not where the start state of the request has it.

    moveit_ros, move_group_capability.cpp, performTransform.
    """
    start = StartState(('axis1',), (0.5,))
    goal = moved(six.link_pose(six.vector({'axis1': 0.5}, scene.q), 'tool'), (0.0, 0.05, 0.0))
    local = np.linalg.inv(scene.frame_pose('segment2')) @ goal
    response = plan_for(scene).cartesian_path(
        CartesianRequest('arm', (local,), 0.01, frame_id='segment2', start_state=start), scene)
    assert response.fraction == 1.0
    assert six.link_pose(states(response, six)[-1], 'tool') == pytest.approx(goal, abs=1e-5)


def test_group_without_solver_has_no_path(pair, pair_scene, plan_for):
    """
    A group of two chains has no solver: fraction 0; the group of the one arm has a path.

    moveit_core, robot_state.cpp, setFromIK.
    """
    goal = moved(pair_scene.frame_pose('left_tool'), (0.0, 0.0, 0.1))
    planner = plan_for(pair_scene)
    for group, fraction in (('both', 0.0), ('left', 1.0)):
        response = planner.cartesian_path(
            CartesianRequest(group, (goal,), 0.01, 'left_tool'), pair_scene)
        assert (response.error_code, response.fraction) == (1, fraction)


def test_timing(scene, tool, plan_for):
    """SRV-35: timed with the scaling factors, from rest to rest, first point the start."""
    goal = moved(tool, (0.0, 0.15, -0.1))
    planner = plan_for(scene)
    fast = planner.cartesian_path(CartesianRequest('arm', (goal,), 0.01), scene).trajectory
    slow = planner.cartesian_path(
        CartesianRequest('arm', (goal,), 0.01, max_velocity_scaling_factor=0.1), scene).trajectory
    assert slow.duration > 2.0 * fast.duration
    assert fast.positions[0] == pytest.approx(BENT)
    assert not np.any(fast.velocities[-1])
    velocities = np.abs(slow.velocities)
    assert velocities.max() <= 0.3 * 1.001


def test_speed_of_the_link(scene, tool, six, plan_for):
    """SRV-35: max_cartesian_speed is honoured."""
    response = plan_for(scene).cartesian_path(
        CartesianRequest('arm', (moved(tool, (0.0, 0.2, 0.0)),), 0.01, max_cartesian_speed=0.05),
        scene)
    places = np.array([six.link_pose(q, 'tool')[:3, 3] for q in states(response, six)])
    speed = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(response.trajectory.times)
    assert 0.048 < speed.max() <= 0.0505


def test_start_state_is_used_and_returned(scene, tool, plan_for):
    """SRV-35: the response names the start that was used."""
    start = (0.5, *BENT[1:])
    response = plan_for(scene).cartesian_path(
        CartesianRequest('arm', (tool,), 0.01, start_state=StartState(('axis1',), (0.5,))), scene)
    assert response.start == pytest.approx(dict(zip(SIX, start, strict=True)))
    assert response.trajectory.positions[0] == pytest.approx(start)


def test_no_waypoints(scene, plan_for):
    """SRV-31: nothing to do is a success with fraction 0 and no points."""
    response = plan_for(scene).cartesian_path(CartesianRequest('arm', (), 0.01), scene)
    assert (response.error_code, response.fraction, len(response.trajectory)) == (1, 0.0, 0)
    assert not response.start


@pytest.mark.parametrize(('changes', 'code'), [
    ({'group_name': 'amr'}, -15),
    ({'max_step': 0.0}, 99999),
    ({'max_step': math.nan}, 99999),
    ({'link_name': 'toll'}, -18),
    ({'frame_id': 'nowhere'}, -21),
    ({'start_state': StartState(('axis9',), (0.0,))}, -17),
    ({'waypoints': (np.full((4, 4), math.nan),)}, 99999),
])
def test_wrong_requests(scene, tool, plan_for, changes, code):
    """E23: each mistake has its code and a sentence."""
    given = {'group_name': 'arm', 'waypoints': (tool,), 'max_step': 0.01, **changes}
    response = plan_for(scene).cartesian_path(CartesianRequest(**given), scene)
    assert response.error_code == code
    assert response.message
    assert response.source
    assert not len(response.trajectory)
