# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The common factor of joint velocities."""

import numpy as np
import pytest

from armsim_ros.servo.speed_limits import JointBounds

LIMIT = np.array([2.0, 2.0, 2.5, 2.5, 1.0])


@pytest.mark.parametrize(('override', 'factor'), [
    (0.0, 1.0 / 1.1), (0.009, 1.0 / 1.1), (0.5, 0.5), (1.0, 1.0 / 1.1)])
def test_limits_and_the_override(override, factor):
    """
    The smaller one of the override and what the joint limits allow is the factor of all joints.

    Upstream: test_utils.cpp, JointLimitVelocityScaling.
    """
    bounds = JointBounds(tuple('abcde'), -LIMIT, LIMIT, LIMIT, LIMIT)
    velocity = LIMIT * [1.1, 1.05, 0.7, -0.7, 0.7]
    assert bounds.speed_factor(velocity, override) == pytest.approx(factor)
