# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of inverse kinematics requests and of state validity."""

import math

import numpy as np
import pytest

from armsim_ros.model.transforms import pose_matrix
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


def test_seed_state_is_tried_first(six_scene, plan_for, clock, wanted):
    """SRV-2: a seed that already fits comes back."""
    response = plan_for(six_scene).compute_ik(
        IKRequest('arm', (LinkPose('tool', wanted),), StartState(SIX, BENT)), six_scene,
        clock=clock)
    assert list(response.positions.values()) == pytest.approx(BENT, abs=1e-5)


def test_pose_in_another_frame(six, six_scene, add_box, plan_for, clock, wanted):
    """SRV-4: the pose may be given in the frame of an object."""
    add_box(six_scene, 'table', (0.1, 0.1, 0.1), (0.9, 0.5, 0.0), (0.0, 0.0, 0.7))
    local = np.linalg.inv(six_scene.frame_pose('table')) @ wanted
    response = plan_for(six_scene).compute_ik(
        IKRequest('arm', (LinkPose('tool', local, 'table'),)), six_scene, clock=clock)
    assert six.link_pose(six.vector(response.positions), 'tool') == pytest.approx(
        wanted, abs=1e-4)


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
    ('arm', LinkPose('toll', np.eye(4)), -18),
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


def test_unknown_group(six, six_scene, plan_for):
    """SRV-20: a state of an unknown group is not valid, and the message names the known ones."""
    report = plan_for(six_scene).check_state(six_scene, six.default(), 'amr')
    assert not report.valid
    assert 'known: arm' in report.message
