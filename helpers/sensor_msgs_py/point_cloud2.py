# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Between PointCloud2 messages and arrays."""

from __future__ import annotations

import array
from collections import namedtuple
from collections.abc import Iterable, Sequence
import sys
from typing import Any

import numpy as np
from numpy.lib.recfunctions import structured_to_unstructured, unstructured_to_structured
import numpy.typing as npt
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

DUMMY_FIELD_PREFIX = 'unnamed_field'

_TYPES = {
    PointField.INT8: 'i1', PointField.UINT8: 'u1', PointField.INT16: 'i2', PointField.UINT16: 'u2',
    PointField.INT32: 'i4', PointField.UINT32: 'u4', PointField.FLOAT32: 'f4',
    PointField.FLOAT64: 'f8',
}


def read_points(cloud: PointCloud2, field_names: Iterable[str] | None = None,
                skip_nans: bool = False, uvs: Iterable[int] | None = None,
                reshape_organized_cloud: bool = False) -> npt.NDArray[Any]:
    """
    Return the points as a structured array.

    :param field_names: the fields to read (default: all).
    :param skip_nans: leave points with a NaN out.
    :param uvs: the numbers of the points to read (default: all).
    :param reshape_organized_cloud: return an array of width times height, as upstream does.
    """
    if not isinstance(cloud, PointCloud2):
        raise AssertionError(f'{type(cloud).__name__} is not a sensor_msgs.msg.PointCloud2')
    points: npt.NDArray[Any] = np.ndarray(
        cloud.width * cloud.height, dtype_from_fields(cloud.fields, cloud.point_step),
        memoryview(cloud.data))
    if field_names is not None:
        names = list(field_names)
        missing = [name for name in names if name not in (points.dtype.names or ())]
        if missing:
            raise AssertionError(f'the cloud has no fields {missing}; it has {points.dtype.names}')
        points = points[names]
    if cloud.is_bigendian != (sys.byteorder == 'big'):
        points = points.byteswap()
    if skip_nans and not cloud.is_dense:
        keep = np.ones(len(points), bool)
        for name in points.dtype.names or ():
            keep &= ~np.isnan(points[name])
        points = points[keep]
    if uvs is not None:
        points = points[uvs if isinstance(uvs, np.ndarray) else np.fromiter(uvs, int)]
    if reshape_organized_cloud and cloud.height > 1:
        points = points.reshape(cloud.width, cloud.height)
    return points


def read_points_numpy(cloud: PointCloud2, field_names: Iterable[str] | None = None,
                      skip_nans: bool = False, uvs: Iterable[int] | None = None,
                      reshape_organized_cloud: bool = False) -> npt.NDArray[Any]:
    """Return the points as a plain array of points times fields; parameters as read_points."""
    names = None if field_names is None else list(field_names)
    types = {field.datatype for field in cloud.fields if names is None or field.name in names}
    if len(types) > 1:
        raise AssertionError('the fields have different types; use read_points()')
    return structured_to_unstructured(
        read_points(cloud, names, skip_nans, uvs, reshape_organized_cloud))


def read_points_list(cloud: PointCloud2, field_names: Iterable[str] | None = None,
                     skip_nans: bool = False, uvs: Iterable[int] | None = None) -> list[Any]:
    """Return the points as named tuples; parameters as read_points."""
    points = read_points(cloud, field_names, skip_nans, uvs)
    point_type = namedtuple('Point', points.dtype.names or ())  # type: ignore[misc] # names of run time
    return [point_type(*point) for point in points.tolist()]


def dtype_from_fields(fields: Iterable[PointField],
                      point_step: int | None = None) -> np.dtype[Any]:
    """
    Return the type of a structured array for a cloud's fields.

    A field with several values becomes as many fields: name_0, name_1 ...

    :param point_step: size of a point [B] (default: as the fields need).
    """
    names, formats, offsets = [], [], []
    for index, field in enumerate(fields):
        if not field.count:
            raise AssertionError(f"field '{field.name}' has the count 0")
        name = field.name or f'{DUMMY_FIELD_PREFIX}_{index}'
        kind = np.dtype(_TYPES[field.datatype])
        for number in range(field.count):
            names.append(name if field.count == 1 else f'{name}_{number}')
            formats.append(kind)
            offsets.append(field.offset + number * kind.itemsize)
    if len(set(names)) < len(names):
        raise AssertionError(f'two fields have the same name: {names}')
    layout: dict[str, Any] = {'names': names, 'formats': formats, 'offsets': offsets}
    if point_step is not None:
        layout['itemsize'] = point_step
    return np.dtype(layout)  # type: ignore[call-overload, no-any-return] # numpy's overloads


def create_cloud(header: Header, fields: Sequence[PointField], points: Any,
                 point_step: int | None = None) -> PointCloud2:
    """
    Return a cloud.

    :param points: an array, structured or of points times fields, or tuples. With one more
        dimension the cloud is organized.
    :param point_step: size of a point [B] (default: as the fields need).
    """
    kind = dtype_from_fields(fields, point_step)
    if not isinstance(points, np.ndarray):
        points = np.array([tuple(point) for point in points], kind)
    elif points.dtype.names is None:
        if len({field.datatype for field in fields}) > 1:
            raise AssertionError('the fields have different types; pass a structured array')
        points = unstructured_to_structured(points, kind)
    elif points.dtype != kind:
        raise AssertionError(f'the array has {points.dtype}, the fields need {kind}')
    if points.ndim > 2:
        raise AssertionError('an organized cloud has two dimensions')
    width, height = points.shape[0], points.shape[1] if points.ndim == 2 else 1
    cloud = PointCloud2(
        header=header, height=height, width=width, is_dense=False,
        is_bigendian=sys.byteorder == 'big', fields=list(fields), point_step=kind.itemsize,
        row_step=kind.itemsize * width)
    cloud.data = array.array('B', points.tobytes())
    return cloud


def create_cloud_xyz32(header: Header, points: Any) -> PointCloud2:
    """Return a cloud with the fields x, y, z of 32 bits each; points as in create_cloud."""
    return create_cloud(header, [
        PointField(name=name, offset=4 * index, datatype=PointField.FLOAT32, count=1)
        for index, name in enumerate('xyz')], points)
