# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters that change while a controller is loaded."""

import pytest

from armsim_ros.config.controllers.broadcasters import (
    ForceTorqueSensorBroadcasterParameters,
    PoseBroadcasterParameters,
)
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.control.parameter_changes import changed, in_effect
from armsim_ros.errors import ControllerError


@pytest.fixture
def parameters():
    """Return parameters of joints, one with a dot in its name."""
    return JointTrajectoryControllerParameters(joints=('a', 'arm.b'))


def test_dynamic_parameters(parameters):
    """B6 to B17, B23: named by dots, the others stay as they were."""
    new = changed(
        parameters,
        {'constraints.a.goal': 0.5, 'constraints.arm.b.trajectory': 0.2, 'gains.arm.b.p': 3,
         'constraints.goal_time': 2, 'allow_partial_joints_goal': True},
    )
    assert new.constraints.joints['a'].goal == 0.5
    assert new.constraints.joints['arm.b'].trajectory == 0.2
    assert new.gains['arm.b'].p == 3.0
    assert new.constraints.goal_time == 2.0
    assert new.allow_partial_joints_goal
    assert parameters.constraints.goal_time == 0.0


def test_all_anew(parameters):
    """A whole block of parameters replaces the old one."""
    new = changed(parameters, parameters.model_copy(update={'cmd_timeout': 2.0}))
    assert new.cmd_timeout == 2.0


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        ({'joints': ['arm.b', 'a']}, ['read-only', "'joints'"]),
        ({'action_monitor_rate': 5.0}, ['read-only']),
        ({'is_async': True}, ['read-only', "'is_async'"]),
        ({'constraints.decelerate_on_cancel': True}, ["'constraints.decelerate_on_cancel'"]),
        ({'constraints.a.max_deceleration_on_cancel': 1.0}, ['constraints.a.max_dec']),
        ({'gains.a.antiwindup_strategy': 'none'}, ['gains.a.antiwindup_strategy']),
        ({'constraints.goal_time': -1.0}, ['constraints.goal_time', 'greater than or equal']),
        ({'constraints.goal_tim': 1.0}, ["'constraints.goal_tim'", "did you mean 'goal_time'"]),
        ({'cmd_timeout': 'soon'}, ['cmd_timeout', 'number']),
    ],
)
def test_refused_changes(parameters, changes, words):
    """B22: read-only, unknown or out of range: the message names the parameter."""
    with pytest.raises(ControllerError) as caught:
        changed(parameters, changes)
    for word in words:
        assert word in str(caught.value)


def test_what_only_configure_takes_over_is_not_in_effect():
    """Of a change the offset counts, the names of interfaces and frames wait."""
    current = ForceTorqueSensorBroadcasterParameters(sensor_name='wrist', frame_id='tool')
    requested = changed(current, {
        'sensor_name': '', 'interface_names.force.z': 'a/effort', 'frame_id': 'flange',
        'offset.force.z': 2.0})
    now = in_effect(current, requested)
    assert (now.sensor_name, now.interface_names.force.z, now.frame_id) == ('wrist', '', 'tool')
    assert now.offset.force.z == 2.0


def test_a_block_that_only_configure_takes_over_waits_as_a_whole():
    """Each of its parameters can be set."""
    current = PoseBroadcasterParameters(pose_name='tool', frame_id='world')
    requested = changed(current, {'tf.enable': False, 'tf.child_frame_id': 'tip'})
    assert not requested.tf.enable
    assert in_effect(current, requested) == current


def test_without_such_a_change_all_is_in_effect():
    """The very object that was requested is used."""
    current = PoseBroadcasterParameters(pose_name='tool', frame_id='world')
    requested = changed(current, {'frame_id': 'world'})
    assert in_effect(current, requested) is requested
