# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a launch file's parameters of move_group become."""

import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.model.loading import load_robot_model
from armsim_ros.nodes.upstream.node_parameters import NodeArguments, read_node_arguments
from armsim_ros.nodes.upstream.robot_programs import move_group_words, sensor_parameters

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


def test_capabilities_of_a_pipeline_reach_the_node(started):
    """move_group.cpp, configureCapabilities reads those of each pipeline from the node."""
    words = started(**{'ompl.capabilities': 'move_group/TfPublisher'})
    given = read_node_arguments(words[words.index('--ros-args'):], 'move_group').values
    assert given == {'ompl.capabilities': 'move_group/TfPublisher'}
