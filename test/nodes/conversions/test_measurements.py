# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Point clouds and depth images of any maker in arrays, and messages that are none."""

from array import array

import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField

from armsim_ros.config.sensors_3d import DepthImageSensor
from armsim_ros.nodes.conversions.measurements import (
    cloud_of_points,
    image_of_kept,
    points_of_cloud,
    points_of_depth,
)

POINTS = np.arange(36, dtype=np.float32).reshape(3, 4, 3)


def cloud(points=POINTS, *, offsets=(0, 4, 8), step=16, spare=0, big=False, **parts):
    """Return a cloud whose fields are somewhere in its points."""
    height, width = points.shape[:2]
    row = width * step + spare
    data = np.zeros(height * row, dtype=np.uint8)
    kind = '>f4' if big else '<f4'
    for axis, offset in enumerate(offsets):
        np.ndarray((height, width), kind, data, offset, (row, step))[:] = points[..., axis]
    fields = [PointField(name=name, offset=offset, datatype=7, count=1)
              for name, offset in zip('xyz', offsets, strict=True)]
    message = PointCloud2(height=height, width=width, fields=fields, is_bigendian=big,
                          point_step=step, row_step=row, data=array('B', data.tobytes()))
    for name, value in parts.items():
        setattr(message, name, value)
    return message


@pytest.mark.parametrize('layout', [
    {}, {'offsets': (0, 4, 8), 'step': 12}, {'offsets': (20, 4, 12), 'step': 32},
    {'big': True}, {'spare': 24}, {'offsets': (1, 6, 11), 'step': 17}])
def test_fields_may_be_anywhere(layout):
    """Any offset, step, row and byte order."""
    assert (points_of_cloud(cloud(**layout)) == POINTS.reshape(-1, 3)).all()
    assert (points_of_cloud(cloud(**layout), 2) == POINTS[::2, ::2].reshape(-1, 3)).all()


def test_points_that_are_not_finite_are_left_out():
    """NaN and infinity measure nothing; a cloud of nothing else is empty."""
    points = POINTS.copy()
    points[0, 0, 2], points[1, 1, 0] = np.nan, np.inf
    assert len(points_of_cloud(cloud(points))) == 10
    assert points_of_cloud(cloud(np.full((3, 4, 3), np.nan, np.float32))).shape == (0, 3)
    assert points_of_cloud(cloud(height=0, data=[])).shape == (0, 3)


@pytest.mark.parametrize(('parts', 'text'), [
    ({'fields': []}, 'no field x, y, z; its fields: none'),
    ({'fields': [PointField(name=name, offset=0, datatype=8, count=1) for name in 'xyz']},
     "'x' of the cloud has the type 8"),
    ({'point_step': 8}, "'y' of the cloud begins at byte 4|'z' of the cloud begins at byte 8"),
    ({'row_step': 10}, 'rows of the cloud have 10 bytes'),
    ({'height': 9}, 'has 192 bytes; 9 x 4 points'),
    ({'data': []}, 'has 0 bytes'),
])
def test_clouds_that_cannot_be_read_are_named(parts, text):
    """Each has a sentence of its own."""
    with pytest.raises(ValueError, match=text):
        points_of_cloud(cloud(**parts))


def test_points_go_back_into_a_cloud():
    """A single row of x, y and z with the header of the input."""
    message = cloud()
    message.header.frame_id = 'eye'
    found = cloud_of_points(points_of_cloud(message)[:5], message)
    assert (found.height, found.width, found.point_step, found.is_dense) == (1, 5, 12, True)
    assert found.header.frame_id == 'eye'
    assert (points_of_cloud(found) == POINTS.reshape(-1, 3)[:5]).all()


WIDE = DepthImageSensor(skip_vertical_pixels=0, skip_horizontal_pixels=0)
INFO = CameraInfo(height=2, width=3, k=[2.0, 0, 1.0, 0, 4.0, 0.5, 0, 0, 1.0])


def image(depth, encoding='32FC1', **parts):
    """Return a depth image."""
    pixels = np.array(depth, dtype={'32FC1': '<f4', '16UC1': '<u2'}.get(encoding, '<u2'))
    message = Image(height=pixels.shape[0], width=pixels.shape[1], encoding=encoding,
                    step=pixels[0].nbytes, data=array('B', pixels.tobytes()))
    for name, value in parts.items():
        setattr(message, name, value)
    return message


def test_depth_becomes_points():
    """By the camera's matrix; what is too near is nothing, what is too far is a ray."""
    found = points_of_depth(
        image([[1.0, 0.1, np.inf], [np.nan, 2.0, 7.0]]), INFO, WIDE)
    assert found.points == pytest.approx(np.array([[-0.5, -0.125, 1.0], [0.0, 0.25, 2.0]]))
    assert found.pixels.tolist() == [0, 4]
    assert found.beyond == pytest.approx(np.array([[2.5, -0.625, 5.0], [2.5, 0.625, 5.0]]))


def test_depth_in_millimetres_and_the_border():
    """0 is no depth; rows and columns at the border do not count."""
    found = points_of_depth(image([[1000, 0, 500], [0, 2000, 0]], '16UC1'), INFO, WIDE)
    assert found.points[:, 2] == pytest.approx([1.0, 0.5, 2.0])
    assert not len(found.beyond)
    narrow = DepthImageSensor(skip_vertical_pixels=0, skip_horizontal_pixels=1)
    found = points_of_depth(image([[1000, 900, 500], [0, 2000, 0]], '16UC1'), INFO, narrow)
    assert found.pixels.tolist() == [1, 4]


def test_filtered_image_has_what_is_left():
    """In whole millimetres, 0 elsewhere."""
    message = image([[1.0, 1.5, 2.0], [1.0, 1.0, 1.0]])
    found = image_of_kept(message, np.array([0, 1, 2]), np.array([True, False, True]))
    assert found.encoding == '16UC1'
    assert np.frombuffer(found.data, '<u2').tolist() == [1000, 0, 2000, 0, 0, 0]


@pytest.mark.parametrize(('message', 'info', 'text'), [
    (image([[1.0]], encoding='rgb8'), INFO, "encoding 'rgb8'"),
    (image([[1.0, 1.0, 1.0]] * 2, data=[]), INFO, 'has 0 bytes'),
    (image([[1.0, 1.0]]), INFO, 'has 2 x 1 pixels, its camera_info 3 x 2'),
    (image([[1.0, 1.0, 1.0]] * 2), CameraInfo(height=2, width=3), 'focal lengths 0.0'),
])
def test_images_that_cannot_be_read_are_named(message, info, text):
    """Each has a sentence of its own."""
    with pytest.raises(ValueError, match=text):
        points_of_depth(message, info, WIDE)
