# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the trajectory controller: names, defaults, what is refused and when."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
import math
from statistics import median
from typing import Any

from controller_bench import Bench, TrajectoryController
import pytest

from armsim_ros.clients.controller_manager import ParameterClient

statement = pytest.mark.statement
upstream = pytest.mark.upstream
Load = Callable[..., bool]

#: Statement, name, default, whether it is fixed once the controller is loaded.
DEFAULTS: tuple[tuple[str, str, Any, bool], ...] = (
    ('B1', 'joints', ['axis_1', 'axis_2'], True),
    ('B2', 'command_joints', None, True),
    ('B3', 'command_interfaces', ['position'], True),
    ('B4', 'state_interfaces', ['position', 'velocity'], True),
    ('B6', 'allow_partial_joints_goal', False, False),
    ('B7', 'allow_integration_in_goal_trajectories', False, False),
    ('B8', 'allow_nonzero_velocity_at_trajectory_end', False, False),
    ('B9', 'interpolate_from_desired_state', None, True),
    ('B10', 'open_loop_control', False, True),
    ('B11', 'set_last_command_interface_value_as_state_on_activation', True, False),
    ('B12', 'action_monitor_rate', 20.0, True),
    ('B13', 'interpolation_method', 'splines', True),
    ('B14', 'cmd_timeout', 0.0, False),
    ('B15', 'speed_scaling.initial_scaling_factor', 1.0, True),
    ('B15', 'speed_scaling.state_interface', '', True),
    ('B15', 'speed_scaling.command_interface', '', True),
    ('B17', 'constraints.stopped_velocity_tolerance', 0.01, False),
    ('B17', 'constraints.goal_time', 0.0, False),
    ('B17', 'constraints.decelerate_on_cancel', False, True),
    ('B17', 'constraints.axis_1.trajectory', 0.0, False),
    ('B17', 'constraints.axis_1.goal', 0.0, False),
    ('B17', 'constraints.axis_1.max_deceleration_on_cancel', 0.0, True),
)
GAINS: tuple[tuple[str, Any, bool], ...] = (
    ('i', 0.0, False),
    ('i_clamp', math.inf, False),
    ('i_clamp_max', math.inf, False),
    ('i_clamp_min', -math.inf, False),
    ('u_clamp_max', math.inf, False),
    ('u_clamp_min', -math.inf, False),
    ('antiwindup_strategy', 'legacy', True),
    ('tracking_time_constant', 0.0, False),
    ('error_deadband', 0.0, False),
)


@pytest.mark.parametrize(
    ('name', 'default', 'read_only'),
    [pytest.param(*row[1:], id=row[1], marks=statement(row[0])) for row in DEFAULTS],
)
def test_defaults(arm: TrajectoryController, name: str, default: Any, read_only: bool) -> None:
    """The parameter has Jazzy's default (but for U1), a description, and is fixed or live."""
    described = arm.parameters.describe(name)
    assert described.description
    assert described.read_only is read_only
    if default is not None:
        assert arm.parameters.get(name) == default


@statement('B16')
@pytest.mark.parametrize(('name', 'default', 'read_only'), GAINS, ids=[g[0] for g in GAINS])
def test_defaults_of_gains(bench: Bench, name: str, default: Any, read_only: bool) -> None:
    """gains.<joint>.* have the defaults of Jazzy."""
    bench.activate('velocity_drives')
    parameters = ParameterClient(bench.client, bench.name('velocity_drives'))
    assert parameters.get(f'gains.drive_1.{name}') == default
    assert parameters.describe(f'gains.drive_1.{name}').read_only is read_only


@statement('B22', 'B1', 'B3', 'B4', 'B12', 'B13', 'B15', 'B17')
@upstream('incorrect_initialization_using_interface_parameters')
@pytest.mark.parametrize(
    'parameters',
    [
        {'joints': []},
        {'joints': ['axis_1', 'axis_1']},
        {'command_interfaces': []},
        {'command_interfaces': ['velocity', 'acceleration']},
        {'command_interfaces': ['acceleration']},
        {'command_interfaces': ['effort', 'velocity']},
        {'command_interfaces': ['torque']},
        {'state_interfaces': []},
        {'state_interfaces': ['velocity']},
        {'state_interfaces': ['position', 'acceleration']},
        {'action_monitor_rate': 0.01},
        {'interpolation_method': 'linear'},
        {'speed_scaling': {'initial_scaling_factor': -0.5}},
        {'constraints': {'goal_time': -1.0}},
        {'constraints': {'axis_1': {'max_deceleration_on_cancel': -1.0}}},
        {'joints': None},
    ],
    ids=str,
)
def test_illegal_parameters_are_not_loaded(load: Load, parameters: dict[str, Any]) -> None:
    """A value outside of what is legal: load_controller says no."""
    assert not load('illegal', **parameters)


@statement('B3')
@pytest.mark.parametrize(
    'interfaces',
    [['position'], ['position', 'velocity'], ['position', 'velocity', 'acceleration'],
     ['position', 'acceleration'],
     ['velocity'], ['effort'], ['position', 'effort']],
    ids='+'.join,
)
def test_legal_sets_of_command_interfaces(
    bench: Bench, load: Load, interfaces: list[str]
) -> None:
    """All legal sets can be configured (validate_jtc_parameters.hpp)."""
    assert load('legal', command_interfaces=interfaces)
    assert bench.manager.configure('legal')


@statement('B5')
@pytest.mark.parametrize('interfaces', [['velocity'], ['effort'], ['position', 'effort']])
def test_loops_need_a_velocity_state(bench: Bench, load: Load, interfaces: list[str]) -> None:
    """Without a velocity state they load and cannot be configured."""
    assert load('blind', command_interfaces=interfaces, state_interfaces=['position'])
    assert not bench.manager.configure('blind')


@statement('B2')
@upstream('check_interface_names_with_command_joints_greater_than_dof')
@pytest.mark.parametrize('joints', [['drive_1'], ['axis_1', 'axis_2', 'drive_1']])
def test_command_joints_are_a_subset(bench: Bench, load: Load, joints: list[str]) -> None:
    """More command joints than joints, or fewer that are others: it cannot be configured."""
    assert not (load('foreign', command_joints=joints) and bench.manager.configure('foreign'))


@statement('B10')
def test_open_loop_control_is_taken(bench: Bench, load: Load) -> None:
    """The deprecated parameter still works."""
    assert load('open_loop', open_loop_control=True)
    assert bench.manager.configure('open_loop')


@statement('B15')
@upstream('wrong_scaling_state_interface_fails_activation',
          'wrong_scaling_command_interface_fails_activation')
@pytest.mark.parametrize('kind', ['state_interface', 'command_interface'])
def test_unknown_interfaces_of_the_pace(bench: Bench, load: Load, kind: str) -> None:
    """An interface of the pace that nobody offers makes activation fail."""
    assert load('ill_paced', speed_scaling={kind: 'nobody/speed'})
    assert bench.manager.configure('ill_paced')
    assert not bench.manager.switch(activate=['ill_paced']).ok


@statement('B20', 'U3')
def test_parameters_of_ros_1_are_tolerated(bench: Bench, load: Load) -> None:
    """state_publish_rate, stop_trajectory_duration, velocity_ff and others do no harm."""
    assert load(
        'of_ros_1', state_publish_rate=25.0, stop_trajectory_duration=0.5,
        hold_trajectory_duration=0.5, verbose=True, velocity_ff={'axis_1': 1.0},
    )
    assert bench.manager.configure('of_ros_1')
    parameters = ParameterClient(bench.client, bench.name('of_ros_1'))
    assert parameters.get('state_publish_rate') == 25.0
    assert parameters.get('stop_trajectory_duration') == 0.5


@statement('U3', 'A15')
def test_state_publish_rate_is_honoured(bench: Bench, load: Load) -> None:
    """state_publish_rate 25 gives 25 states a second."""
    assert load('calm', state_publish_rate=25.0)
    assert bench.manager.configure('calm')
    c = bench.use('calm')
    stamps = [s.header.stamp.sec + s.header.stamp.nanosec * 1e-9 for s in c.watch(26)]
    # The middle one: an update that is late delays the state that is due with it.
    assert median(b - a for a, b in pairwise(stamps)) == pytest.approx(0.04, abs=0.005)
    bench.activate()


@statement('B22')
@upstream('update_dynamic_parameters')
@pytest.mark.parametrize(
    ('name', 'value'),
    [('constraints.goal_time', -1.0), ('joints', ['axis_1']), ('command_interfaces', ['effort']),
     ('constraints.goal_time', 'soon')],
)
def test_illegal_changes_are_refused(arm: TrajectoryController, name: str, value: Any) -> None:
    """A change to an illegal value, or of a fixed parameter, is refused with a reason."""
    before = arm.parameters.get(name)
    assert arm.parameters.set(name, value) != ''
    assert arm.parameters.get(name) == before


@statement('B6', 'B8')
@upstream('update_dynamic_parameters')
def test_live_parameters_act_on_the_next_goal(arm: TrajectoryController) -> None:
    """allow_partial_joints_goal can be switched on and off while it runs."""
    partial = arm.trajectory(arm.to([0.0]).points[0], joints=['axis_1'])
    assert not arm.goal(partial).accepted()
    assert arm.parameters.set('allow_partial_joints_goal', True) == ''
    try:
        assert arm.run(partial).error_code == 0
    finally:
        assert arm.parameters.set('allow_partial_joints_goal', False) == ''
    assert not arm.goal(partial).accepted()
