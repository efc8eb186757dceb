# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a launch file's parameters of move_group become."""

from armsim_ros.nodes.upstream.robot_programs import sensor_parameters

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
