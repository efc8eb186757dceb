"""A wrong value in a file of a published package: the other values of its block count."""

import pytest

from armsim_ros.errors import Severity
from armsim_ros.model.cell_loading import survey_cell


@pytest.fixture
def settings_of(small_package):
    """Return a function from a file's name and text to the settings and the warnings."""
    def read(name, text):
        small_package.write(f'config/{name}', text)
        found = survey_cell(str(small_package.folder))
        assert not [str(one) for one in found.problems if one.severity is Severity.ERROR]
        warnings = [one.what for one in found.problems if one.severity is Severity.WARNING]
        return found.settings, warnings
    return read


def test_a_wrong_scaling_factor_leaves_the_limits(settings_of):
    """The factors are read by clients alone (robot_model_loader.cpp, configure)."""
    settings, warnings = settings_of('joint_limits.yaml', (
        'default_velocity_scaling_factor: 1.5\n'
        'joint_limits:\n  shoulder: {has_velocity_limits: true, max_velocity: 0.2}\n'))
    assert settings.joint_limits.joint_limits['shoulder'].velocity == 0.2
    assert settings.joint_limits.default_velocity_scaling_factor == 0.1
    assert any("'default_velocity_scaling_factor'" in text for text in warnings)


@pytest.mark.parametrize('value', ['-1.0', '0.0', 'quick'])
def test_each_limit_of_a_joint_is_read_by_itself(settings_of, value):
    """A wrong acceleration leaves the velocity (robot_model_loader.cpp, configure)."""
    settings, _ = settings_of('joint_limits.yaml', (
        'joint_limits:\n  shoulder:\n    has_velocity_limits: true\n    max_velocity: 0.2\n'
        f'    has_acceleration_limits: true\n    max_acceleration: {value}\n'))
    limits = settings.joint_limits.joint_limits['shoulder']
    assert (limits.velocity, limits.acceleration) == (0.2, None)


def test_a_deceleration_may_have_any_sign(settings_of):
    """cartesian_limits_parameters.yaml gives max_trans_dec no range."""
    settings, warnings = settings_of('pilz_cartesian_limits.yaml', (
        'cartesian_limits: {max_trans_vel: 0.1, max_trans_acc: 0.2, max_trans_dec: 0.5,\n'
        '                   max_rot_vel: 0.3}\n'))
    assert settings.planning_parameters.cartesian_limits.max_trans_vel == 0.1
    assert not any('max_trans_dec' in text for text in warnings)


def test_a_planner_without_a_type_leaves_the_others(settings_of):
    """ompl_interface.cpp (loadPlannerConfiguration) reads planner by planner."""
    settings, _ = settings_of('ompl_planning.yaml', (
        'planning_plugins: [ompl_interface/OMPLPlanner]\n'
        'planner_configs:\n  Typed: {type: geometric::RRT}\n  Odd: {range: 0.1}\n'
        'arm: {planner_configs: [Typed], default_planner_config: Typed}\n'))
    assert set(settings.pipelines['ompl'].planner_configs) == {'Typed'}
    assert settings.pipelines['ompl'].groups['arm'].default_planner_config == 'Typed'


def test_a_list_with_a_wrong_item_has_its_default(settings_of):
    """Part of a list would mean something else; its neighbours count."""
    settings, _ = settings_of('ompl_planning.yaml', (
        'planning_plugins: [ompl_interface/OMPLPlanner]\n'
        'arm: {planner_configs: [RRT, 2], default_planner_config: RRT}\n'))
    group = settings.pipelines['ompl'].groups['arm']
    assert (group.planner_configs, group.default_planner_config) == ((), 'RRT')


def test_a_wrong_margin_leaves_the_start_tolerance(small_package, settings_of):
    """Parameters of the execution are read one by one."""
    settings, _ = settings_of('moveit_controllers.yaml', small_package.MOVEIT + (
        'trajectory_execution: {allowed_goal_duration_margin: -0.5,\n'
        '                       allowed_start_tolerance: 0.05}\n'))
    execution = settings.trajectory_execution
    assert execution.allowed_start_tolerance == 0.05
    assert execution.allowed_goal_duration_margin == 0.5
