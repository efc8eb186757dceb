# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sensors of an octomap, as users' files have them."""

import pytest
from sensors_files import USUAL

from armsim_ros.config.sensors_3d import DepthImageSensor, PointCloudSensor
from armsim_ros.errors import ConfigError


@pytest.fixture
def load(files):
    """Return the function that reads a text as sensors_3d.yaml: settings and remarks."""
    def read(text):
        files.write('sensors_3d.yaml', text)
        settings = files.load()
        return settings.octomap, [str(one) for one in settings.remarks
                                  if 'sensors_3d.yaml' in str(one)]
    return read


def test_the_usual_file_is_read(load):
    """Whole numbers count as numbers."""
    found, remarks = load(USUAL)
    cloud, depth = found.sensors.values()
    assert (cloud.max_range, cloud.point_subsample) == (5.0, 2)
    assert isinstance(cloud, PointCloudSensor)
    assert isinstance(depth, DepthImageSensor)
    assert (depth.padding_scale, depth.padding_offset) == (4.0, 0.03)
    assert found.octomap_resolution == 0.02
    for text in ("'octomap_frame' has no effect", "'shadow_threshold' has no effect", 'defaults'):
        assert any(text in line for line in remarks)
    assert all('defaults' in line or 'has no effect' in line for line in remarks)


def test_the_file_in_the_layout_of_ros_2_is_the_same(load):
    """Parameters of the node move_group, or of all nodes."""
    plain, _ = load(USUAL)
    nested = '/**:\n  ros__parameters:\n' + '\n'.join(
        f'    {line}' for line in USUAL.splitlines())
    assert load(nested)[0] == plain


@pytest.mark.parametrize('text', ['sensors: []\n', "sensors: ['']\n", 'octomap_frame: base\n'])
def test_no_sensor_is_no_updater(load, text):
    """A list that is empty or starts with an empty name asks for nothing."""
    assert not load(text)[0].sensors


@pytest.mark.parametrize(('skipped', 'topic', 'prefix'), [
    ('  skip_vertical_pixels: 2\n  skip_horizontal_pixels: 3\n', 'filtered_cloud', 'eye'),
    ('  skip_vertical_pixels: 2\n', '', ''),
    ('', '', ''),
])
def test_the_topic_of_filtered_images_counts_only_beside_all_other_keys(
        load, skipped, topic, prefix):
    """moveit_ros depth_image_octomap_updater.cpp, setParams stops at the first absent key."""
    found, remarks = load(f'{USUAL}{skipped}  ns: eye\n')
    depth = found.sensors['kinect_depthimage']
    assert (depth.filtered_cloud_topic, depth.ns) == (topic, prefix)
    for key in ('filtered_cloud_topic', 'ns'):
        assert any(f"'{key}' has no effect without" in line for line in remarks) == (not topic)


def test_absent_keys_have_defaults_that_are_named_once(load):
    """Upstream drops such a sensor without a word."""
    found, remarks = load(
        'sensors: [eye]\neye: {sensor_plugin: occupancy_map_monitor/PointCloudOctomapUpdater, '
        'point_cloud_topic: /p}\n')
    sensor = found.sensors['eye']
    assert (sensor.max_range, sensor.padding_offset, sensor.padding_scale) == (
        float('inf'), 0.0, 1.0)
    assert found.octomap_resolution == 0.1
    assert sum("no 'octomap_resolution'" in line for line in remarks) == 1
    assert not any('octomap_frame' in line for line in remarks)
    assert sum('defaults for max_range, padding_offset' in line for line in remarks) == 1


@pytest.mark.parametrize(('block', 'text'), [
    ('{sensor_plugin: a/B, point_cloud_topic: /p}', "plugin 'a/B' is not known"),
    ('{sensor_plugin: occupancy_map_monitor/PointCloudOctomapUpdater}',
     "'point_cloud_topic' is missing"),
    ('{sensor_plugin: occupancy_map_monitor/PointCloudOctomapUpdater, point_cloud_topic: /p, '
     'max_range: far}', "'max_range' is"),
    ('{sensor_plugin: ~off}', 'has no plugin and is left out'),
    ('3', 'has no block'),
])
def test_a_sensor_that_cannot_be_used_is_left_out(load, block, text):
    """The others go on."""
    found, remarks = load(USUAL.replace('sensors: [', 'sensors: [bad, ') + f'bad: {block}\n')
    assert list(found.sensors) == ['kinect_pointcloud', 'kinect_depthimage']
    assert sum(text in line for line in remarks) == 1


def test_what_is_no_name_of_a_sensor_is_left_out(load):
    """A number or a block in the list is a remark; the sensors behind it are read."""
    found, remarks = load(USUAL.replace('sensors: [', 'sensors: [3, {a: b}, '))
    assert list(found.sensors) == ['kinect_pointcloud', 'kinect_depthimage']
    assert sum("'sensors' has " in line for line in remarks) == 2


def test_a_resolution_that_is_none_is_an_error_line(load):
    """0 m is not a size of cells."""
    with pytest.raises(ConfigError, match=r"yaml:3:21: octomap: 'octomap_resolution' is the nu"):
        load(USUAL.replace('0.02', '0', 1))
