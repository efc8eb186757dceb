# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of inverse kinematics requests and of state validity."""

import math

import numpy as np
import pytest

from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.context import PlanningSettings
from armsim_ros.planning.queries import IKRequest, LinkPose
from armsim_ros.planning.request import Constraints, JointConstraint
from armsim_ros.planning.scene.update import StartState

SIX = tuple(f'axis{k}' for k in range(1, 7))
BENT = (0.3, 0.7, 1.2, 0.2, 0.9, 0.1)
FOLDED = (0.0, 0.0, 2.9, 0.0, 1.6, 0.0)


@pytest.fixture
def wanted(six):
    """Return a pose of the tool that can be reached."""
    return six.link_pose(six.vector(dict(zip(SIX, BENT, strict=True))), 'tool')


def test_pose_is_reached(six, six_scene, plan_for, clock, wanted):
    """SRV-6: forward kinematics of the answer gives the pose; all joints are in it."""
    response = plan_for(six_scene).compute_ik(
        IKRequest('arm', (LinkPose('', wanted),)), six_scene, clock=clock)
    assert response.error_code == 1
    assert set(response.positions) == set(SIX)
    assert six.link_pose(six.vector(response.positions), 'tool') == pytest.approx(
        wanted, abs=1e-4)


def test_a_limit_begins_once_the_table_of_starts_is_made(
    six_scene, plan_for, wanted, monkeypatch
):
    """The first pose of a process has all of its time for the search."""
    tables = {}
    monkeypatch.setattr(six_scene.kinematic_model, '_cache', tables)
    known = []

    def clock():
        known.append(any(key[0] == 'start table' for key in tables))
        return 0.0

    plan_for(six_scene).compute_ik(
        IKRequest('arm', (LinkPose('', wanted),)), six_scene, clock=clock)
    assert known[0]


def test_seed_state_is_tried_first(six_scene, plan_for, clock, wanted):
    """SRV-2: a seed that already fits comes back."""
    response = plan_for(six_scene).compute_ik(
        IKRequest('arm', (LinkPose('tool', wanted),), StartState(SIX, BENT)), six_scene,
        clock=clock)
    assert list(response.positions.values()) == pytest.approx(BENT, abs=1e-5)


def test_pose_in_the_frame_of_a_link(six, six_scene, plan_for, clock, wanted):
    """
    A link as frame means where it is now, not where the start state of the request has it.

    moveit_ros, move_group_capability.cpp, performTransform.
    """
    local = np.linalg.inv(six_scene.frame_pose('segment2')) @ wanted
    response = plan_for(six_scene).compute_ik(
        IKRequest('arm', (LinkPose('tool', local, 'segment2'),), StartState(SIX, BENT)), six_scene,
        clock=clock)
    assert six.link_pose(six.vector(response.positions), 'tool') == pytest.approx(
        wanted, abs=1e-4)


def test_scene_objects_are_not_frames_of_poses(six_scene, add_box, plan_for, clock):
    """
    A pose in the frame of a scene object is -21, because TF does not have that frame.

    moveit_ros, move_group_capability.cpp, performTransform.
    """
    add_box(six_scene, 'table', (0.1, 0.1, 0.1), (0.9, 0.5, 0.0))
    response = plan_for(six_scene).compute_ik(
        IKRequest('arm', (LinkPose('tool', np.eye(4), 'table'),)), six_scene, clock=clock)
    assert response.error_code == -21
    assert "'table' is an object of the planning scene" in response.message


@pytest.mark.parametrize('link', ['segment3', 'base', 'toll'])
def test_link_has_to_be_fixed_to_the_tip(six, six_scene, plan_for, clock, link):
    """
    A link that is not rigidly fixed to the solver's tip is -31.

    moveit_core, robot_state.cpp, setFromIK.
    """
    response = plan_for(six_scene).compute_ik(
        IKRequest('arm', (LinkPose(link, pose_matrix((0.0, 0.0, 0.25))),)), six_scene, clock=clock)
    assert response.error_code == -31
    assert link in response.message


def test_group_without_solver_takes_one_pose_for_each_subgroup(pair, pair_scene, plan_for, clock):
    """
    A group of chains takes as many poses as it has subgroups, in their order; otherwise -31.

    moveit_core, robot_state.cpp, setFromIK and setFromIKSubgroups.
    """
    planner = plan_for(pair_scene)
    start = pair_scene.q.copy()
    q = pair.insert(start, 'both', pair.extract(start, 'both') + 0.2)
    hands = [LinkPose(f'{side}_tool', pair.link_pose(q, f'{side}_tool'))
             for side in ('left', 'right')]

    def asked(*targets):
        return planner.compute_ik(IKRequest('both', targets), pair_scene, clock=clock)

    answer = asked(*hands)
    assert answer.error_code == 1
    found = pair.vector(answer.positions)
    for hand in hands:
        assert pair.link_pose(found, hand.link_name) == pytest.approx(hand.pose, abs=1e-4)
    for wrong in ((hands[0],), tuple(reversed(hands)), (*hands, hands[0])):
        assert asked(*wrong).error_code == -31


def test_two_poses_for_one_chain(six_scene, plan_for, clock, wanted):
    """
    A chain's solver takes one pose; two are -31.

    moveit_core, robot_state.cpp, setFromIK.
    """
    target = LinkPose('tool', wanted)
    response = plan_for(six_scene).compute_ik(
        IKRequest('arm', (target, target)), six_scene, clock=clock)
    assert response.error_code == -31


def test_group_without_configured_solver(six_scene, plan_for, clock, wanted):
    """
    Where kinematics.yaml names solvers, a group that it does not name is -31.

    moveit_core, robot_state.cpp, setFromIK.
    """
    settings = PlanningSettings(solver_groups=frozenset({'hand'}))
    response = plan_for(six_scene, settings).compute_ik(
        IKRequest('arm', (LinkPose('tool', wanted),)), six_scene, clock=clock)
    assert response.error_code == -31
    assert 'kinematics_solver' in response.message


def test_collisions_are_avoided(six, six_scene, add_box, plan_for, clock, wanted):
    """SRV-5: with avoid_collisions another solution is found than the one in the way."""
    planner = plan_for(six_scene)
    at_elbow = six.link_pose(six.vector(dict(zip(SIX, BENT, strict=True))), 'segment3')[:3, 3]
    add_box(six_scene, 'knot', (0.06, 0.06, 0.06), at_elbow)
    seed = StartState(SIX, BENT)
    free = planner.compute_ik(
        IKRequest('arm', (LinkPose('tool', wanted),), seed, avoid_collisions=True,
                  timeout=0.5), six_scene, clock=clock)
    assert free.error_code == 1, free.message
    q = six.vector(free.positions)
    assert planner.check_state(six_scene, q, 'arm').valid
    assert not planner.check_state(
        six_scene, six.vector(dict(zip(SIX, BENT, strict=True))), 'arm').valid


def test_constraints_are_kept(six, six_scene, plan_for, clock):
    """SRV-5: constraints select among the solutions, here the one with the wrist turned over."""
    start = dict(zip(SIX, (0.3, 0.7, 1.2, 1.0, 0.9, 1.0), strict=True))
    wanted = six.link_pose(six.vector(start), 'tool')
    keep = Constraints((JointConstraint('axis4', -2.9, 2.0, 0.0),))
    response = plan_for(six_scene).compute_ik(
        IKRequest('arm', (LinkPose('tool', wanted),), StartState.from_positions(start), keep,
                  timeout=0.5), six_scene, clock=clock)
    assert response.error_code == 1, response.message
    assert response.positions['axis4'] < -0.9


@pytest.mark.parametrize(('group', 'target', 'code'), [
    ('amr', LinkPose('tool', np.eye(4)), -15),
    ('arm', LinkPose('tool', np.eye(4), 'nowhere'), -21),
    ('arm', LinkPose('tool', pose_matrix((3.0, 0.0, 0.0))), -31),
    ('arm', LinkPose('tool', np.full((4, 4), math.nan)), -31),
])
def test_wrong_requests(six_scene, plan_for, clock, group, target, code):
    """E21: each mistake has its code and a sentence."""
    response = plan_for(six_scene).compute_ik(
        IKRequest(group, (target,)), six_scene, clock=clock)
    assert response.error_code == code
    assert response.message
    assert not response.positions


def test_free_state(six, six_scene, plan_for):
    """SRV-22: a free state is valid and has no contacts."""
    report = plan_for(six_scene).check_state(six_scene, six.default())
    assert report.valid
    assert report.contacts == ()


def test_a_planner_follows_a_scene_that_collides_as_the_last(six, six_scene, add_box, plan_for):
    """Another state of the robot changes nothing, an object does until a state was checked."""
    planner = plan_for(six_scene)
    six_scene.set_state(six.vector(dict(zip(SIX, BENT, strict=True))))
    assert planner.follows(six_scene.snapshot())
    add_box(six_scene, 'knot', (0.06, 0.06, 0.06), (3.0, 0.0, 0.0))
    assert not planner.follows(six_scene.snapshot())
    planner.check_state(six_scene, six_scene.q)
    assert planner.follows(six_scene.snapshot())


def test_self_collision(six, six_scene, plan_for):
    """SRV-21, SRV-22: a colliding state is not valid and names its pairs."""
    q = six.vector(dict(zip(SIX, FOLDED, strict=True)))
    report = plan_for(six_scene).check_state(six_scene, q, 'arm')
    assert not report.valid
    assert report.contacts
    assert 'segment' in report.message


def test_constraint_results(six, six_scene, plan_for):
    """SRV-21: one result a constraint; a broken one makes the state not valid."""
    constraints = Constraints((JointConstraint('axis1', 0.0, 0.1, 0.1),
                               JointConstraint('axis2', 1.0, 0.1, 0.1)))
    report = plan_for(six_scene).check_state(six_scene, six.default(), 'arm', constraints)
    assert [each.satisfied for each in report.constraint_results] == [True, False]
    assert not report.valid


@pytest.mark.parametrize(('state', 'valid'), [((0.0,) * 6, True), (FOLDED, False)])
def test_unknown_group(six, six_scene, plan_for, log, state, valid):
    """
    All links are checked for an unknown group, and a warning names the known ones.

    moveit_core, collision_common.cpp, CollisionData::enableGroup.
    """
    q = six.vector(dict(zip(SIX, state, strict=True)))
    assert plan_for(six_scene).check_state(six_scene, q, 'amr').valid is valid
    assert 'known: arm' in log.recorder.text()
