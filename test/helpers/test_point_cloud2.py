# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""sensor_msgs_py.point_cloud2: upstream's test_point_cloud2.py and what it leaves out."""

import array

import numpy as np
import pytest
from sensor_msgs.msg import PointField
from sensor_msgs_py import point_cloud2
from std_msgs.msg import Header

F32, U32 = PointField.FLOAT32, PointField.UINT32
FIELDS = [PointField(name='x', offset=0, datatype=F32, count=1),
          PointField(name='id', offset=8, datatype=U32, count=1),
          PointField(name='n', offset=12, datatype=F32, count=2)]


def test_points_come_back():
    """As arrays, lists and parts of them."""
    points = np.arange(12, dtype=np.float32).reshape(4, 3)
    points[1, 2] = np.nan
    cloud = point_cloud2.create_cloud_xyz32(Header(frame_id='camera'), points)
    assert (cloud.header.frame_id, cloud.width, cloud.height) == ('camera', 4, 1)
    assert (cloud.point_step, cloud.row_step, len(cloud.data)) == (12, 48, 48)
    np.testing.assert_array_equal(point_cloud2.read_points_numpy(cloud), points)
    np.testing.assert_array_equal(point_cloud2.read_points_numpy(cloud, ['z', 'x'], True),
                                  points[[0, 2, 3]][:, [2, 0]])
    listed = point_cloud2.read_points_list(cloud, ['x', 'y'], uvs=[3, 0])
    assert [tuple(point) for point in listed] == [(9, 10), (0, 1)]
    assert listed[0].y == 10


def test_fields_of_several_types_and_a_point_step():
    """Gaps stay, a field with several values becomes as many fields."""
    cloud = point_cloud2.create_cloud(
        Header(), FIELDS, [(1.5, 7, 2, 3), (2.5, 2**32 - 1, 4, 5)], point_step=24)
    assert cloud.point_step == 24
    points = point_cloud2.read_points(cloud)
    assert points.dtype.names == ('x', 'id', 'n_0', 'n_1')
    assert points['id'].tolist() == [7, 2**32 - 1]
    assert points[['x', 'n_1']].tolist() == [(1.5, 3), (2.5, 5)]
    again = point_cloud2.create_cloud(Header(), FIELDS, points, point_step=24)
    assert point_cloud2.read_points(again).tolist() == points.tolist()
    with pytest.raises(AssertionError, match='different types'):
        point_cloud2.read_points_numpy(cloud)
    assert point_cloud2.read_points_numpy(cloud, ['x']).tolist() == [[1.5], [2.5]]


def test_organized_clouds():
    """Two dimensions are width and height."""
    points = np.zeros((5, 3), point_cloud2.dtype_from_fields(FIELDS))
    points['id'] = np.arange(15).reshape(5, 3)
    cloud = point_cloud2.create_cloud(Header(), FIELDS, points)
    assert (cloud.width, cloud.height) == (5, 3)
    assert point_cloud2.read_points(cloud, reshape_organized_cloud=True)['id'].tolist() == (
        points['id'].tolist())


def test_other_byte_order():
    """Bytes are swapped, the message stays as it is."""
    cloud = point_cloud2.create_cloud_xyz32(Header(), [(1, 2, 3)])
    cloud.data = array.array('B', np.array([1, 2, 3], '>f4').tobytes())
    cloud.is_bigendian = True
    before = cloud.data.tobytes()
    assert point_cloud2.read_points_numpy(cloud).tolist() == [[1, 2, 3]]
    assert cloud.data.tobytes() == before


def test_empty_clouds():
    """No point is a cloud, too."""
    cloud = point_cloud2.create_cloud_xyz32(Header(), [])
    assert point_cloud2.read_points_list(cloud) == []


@pytest.mark.parametrize(('call', 'text'), [
    (lambda cloud: point_cloud2.read_points(cloud, ['w']), r"no fields \['w'\]"),
    (lambda cloud: point_cloud2.read_points(FIELDS), 'not a sensor_msgs'),
    (lambda cloud: point_cloud2.create_cloud(Header(), FIELDS, np.zeros((2, 4))), 'structured'),
    (lambda cloud: point_cloud2.create_cloud(
        Header(), FIELDS, np.zeros(2, [('x', 'f8')])), 'the fields need'),
    (lambda cloud: point_cloud2.dtype_from_fields([FIELDS[0], FIELDS[0]]), 'same name'),
])
def test_what_does_not_fit_is_said(call, text):
    """As upstream, these are assertions."""
    with pytest.raises(AssertionError, match=text):
        call(point_cloud2.create_cloud_xyz32(Header(), [(1, 2, 3)]))
