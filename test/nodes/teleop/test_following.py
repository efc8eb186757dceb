# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How an arm begins to follow a leader, and how fast it may."""

import pytest

from armsim_ros.model.robot_model import JointLimits
from armsim_ros.nodes.teleop.leader import Following, NEAR, SLOW

LIMITS = {'turn': JointLimits(-1.0, 1.0, 4.0), 'bend': JointLimits(-2.0, 2.0, 2.0)}
HOME = {'turn': 0.0, 'bend': 0.0}


def test_a_leader_far_away_is_not_followed():
    """The state names the joint that is farthest away; the arm stays until it is near."""
    following = Following(LIMITS, 0.5, approach=False)
    assert following.step({'turn': 0.09, 'bend': -0.5}, HOME, 0.02) is None
    assert not following.engaged
    assert "'bend'" in following.state
    assert '--approach' in following.state
    assert following.step({'turn': 0.0, 'bend': -0.99 * NEAR}, HOME, 0.02) is not None
    assert following.engaged


def test_a_leader_that_is_followed_may_go_farther():
    """Each joint as fast as it may at most, others not slowed down by it."""
    following = Following(LIMITS, 0.5, approach=False)
    assert following.step({'turn': 0.01, 'bend': 0.01}, HOME, 0.02) == {'turn': 0.01, 'bend': 0.01}
    assert following.step({'turn': 0.9, 'bend': -0.9}, HOME, 0.02) == pytest.approx(
        {'turn': 0.04, 'bend': -0.02})
    assert following.step({'turn': 0.9, 'bend': 0.01}, HOME, 0.02) == pytest.approx(
        {'turn': 0.04, 'bend': 0.01})


def test_the_approach_is_slow_and_straight_and_ends_in_following():
    """The joint with the longest way at the slow speed, all others in proportion."""
    following = Following(LIMITS, 0.5, approach=True)
    leader, at = {'turn': 0.4, 'bend': -0.8}, dict(HOME)
    steps = 0
    while not following.engaged:
        goals = following.step(leader, at, 0.02)
        if not following.engaged:
            assert abs(goals['bend'] - at['bend']) <= SLOW * 0.02 + 1e-12
            assert goals['turn'] == pytest.approx(-0.5 * goals['bend'])
            assert following.state.endswith('approaches')
        at = goals
        steps += 1
    assert steps * 0.02 == pytest.approx((0.8 - NEAR) / SLOW, abs=0.05)


def test_a_slow_joint_slows_the_approach():
    """No joint exceeds its own speed."""
    following = Following({'turn': JointLimits(-1.0, 1.0, 0.02)}, 0.5, approach=True)
    assert following.step({'turn': 0.5}, {'turn': 0.0}, 0.1)['turn'] == pytest.approx(0.001)


def test_a_silent_leader_is_no_longer_followed():
    """The arm holds, and follows again only from near."""
    following = Following(LIMITS, 0.5, approach=False)
    following.step(HOME, HOME, 0.02)
    assert following.engaged
    assert following.step(None, HOME, 0.02) is None
    assert not following.engaged
    assert 'silent' in following.state
    assert following.step({'turn': 0.5, 'bend': 0.0}, HOME, 0.02) is None
    assert not following.engaged


def test_a_leader_beyond_the_limits_is_followed_to_them():
    """It engages there, too."""
    following = Following(LIMITS, 0.5, approach=False)
    at = {'turn': 0.95, 'bend': 0.0}
    assert following.step({'turn': 3.0, 'bend': 0.0}, at, 1.0)['turn'] == 1.0
    assert following.engaged
