# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a launch file's parameters of move_group become."""

import pytest

from armsim_ros.cli.node_arguments import NodeArguments, read_node_arguments
from armsim_ros.config.loading import load_robot_settings
from armsim_ros.config.ompl_planning import Planner
from armsim_ros.model.loading import load_robot_model
from armsim_ros.nodes.upstream.robot_programs import move_group_words, sensor_parameters
from armsim_ros.planning.context import settings_from_config

VALUES = {
    'sensors': ['kinect'], 'octomap_resolution': 0.02, 'kinect.max_range': 5.0,
    'kinect.sensor_plugin': 'occupancy_map_monitor/PointCloudOctomapUpdater',
    'kinetic.max_range': 1.0, 'planning_pipelines': ['ompl'],
}


def test_sensors_of_an_octomap_reach_the_node():
    """As MoveItConfigsBuilder.sensors_3d() gives them: flat, a prefix for each sensor."""
    assert sorted(sensor_parameters(VALUES)) == [
        'kinect.max_range', 'kinect.sensor_plugin', 'octomap_resolution', 'sensors']


def test_no_sensors_are_no_parameters():
    """A list that is empty or has an empty name asks for nothing."""
    assert not sensor_parameters({**VALUES, 'sensors': ['']})
    assert not sensor_parameters({**VALUES, 'sensors': []})
    assert not sensor_parameters({'octomap_resolution': 0.02})


@pytest.fixture
def started(tmp_path):
    """Return what gives the words that start move_group with some parameters."""
    robot = load_robot_model(load_robot_settings('sunday'))

    def words(**parameters):
        return move_group_words(NodeArguments('move_group', values={
            'robot_description': robot.urdf, 'robot_description_semantic': robot.srdf,
            'planning_pipelines': ['ompl'], **parameters}), tmp_path)

    return words


def test_parameters_of_the_objects_frames_reach_the_node(started):
    """tf_publisher_capability.cpp, initialize reads them from the node."""
    robot, *_ = started(
        capabilities='move_group/TfPublisher', planning_scene_tf_prefix='',
        planning_scene_frame_publishing_rate=30)
    planning = load_robot_settings(robot.removeprefix('robot:=')).planning_parameters
    assert planning.capabilities == ('move_group/TfPublisher',)
    assert planning.planning_scene_tf_prefix == ''
    assert planning.planning_scene_frame_publishing_rate == 30.0


PILZ = {'planning_plugins': ['pilz_industrial_motion_planner/CommandPlanner']}
MINE = {'planner_configs': {'Mine': {'type': 'geometric::RRT', 'range': 0.5}},
        'manipulator': {'planner_configs': ['Mine']}}
OMPL = {'planning_plugins': ['ompl_interface/OMPLPlanner'], **MINE}


@pytest.fixture
def planned(started):
    """Return what gives the planning settings of move_group with some parameters."""
    def settings(**parameters):
        robot, *_ = started(**flat(parameters))
        found = load_robot_settings(robot.removeprefix('robot:='))
        return settings_from_config(
            found.planning_parameters, found.pipelines, found.kinematics)

    return settings


def flat(values, prefix=''):
    """Return parameters with the names that launch_ros gives them."""
    found = {}
    for name, value in values.items():
        nested = isinstance(value, dict)
        found.update(flat(value, f'{prefix}{name}.') if nested else {f'{prefix}{name}': value})
    return found


@pytest.mark.parametrize('names', [['pilz', 'ompl'], ['ompl', 'pilz'], ['pilz']])
def test_pipelines_keep_their_names_and_their_order(planned, names):
    """
    Without a default the first of the list is used.

    Upstream: move_group.cpp, main; prbt_moveit_config's demo.launch.py.
    """
    settings = planned(planning_pipelines=names, pilz=PILZ, ompl=OMPL)
    assert list(settings.pipelines) == names
    assert settings.default_pipeline == names[0]
    assert settings.pipelines['pilz'].planner is Planner.PILZ


@pytest.mark.parametrize('names', [['fast'], 'fast'])
def test_a_pipeline_of_ompl_with_a_name_of_its_own(planned, names):
    """The settings in its namespace are read; a single name needs no list."""
    settings = planned(planning_pipelines={'pipeline_names': names}, fast=OMPL)
    assert settings.pipelines['fast'].planners.configs['manipulator[Mine]']['range'] == 0.5


@pytest.mark.parametrize('block', [
    OMPL, {'planning_plugin': 'ompl_interface/OMPLPlanner', **MINE}, MINE,
])
def test_without_pipelines_the_namespace_of_the_node_is_one(planned, block):
    """
    Its parameters are those of the only pipeline, as in launch files up to Humble.

    Upstream: move_group.cpp, main; franka_ros2's moveit.launch.py.
    """
    settings = planned(planning_pipelines=[''], move_group=block)
    assert list(settings.pipelines) == [settings.default_pipeline] == ['move_group']
    found = settings.pipelines['move_group']
    assert found.planner is Planner.OMPL
    assert found.planners.configs['manipulator[Mine]']['range'] == 0.5


def test_a_pipeline_of_another_planner_is_left_out(planned, caplog):
    """A line names its plugin; the other pipelines are offered."""
    settings = planned(
        planning_pipelines=['chomp', 'ompl'], default_planning_pipeline='chomp', ompl=OMPL,
        chomp={'planning_plugins': ['chomp_interface/CHOMPPlanner']})
    assert list(settings.pipelines) == [settings.default_pipeline] == ['ompl']
    assert 'chomp_interface/CHOMPPlanner' in caplog.text


def test_capabilities_of_a_pipeline_reach_the_node(started):
    """move_group.cpp, configureCapabilities reads those of each pipeline from the node."""
    words = started(**{'ompl.capabilities': 'move_group/TfPublisher'})
    given = read_node_arguments(words[words.index('--ros-args'):], 'move_group').values
    assert given == {'ompl.capabilities': 'move_group/TfPublisher'}
