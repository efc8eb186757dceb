# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the controllers and of their manager: defaults, ranges, read-only flags."""

import math

from pydantic import ValidationError
import pytest

from armsim_ros.config.base import ControllerParameters
from armsim_ros.config.controllers.broadcasters import JointStateBroadcasterParameters
from armsim_ros.config.controllers.compliance import StiffnessSettings
from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.config.controllers.gripper_action_controller import (
    GripperActionControllerParameters,
    ParallelGripperActionControllerParameters,
)
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
)
from armsim_ros.config.controllers.pid_controller import PidGains

READ_ONLY = {
    'joints', 'command_joints', 'command_interfaces', 'state_interfaces', 'open_loop_control',
    'interpolate_from_desired_state', 'action_monitor_rate', 'interpolation_method',
}
DYNAMIC = {
    'allow_partial_joints_goal', 'allow_integration_in_goal_trajectories', 'cmd_timeout',
    'allow_nonzero_velocity_at_trajectory_end', 'constraints', 'gains',
    'set_last_command_interface_value_as_state_on_activation',
}


def problems(model, **values):
    """Return the text of the validation error."""
    with pytest.raises(ValidationError) as caught:
        model(**values)
    return str(caught.value)


def read_only(model, name):
    """Return the flag of a field."""
    return model.model_fields[name].json_schema_extra['read_only']


def test_trajectory_defaults():
    """B6 to B17: the defaults of Jazzy; E7: but starts from the desired state."""
    p = JointTrajectoryControllerParameters(joints=['a'])
    assert (p.action_monitor_rate, p.cmd_timeout, p.interpolation_method) == (20.0, 0.0, 'splines')
    assert not p.allow_nonzero_velocity_at_trajectory_end
    assert p.set_last_command_interface_value_as_state_on_activation
    assert p.speed_scaling.initial_scaling_factor == 1.0
    assert (p.constraints.goal_time, p.constraints.stopped_velocity_tolerance) == (0.0, 0.01)
    assert p.interpolate_from_desired_state
    assert p.compat == 'jazzy'


def test_read_only_flags():
    """B1 to B17: which parameters cannot change after loading."""
    model = JointTrajectoryControllerParameters
    assert all(read_only(model, name) for name in READ_ONLY)
    assert not any(read_only(model, name) for name in DYNAMIC)


@pytest.mark.parametrize(
    'model',
    [
        JointTrajectoryControllerParameters, JointStateBroadcasterParameters, PidGains,
        GripperActionControllerParameters, ParallelGripperActionControllerParameters,
        ControllerManagerParameters,
    ],
)
def test_every_parameter_is_described(model):
    """Every parameter says what it means."""
    assert all(field.description for field in model.model_fields.values())


def test_every_joint_has_its_blocks():
    """B16, B17: constraints and gains of joints that the file does not name are there too."""
    p = JointTrajectoryControllerParameters(
        joints=['a', 'b'], constraints={'a': {'goal': 0.1}}, gains={'b': {'p': 1}}
    )
    assert p.constraints.joints['a'].goal == 0.1
    assert p.constraints.joints['b'].goal == 0.0
    assert (p.gains['a'].p, p.gains['b'].p) == (0.0, 1.0)
    assert set(p.model_dump()['constraints']) >= {'a', 'b', 'goal_time'}


def test_dump_gives_the_same_parameters():
    """Read again, what was dumped is equal."""
    p = JointTrajectoryControllerParameters(
        joints=['a'], constraints={'a': {'goal': 0.1}}, gains={'a': {'i': 1, 'i_clamp': 0}}
    )
    again = JointTrajectoryControllerParameters.model_validate(p.model_dump())
    assert again == p
    assert again.gains['a'].integral_bounds == (0.0, 0.0)


def test_velocity_feed_forward_of_ros1():
    """Q4: velocity_ff of a joint is its gains' ff_velocity_scale."""
    p = JointTrajectoryControllerParameters(joints=['a', 'b'], velocity_ff={'a': 0.5})
    assert (p.gains['a'].ff_velocity_scale, p.gains['b'].ff_velocity_scale) == (0.5, 0.0)


@pytest.mark.parametrize(
    ('values', 'words'),
    [
        ({}, ['joints']),
        ({'joints': []}, ['joints']),
        ({'joints': ['a', 'a']}, ['named twice: a']),
        ({'joints': ['a'], 'command_joints': ['a', 'b']}, ['command_joints is longer']),
        ({'joints': ['a'], 'command_interfaces': []}, ['command_interfaces']),
        ({'joints': ['a'], 'command_interfaces': ['torque']}, ['command_interfaces']),
        ({'joints': ['a'], 'command_interfaces': ['velocity', 'effort']}, ['do not go together']),
        ({'joints': ['a'], 'command_interfaces': ['acceleration']}, ['allowed: position;']),
        ({'joints': ['a'], 'state_interfaces': ['velocity']}, ['needs position']),
        (
            {'joints': ['a'], 'state_interfaces': ['position', 'acceleration']},
            ['acceleration needs velocity'],
        ),
        ({'joints': ['a'], 'constraints': {'b': {'goal': 1}}}, ["constraints: 'b'"]),
        ({'joints': ['a'], 'gains': {'b': {}}}, ["gains: 'b'"]),
        ({'joints': ['a'], 'constraints': {'goal_tim': 1}}, ["did you mean 'goal_time'"]),
        ({'joints': ['a'], 'constraints': {'a': {'gaol': 1}}}, ['constraints.a.gaol']),
        ({'joints': ['a'], 'constraints': {'goal_time': -1}}, ['constraints.goal_time']),
        ({'joints': ['a'], 'action_monitor_rate': 0.01}, ['action_monitor_rate']),
        ({'joints': ['a'], 'interpolation_method': 'cubic'}, ['interpolation_method']),
        ({'joints': ['a'], 'speed_scaling': {'initial_scaling_factor': -1}}, ['speed_scaling']),
        ({'joints': ['a'], 'gains': {'a': {'antiwindup_strategy': 'x'}}}, ['antiwindup']),
        ({'joints': ['a'], 'gains': {'a': {'u_clamp_max': -1, 'u_clamp_min': 1}}}, ['above']),
        ({'joints': ['a'], 'verbos': True}, ['verbos']),
    ],
)
def test_bad_trajectory_parameters(values, words):
    """B1 to B5, B22: out of range, illegal together or unknown: the message names it."""
    text = problems(JointTrajectoryControllerParameters, **values)
    for word in words:
        assert word in text


def test_parameters_never_change():
    """They are frozen."""
    p = JointTrajectoryControllerParameters(joints=['a'])
    with pytest.raises(ValidationError):
        p.cmd_timeout = 1.0


@pytest.mark.parametrize(
    ('gains', 'bounds'),
    [
        ({}, (-math.inf, math.inf)),
        ({'i_clamp': 2}, (-2.0, 2.0)),
        ({'i_clamp': 2, 'i_clamp_max': 1}, (-2.0, 1.0)),
        ({'i_clamp_min': -3, 'i_clamp_max': 1}, (-3.0, 1.0)),
    ],
)
def test_integral_bounds(gains, bounds):
    """B16, K6: i_clamp is symmetric; explicit bounds win."""
    assert PidGains(**gains).integral_bounds == bounds


def test_tolerances_that_are_not_positive():
    """C22: the parameter file bounds goal_time and max_deceleration_on_cancel alone."""
    block = {'trajectory': -1, 'goal': -0.5}
    constraints = {'a': block, 'stopped_velocity_tolerance': -1}
    p = JointTrajectoryControllerParameters(
        joints=['a'], constraints=constraints, cmd_timeout=-1)
    assert p.constraints.joints['a'].goal == -0.5
    negative = {'a': {'max_deceleration_on_cancel': -1}}
    assert 'max_deceleration_on_cancel' in problems(
        JointTrajectoryControllerParameters, joints=['a'], constraints=negative)


def test_broadcaster_parameters():
    """M2, M6: defaults; extra joints as names or as blocks."""
    p = JointStateBroadcasterParameters(extra_joints=['x', {'name': 'y', 'velocity': 1}])
    assert (p.frame_id, p.use_local_topics, p.use_urdf_to_filter) == ('base_link', False, True)
    assert [(e.name, e.velocity) for e in p.extra_joints] == [('x', 0.0), ('y', 1.0)]
    assert math.isinf(p.publish_rate)
    assert all(read_only(JointStateBroadcasterParameters, n) for n in p.model_dump()
               if n != 'map_interface_to_joint_state')
    assert 'publish_rate' in problems(JointStateBroadcasterParameters, publish_rate=math.nan)


def test_gripper_parameters():
    """N1, N2: defaults of both kinds; gains belong to the joint."""
    p = GripperActionControllerParameters(joint='g')
    assert (p.goal_tolerance, p.stall_timeout, p.stall_velocity_threshold) == (0.01, 1.0, 0.001)
    assert list(p.gains) == ['g']
    q = ParallelGripperActionControllerParameters(joint='g')
    assert (q.max_velocity, q.max_effort, q.max_effort_interface) == (0.1, 10.0, '')
    assert "'h'" in problems(GripperActionControllerParameters, joint='g', gains={'h': {}})
    assert 'joint' in problems(GripperActionControllerParameters, joint='')


def test_manager_parameters():
    """P7: its own keys, and one block with a type for each controller."""
    p = ControllerManagerParameters(
        update_rate=500, arm={'type': 'x', 'params_file': 'f.yaml', 'fallback_controllers': ['b']}
    )
    assert p.controllers['arm'].type == 'x'
    assert p.controllers['arm'].params_file == ('f.yaml',)
    assert p.controllers['arm'].fallback_controllers == ('b',)
    assert ControllerManagerParameters().update_rate == 100
    assert "did you mean 'update_rate'" in problems(ControllerManagerParameters, update_rat=5)
    assert 'type' in problems(ControllerManagerParameters, arm={})


def test_stiffness_defaults():
    """Those of cartesian_compliance_controller.cpp, on_init."""
    assert list(StiffnessSettings().model_dump().values()) == [500.0] * 3 + [50.0] * 3


def test_rates_are_fixed_once_a_controller_is_loaded():
    """controller_interface_base.cpp, init and configure, reads them once."""
    assert all(read_only(ControllerParameters, name) for name in ControllerParameters.model_fields)
