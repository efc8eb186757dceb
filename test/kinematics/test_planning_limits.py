# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which limits bound plans: the URDF's, its soft limits and joint_limits.yaml."""

from dataclasses import replace
import math

import numpy as np
import pytest

from armsim_ros.config.kinematics import JointLimitOverrides, JointLimitsSettings
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.robot_model import (
    Joint,
    JointLimits,
    JointType,
    Link,
    RobotModel,
    SoftLimits,
)


@pytest.fixture
def planned():
    """Return a function: words of joint_limits.yaml -> the limits of a joint in plans."""
    def limits(kind=JointType.REVOLUTE, soft=None, **words):
        joint = Joint('j', kind, 'a', 'b', np.eye(4), np.array([0.0, 0.0, 1.0]),
                      JointLimits(-2.0, 2.0, 3.0, effort=10.0), soft_limits=soft)
        if kind is JointType.CONTINUOUS:
            joint = replace(joint, limits=JointLimits(velocity=3.0, effort=10.0))
        robot = RobotModel('r', {'a': Link('a'), 'b': Link('b')}, {'j': joint}, 'a')
        settings = JointLimitsSettings(joint_limits={'j': JointLimitOverrides(**words)})
        return planning_robot(robot, settings).joints['j'].limits
    return limits


@pytest.mark.parametrize('declared', [None, True, False])
def test_position_bounds_count_wherever_they_are_given(planned, declared):
    """
    Each replaces the URDF's by itself, upwards too; has_position_limits is not read.

    moveit_ros/planning/robot_model_loader/src/robot_model_loader.cpp: configure.
    """
    words = {} if declared is None else {'has_position_limits': declared}
    both = planned(min_position=-1.0, max_position=5.0, **words)
    assert (both.lower, both.upper) == (-1.0, 5.0)
    upper = planned(max_position=0.5, **words)
    assert (upper.lower, upper.upper) == (-2.0, 0.5)
    assert planned(**words).lower == -2.0


def test_a_continuous_joint_gets_no_position_bounds(planned):
    """
    Bounds in joint_limits.yaml and soft limits have no effect on it.

    moveit_ros/planning/robot_model_loader/src/robot_model_loader.cpp: canSpecifyPosition;
    moveit_core/robot_model/src/revolute_joint_model.cpp: setContinuous.
    """
    found = planned(JointType.CONTINUOUS, SoftLimits(-1.0, 1.0, 1.0, 1.0),
                    min_position=-1.0, max_position=1.0)
    assert (found.lower, found.upper) == (-math.inf, math.inf)


def test_velocity_acceleration_and_jerk_count_only_where_they_are_declared(planned):
    """
    A value counts with its has_...: true; false takes the URDF's velocity bound away.

    moveit_ros/planning/robot_model_loader/src/robot_model_loader.cpp: configure;
    moveit_core/robot_model/src/joint_model.cpp: setVariableBounds.
    """
    values = {'max_velocity': 5.0, 'max_acceleration': 6.0, 'max_jerk': 7.0}
    for declared, expected in ((True, (5.0, 6.0, 7.0)), (False, (math.inf,) * 3),
                               (None, (3.0, math.inf, math.inf))):
        words = {} if declared is None else {
            f'has_{kind}_limits': declared for kind in ('velocity', 'acceleration', 'jerk')}
        found = planned(**values, **words)
        assert (found.velocity, found.acceleration, found.jerk) == expected
        assert found.effort == 10.0


def test_a_bound_that_is_declared_and_not_given_stays_the_urdfs(planned):
    """
    has_velocity_limits without max_velocity keeps the velocity of the URDF.

    moveit_ros/planning/robot_model_loader/src/robot_model_loader.cpp: configure.
    """
    found = planned(has_velocity_limits=True, has_acceleration_limits=True)
    assert (found.velocity, found.acceleration) == (3.0, math.inf)


@pytest.mark.parametrize(('soft', 'expected'), [
    ((-1.0, 1.5), (-1.0, 1.5)), ((-9.0, 9.0), (-2.0, 2.0)), ((0.0, 0.0), (0.0, 0.0))])
def test_soft_limits_narrow_those_of_the_urdf(planned, soft, expected):
    """
    Position bounds are the intersection of <limit> and <safety_controller>.

    moveit_core/robot_model/src/robot_model.cpp: jointBoundsFromURDF.
    """
    limits = SoftLimits(*soft, k_position=1.0, k_velocity=1.0)
    found = planned(soft=limits)
    assert (found.lower, found.upper) == expected
    over = planned(soft=limits, max_position=7.0)
    assert (over.lower, over.upper) == (expected[0], 7.0)
