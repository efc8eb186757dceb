# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What of a sensor's messages is read, and what is published of the points that are left."""

from array import array

import numpy as np
from octomap_bench import Bench
from rclpy.qos import qos_profile_sensor_data, QoSReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image
from sensors_files import USUAL

from armsim_ros.config.sensors_3d import (
    DepthImageSensor,
    OctomapSettings,
    PointCloudSensor,
    read_sensors_file,
)


def test_rate_and_filtered_cloud(monkeypatch):
    """Clouds that come too soon are not read; what is left of the others is published."""
    bench = Bench(monkeypatch, PointCloudSensor(
        point_cloud_topic='/cloud', max_update_rate=2.0, max_range=6.0,
        filtered_cloud_topic='left', ns='eye'))
    bench.state(1.0)
    bench.node.listeners = 1
    for _ in range(4):
        bench.send([[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 0.0, 8.0]], 1.0)
        bench.work()
        bench.now += 0.3
    assert bench.node.advertised == {'eye/left': qos_profile_sensor_data}
    assert [message.width for message in bench.node.published] == [2, 2]


def test_a_filtered_image_has_its_camera_info_beside_it(monkeypatch):
    """
    Both are reliable and have the stamp of the image that was measured.

    moveit_ros depth_image_octomap_updater.cpp, start and depthImageCallback.
    """
    bench = Bench(monkeypatch, DepthImageSensor(
        image_topic='/eye/depth', filtered_cloud_topic='left/image', ns='eye'))
    bench.node.listeners = 1
    bench.state(1.0)
    info = CameraInfo(width=32, height=24, k=[30.0, 0.0, 16.0, 0.0, 30.0, 12.0, 0.0, 0.0, 1.0])
    bench.topics['/eye/camera_info'](info)
    image = Image(width=32, height=24, encoding='32FC1', step=128,
                  data=array('B', np.full(32 * 24, 2.0, dtype=np.float32).tobytes()))
    image.header.frame_id, image.header.stamp.sec = bench.frame, 1
    bench.topics['/eye/depth'](image)
    bench.work()
    assert {topic: profile.reliability for topic, profile in bench.node.advertised.items()} == {
        'eye/left/image': QoSReliabilityPolicy.RELIABLE,
        'eye/left/camera_info': QoSReliabilityPolicy.RELIABLE}
    filtered, beside = bench.node.published
    assert filtered.header == beside.header == image.header
    assert list(beside.k) == list(info.k)


def test_of_the_setup_assistants_sensors_the_clouds_have_the_topic(monkeypatch, tmp_path):
    """
    Its file names one topic for both, and lacks keys without which that of the images is not read.

    moveit_ros depth_image_octomap_updater.cpp, setParams.
    """
    file = tmp_path / 'sensors_3d.yaml'
    file.write_text(USUAL, 'utf-8')
    bench = Bench(monkeypatch, settings=read_sensors_file(file, []))
    assert set(bench.node.advertised) == {'filtered_cloud'}


def test_a_topic_of_two_types_is_the_first_sensors(monkeypatch):
    """The middleware would refuse the second; a warning names both sensors."""
    bench = Bench(monkeypatch, settings=OctomapSettings(sensors={
        'clouds': PointCloudSensor(point_cloud_topic='/cloud', filtered_cloud_topic='/left'),
        'images': DepthImageSensor(image_topic='/eye/depth', filtered_cloud_topic='left')}))
    assert set(bench.node.advertised) == {'/left'}
    warning, = [line for line in bench.lines if "'left'" in line]
    assert "'images'" in warning
    assert "'clouds'" in warning
