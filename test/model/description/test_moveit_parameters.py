# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters that a package gives, as the builder of launch files returns them."""

import pytest

from armsim_ros.errors import ConfigError
from armsim_ros.model.description.moveit_parameters import MoveItParameters


@pytest.fixture
def parameters(small_package):
    """Return the parameters of the small package."""
    return MoveItParameters(small_package.folder)


def test_descriptions_are_read_through_xacro(parameters, small_package):
    """Mappings replace the arguments of the setup assistant; a path starts at the package."""
    assert '<link name="upper">' in parameters.robot_description()['robot_description']
    assert 'group="arm"' in parameters.robot_description_semantic()['robot_description_semantic']
    small_package.write('config/other.xacro', small_package.XACRO.format(
        '<xacro:arg name="tip" default="a"/><link name="$(arg tip)"/>'))
    text = parameters.robot_description('config/other.xacro', {'tip': 'b'})['robot_description']
    assert '<link name="b"/>' in text


def test_the_setup_assistants_arguments_hold_without_mappings(small_package):
    """moveit_configs_builder.py, robot_description: ``mappings or self.__urdf_xacro_args``."""
    small_package.write('.setup_assistant', (
        'moveit_setup_assistant_config:\n'
        '  urdf: {package: small_description, relative_path: urdf/x.xacro, '
        'xacro_args: "tip:=b"}\n'))
    small_package.remove('config/small.urdf.xacro')
    small_package.write('../description_folder/urdf/x.xacro', small_package.XACRO.format(
        '<xacro:arg name="tip" default="a"/><link name="$(arg tip)"/>'))
    parameters = MoveItParameters(small_package.folder)
    for mappings, tip in ((None, 'b'), ({}, 'b'), ({'tip': 'c'}, 'c')):
        description = parameters.robot_description(mappings=mappings)['robot_description']
        assert f'<link name="{tip}"/>' in description


def test_settings_come_nested_below_the_description(parameters, small_package):
    """The keys are those of ROS parameters."""
    small_package.write('config/kinematics.yaml', 'arm: {kinematics_solver: a/B}\n')
    small_package.write('config/joint_limits.yaml', 'joint_limits: {elbow: {max_velocity: 1}}\n')
    assert parameters.robot_description_kinematics() == {
        'robot_description_kinematics': {'arm': {'kinematics_solver': 'a/B'}}}
    assert parameters.joint_limits()['robot_description_planning'] == {
        'joint_limits': {'elbow': {'max_velocity': 1}}}
    assert parameters.pilz_cartesian_limits() == {'robot_description_planning': {}}
    execution = parameters.trajectory_execution(moveit_manage_controllers=False)
    assert execution['moveit_manage_controllers'] is False
    assert 'arm_controller' in execution['moveit_simple_controller_manager']


def test_a_file_that_is_named_must_be_there(parameters):
    """The usual file may be missing."""
    assert parameters.joint_limits() == {'robot_description_planning': {}}
    with pytest.raises(ConfigError, match=r'config/lost\.yaml'):
        parameters.joint_limits('config/lost.yaml')


def test_pipelines(parameters, small_package):
    """A file replaces the default; only OMPL's planners are added where they are absent."""
    small_package.write('config/ompl_planning.yaml', 'planning_plugins: [x]\n')
    small_package.write('config/mine_planning.yaml', 'planning_plugins: [y]\n')
    found = parameters.planning_pipelines()
    assert found['default_planning_pipeline'] == 'ompl'
    assert set(found['planning_pipelines']) == {
        'ompl', 'mine', 'pilz_industrial_motion_planner', 'chomp', 'stomp'}
    assert found['ompl']['planning_plugins'] == ['x']
    assert 'RRTConnectkConfigDefault' in found['ompl']['planner_configs']
    assert 'request_adapters' not in found['ompl']
    assert set(parameters.planning_pipelines(load_all=False)['planning_pipelines']) == {
        'ompl', 'mine'}
    one = parameters.planning_pipelines(pipelines=['chomp'])
    assert one['default_planning_pipeline'] == 'chomp'
    with pytest.raises(ConfigError, match="'lerp' is none of those"):
        parameters.planning_pipelines('lerp')


@pytest.mark.parametrize('text', ['sensors: []\n', "sensors: ['']\n", 'sensors:\n  - {}\n'])
def test_sensors_that_are_none(parameters, small_package, text):
    """An empty list, or an empty first entry, is no sensor."""
    small_package.write('config/sensors_3d.yaml', text)
    assert parameters.sensors_3d() == {}
    small_package.write('config/sensors_3d.yaml', 'sensors: [kinect]\n')
    assert parameters.sensors_3d() == {'sensors': ['kinect']}
    assert parameters.sensors_3d('config/absent.yaml') == {}
